"""Examples that come with cdpr (scenarios, robots, studies and designs), found by their bare names."""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import yaml

from cdpr.base.errors import CdprError, OutputError
from cdpr.base.nearest import did_you_mean
from cdpr.log.files import create

Kind = Literal["scenario", "robot", "study", "design"]

PLACES: dict[Kind, str] = {
    "scenario": "*.yaml",
    "robot": "robots/*.yaml",
    "study": "studies/[!d]*.yaml",  # designs have the prefix design_
    "design": "studies/design_*.yaml",
}
USES: dict[Kind, str] = {  # hint if a command gets an example of another kind
    "scenario": "'cdpr run {name}' runs it",
    "robot": "'cdpr info {name}' describes it",
    "study": "'cdpr study {name}' runs it",
    "design": "'cdpr design {name}' runs it",
}


@dataclass(frozen=True)
class Example:
    """Example file."""

    kind: Kind
    path: Path

    @property
    def name(self) -> str:
        """Name by which it is found."""
        return self.path.stem

    @property
    def shows(self) -> str:
        """First sentence of the comment at its start."""
        lines = []
        for line in self.path.read_text(encoding="utf-8").splitlines():
            if not line.startswith("#"):
                break
            lines.append(line.lstrip("# ").strip())
        return re.split(r"(?<=\.)\s", " ".join(lines), maxsplit=1)[0]


def folder() -> Path:
    """Return the folder of the examples: in the package if installed, beside it in a checkout."""
    package = Path(__file__).parent.parent
    installed = package / "examples"
    return installed if installed.is_dir() else package.parent / "scenarios"


def examples() -> list[Example]:
    """Return all examples, scenarios first, each kind sorted by name."""
    return [Example(kind, path) for kind, files in PLACES.items() for path in sorted(folder().glob(files))]


def find(name: str, kind: Kind | None) -> Example | None:
    """Return the example of this name; without a kind, scenarios come before robots."""
    return next((one for one in examples() if one.name == name and kind in (None, one.kind)), None)


def resolve(path: str, kind: Kind | None) -> str:
    """Return `path` if it is a file, otherwise the path of the example of this name."""
    return beside("", path, kind)


def beside(folder: str, name: str, kind: Kind | None) -> str:
    """Return the path of a file referenced in `folder`: relative to it or, for a bare name, an example.

    An existing file hides an example of its name; a folder does not.
    """
    path = os.path.join(folder, name)
    example = None if os.path.exists(path) and not os.path.isdir(path) else find(name, kind)
    return path if example is None else str(example.path)


def is_run(what: object) -> bool:
    """Return True if `what` names a run: a log, or a folder that does not have the name of an example."""
    path = str(what) if isinstance(what, str | os.PathLike) else ""
    return path.endswith(".mcap") or (os.path.isdir(path) and find(path, None) is None)


def hint(path: str, kind: Kind | None) -> str:
    """Return a hint on a missing file if an example may be meant, else ""."""
    name = Path(path).stem
    if find(name, kind) is not None:
        return f"; for cdpr's example '{name}', give only the name"
    if path != name:  # not a bare name
        return ""
    if (other := find(name, None)) is not None:
        use = USES[other.kind].format(name=name)
        return f"; expected a {kind}, but this is the name of an example {other.kind}: {use}"
    near = did_you_mean(name, [one.name for one in examples() if kind in (None, one.kind)])
    return f", and no example has that name: {near}'cdpr examples' lists them"


def copy(name: str, to: Path) -> list[Path]:
    """Copy an example with its referenced files into a folder, preserving relative paths; return all copies.

    Raises:
        CdprError: if the example does not exist.
        OutputError: if a file exists or cannot be written.
    """
    example = find(name, None)
    if example is None:
        near = did_you_mean(name, [one.name for one in examples()])
        raise CdprError(f"there is no example '{name}': {near}'cdpr examples' lists them")
    needed = _needed(example.path, [])
    copies = {path: to / path.relative_to(folder()) for path in needed}
    for path in copies.values():
        if path.exists():
            raise OutputError(f"{path}: exists already; choose another folder or remove it")
    written: list[Path] = []
    try:
        for path, target in copies.items():
            target.parent.mkdir(parents=True, exist_ok=True)
            create(target, path.read_bytes())
            written.append(target)
    except OSError as error:
        for copied in written:  # a partial example is useless
            with contextlib.suppress(OSError):
                copied.unlink()
        raise OutputError(f"{target}: cannot be written: {error.strerror or error}") from error
    return list(copies.values())


def _needed(path: Path, found: list[Path]) -> list[Path]:
    """Return a file and all files it references, each once, in order of reference."""
    if path not in found:
        found.append(path)
        if path.suffix != ".yaml":
            return found
        for text in _texts(yaml.safe_load(path.read_text(encoding="utf-8"))):
            for start in (path.parent, folder()):  # values of a study are relative to its scenario
                other = Path(os.path.normpath(start / text))
                if other.suffix and other.is_file():
                    _needed(other, found)
    return found


def _texts(data: Any) -> Iterator[str]:
    """Yield all text values."""
    if isinstance(data, dict):
        data = list(data.values())
    for item in data if isinstance(data, list) else [data]:
        if isinstance(item, str):
            yield item
        elif isinstance(item, (dict, list)):
            yield from _texts(item)
