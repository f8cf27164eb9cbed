"""Examination of an installation: components, their state, and remedies; without network access."""

from __future__ import annotations

import importlib.metadata
import os
import platform
import re
import shutil
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from cdpr.base.errors import CdprError
from cdpr.base.version import VERSION
from cdpr.fmu.export.library import compiler
from cdpr.native import operations as native
from cdpr.native.sources import digest
from cdpr.plugins.registry import DISABLE, ROLES, registry

State = Literal["ok", "missing", "wrong"]

DISTRIBUTION = "cdpr"
NOT_FOR_USE = ("all", "test")  # extras that combine others, or for developers of cdpr
REQUIREMENT = re.compile(r"\s*([\w.-]+)[^;]*(?:;\s*(.*))?")
EXTRA = re.compile(r"extra\s*==\s*['\"]([\w.-]+)['\"]")
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "firefox", "xdg-open")
SETTINGS = (
    "CDPR_DEBUG",
    DISABLE,
    native.VARIABLE,
    "XDG_CACHE_HOME",
    "XDG_CONFIG_HOME",
    "CC",
)


@dataclass(frozen=True)
class Finding:
    """Result for one component.

    Attributes:
        group: group of the component.
        name: name of the component.
        state: "missing" is a normal state; "wrong" means that it exists and does not work.
        text: version, path or reason.
        remedy: command or action if it does not work.
    """

    group: str
    name: str
    state: State
    text: str
    remedy: str = ""


def examine() -> Iterator[Finding]:
    """Yield all results, group by group."""
    yield Finding("versions", "cdpr", "ok", f"{VERSION} in {Path(__file__).parents[3]}")
    yield Finding("versions", "python", "ok", f"{platform.python_version()} in {sys.prefix}")
    yield Finding("versions", "system", "ok", f"{platform.system()} {platform.machine()}, {os.cpu_count()} processors")
    yield from libraries()
    yield from kernels()
    yield from plugins()
    yield from folders()
    yield from tools()
    for name in SETTINGS:
        if name in os.environ:
            yield Finding("settings", name, "ok", os.environ[name])


def libraries() -> Iterator[Finding]:
    """Yield the requirements of cdpr and its extras: their versions, or the extra that installs them."""
    try:
        required = importlib.metadata.requires(DISTRIBUTION) or []
    except importlib.metadata.PackageNotFoundError:
        yield Finding("libraries", DISTRIBUTION, "wrong", "is imported, not installed", f"pip install {DISTRIBUTION}")
        return
    extras: dict[str, list[str]] = {}
    for text in required:
        match = REQUIREMENT.fullmatch(text)
        if match is None or match[1] == DISTRIBUTION:
            continue
        extra = EXTRA.search(match[2] or "")
        if not extra or extra[1] not in NOT_FOR_USE:
            extras.setdefault(match[1], []).append(extra[1] if extra else "")
    for name, of in extras.items():
        group = "libraries" if "" in of else "extras"
        title = name if "" in of else f"{name} ({', '.join(of)})"
        try:
            yield Finding(group, title, "ok", importlib.metadata.version(name))
        except importlib.metadata.PackageNotFoundError:
            wanted = f"pip install '{DISTRIBUTION}[{of[0]}]'" if of[0] else f"pip install {name}"
            state: State = "missing" if of[0] else "wrong"
            yield Finding(group, title, state, "not installed, or not made for this Python and system", wanted)


def kernels() -> Iterator[Finding]:
    """Yield the kernel library: its compiler and the instruction set in use."""
    try:
        from cdpr.native import library

        chosen = native.target()
    except ImportError as error:
        remedy = f"reinstall {DISTRIBUTION}; in a checkout, run pip install --editable ."
        yield Finding("kernels", "library", "wrong", f"cannot be loaded: {error}", remedy)
    except CdprError as error:
        yield Finding(
            "kernels", "library", "wrong", str(error).partition(";")[0], f"correct or unset {native.VARIABLE}"
        )
    else:
        text = f"{library.__file__}, {len(native.operations())} operations, built by {library.compiler}"
        if digest() in (None, library.sources):
            yield Finding("kernels", "library", "ok", text)
        else:
            remedy = "run pip install --no-deps --editable . in the checkout"
            yield Finding("kernels", "library", "wrong", f"{library.__file__}, built from other C++ sources", remedy)
        others = ", ".join(name for name in native.targets() if name != chosen)
        yield Finding("kernels", "instruction set", "ok", f"{chosen}; also available: {others or 'none'}")


def plugins() -> Iterator[Finding]:
    """Yield each plugin with its state, then the problems of distributions with plugins."""
    found = registry()
    for role in ROLES:
        for name, entry in sorted(found.plugins[role].items()):
            if entry.missing:
                text = f"needs {', '.join(entry.missing)}, not installed"
                yield Finding(f"{role}s", name, "missing", text, entry.remedy)
                continue
            try:
                entry.load()
            except CdprError as error:
                yield Finding(
                    f"{role}s", name, "wrong", str(error), "reinstall the named package, or remove the plugin"
                )
            else:
                yield Finding(f"{role}s", name, "ok", f"{entry.distribution} {entry.version}")
    for problem in found.problems:
        yield Finding("plugins", "problem", "wrong", problem, f"remove that distribution, or set {DISABLE}=1")


def folders() -> Iterator[Finding]:
    """Yield the folders to which cdpr writes, with their free space."""
    try:
        yield _folder("temporary", Path(tempfile.gettempdir()), "set TMPDIR to a folder of yours")
    except OSError as error:
        yield Finding("folders", "temporary", "wrong", str(error), "set TMPDIR to a folder of yours")
    try:
        yield _folder("home", Path.home(), "set HOME")
    except RuntimeError as error:
        yield Finding("folders", "home", "wrong", str(error), "set HOME")
    remedy = "results go to --out DIR, or change to a folder of yours"
    try:
        yield _folder("here", Path.cwd(), remedy)
    except OSError as error:  # it was removed
        yield Finding("folders", "here", "wrong", f"cannot be found: {error.strerror}", remedy)


def _folder(name: str, path: Path, remedy: str) -> Finding:
    try:
        with tempfile.TemporaryFile(dir=path):
            free = shutil.disk_usage(path).free
    except OSError as error:
        return Finding("folders", name, "wrong", f"{path} cannot be written: {error.strerror}", remedy)
    return Finding("folders", name, "ok", f"{path}, {free / 1e9:.1f} GB free")


def tools() -> Iterator[Finding]:
    """Yield the C++ compiler, the browser and the display."""
    try:
        yield Finding("tools", "C++ compiler", "ok", " ".join(compiler()))
    except CdprError:
        text = "none: cdpr fmu export then needs --source-only"
        yield Finding("tools", "C++ compiler", "missing", text, "install one, such as the package g++")
    browser = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    if browser:
        yield Finding("tools", "browser", "ok", browser)
    else:
        text = "none found: open reports (report.html) in any browser, also on another machine"
        yield Finding("tools", "browser", "missing", text, "install one, or copy the page")
    display = os.environ.get("WAYLAND_DISPLAY") or os.environ.get("DISPLAY")
    text = "none: pages are not opened"
    yield Finding("tools", "display", "ok", display) if display else Finding("tools", "display", "missing", text)
