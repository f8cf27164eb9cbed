"""The examples that come with cdpr: scenarios, robots, studies and designs that a bare name finds, installed or not."""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import yaml

from cdpr.errors import CdprError, OutputError
from cdpr.log.files import create
from cdpr.nearest import did_you_mean

Kind = Literal["scenario", "robot", "study", "design"]

PLACES: dict[Kind, str] = {
    "scenario": "*.yaml",
    "robot": "robots/*.yaml",
    "study": "studies/[!d]*.yaml",  # those of designs begin with the word
    "design": "studies/design_*.yaml",
}
USES: dict[Kind, str] = {  # what a command says that was given a name of another kind
    "scenario": "'cdpr run {name}' runs it",
    "robot": "'cdpr info {name}' describes it",
    "study": "'cdpr study {name}' runs it",
    "design": "'cdpr design {name}' runs it",
}


@dataclass(frozen=True)
class Example:
    """One file that comes with cdpr."""

    kind: Kind
    path: Path

    @property
    def name(self) -> str:
        """What finds it."""
        return self.path.stem

    @property
    def shows(self) -> str:
        """The first sentence of the comment that it begins with."""
        lines = []
        for line in self.path.read_text(encoding="utf-8").splitlines():
            if not line.startswith("#"):
                break
            lines.append(line.lstrip("# ").strip())
        return re.split(r"(?<=\.)\s", " ".join(lines), maxsplit=1)[0]


def folder() -> Path:
    """Return where the examples are: in the package of an installation, beside it in a checkout."""
    package = Path(__file__).parent.parent
    installed = package / "examples"
    return installed if installed.is_dir() else package.parent / "scenarios"


def examples() -> list[Example]:
    """Return all examples, scenarios first, each kind by name."""
    return [Example(kind, path) for kind, files in PLACES.items() for path in sorted(folder().glob(files))]


def find(name: str, kind: Kind | None) -> Example | None:
    """Return the example of that name, a scenario before a robot where any kind will do."""
    return next((one for one in examples() if one.name == name and kind in (None, one.kind)), None)


def resolve(path: str, kind: Kind | None) -> str:
    """Return the file that is meant: the one of that path, or else, where that is a bare name, the example."""
    if os.path.exists(path) and not os.path.isdir(path):
        return path
    example = find(path, kind)
    return path if example is None else str(example.path)


def beside(folder: str, name: str, kind: Kind) -> str:
    """Return the file that another file in `folder` names: one relative to it or, of a bare name, the example."""
    path = os.path.join(folder, name)
    example = None if os.path.exists(path) else find(name, kind)
    return path if example is None else str(example.path)


def hint(path: str, kind: Kind | None) -> str:
    """Return what to say of a file that does not exist, where an example may have been meant; it may be empty."""
    name = Path(path).stem
    if find(name, kind) is not None:
        return f"; cdpr comes with an example '{name}': give that name alone"
    if path != name:  # no bare name
        return ""
    if (other := find(name, None)) is not None:
        use = USES[other.kind].format(name=name)
        return f"; it is the name of an example {other.kind}, but a {kind} is expected: {use}"
    near = did_you_mean(name, [one.name for one in examples() if kind in (None, one.kind)])
    return f", and no example has that name: {near}'cdpr examples' lists them"


def copy(name: str, to: Path) -> list[Path]:
    """Copy an example with the files that it names into a folder, as they lie to each other; return all copies.

    Raises CdprError where there is no such example, OutputError where a file is there already or cannot be written.
    """
    example = find(name, None)
    if example is None:
        near = did_you_mean(name, [one.name for one in examples()])
        raise CdprError(f"there is no example '{name}': {near}'cdpr examples' lists them")
    needed = _needed(example.path, [])
    copies = {path: to / path.relative_to(folder()) for path in needed}
    for path in copies.values():
        if path.exists():
            raise OutputError(f"{path}: exists already; choose another --to or remove it")
    written: list[Path] = []
    try:
        for path, target in copies.items():
            target.parent.mkdir(parents=True, exist_ok=True)
            create(target, path.read_bytes())
            written.append(target)
    except OSError as error:
        for copied in written:  # a part of an example is of no use
            with contextlib.suppress(OSError):
                copied.unlink()
        raise OutputError(f"{target}: cannot be written: {error.strerror or error}") from error
    return list(copies.values())


def _needed(path: Path, found: list[Path]) -> list[Path]:
    """Return a file and all that it names, each once, in the order in which they are named."""
    if path not in found:
        found.append(path)
        if path.suffix != ".yaml":
            return found
        for text in _texts(yaml.safe_load(path.read_text(encoding="utf-8"))):
            for start in (path.parent, folder()):  # a study's values start at its scenario
                other = Path(os.path.normpath(start / text))
                if other.suffix and other.is_file():
                    _needed(other, found)
    return found


def _texts(data: Any) -> Iterator[str]:
    """Yield all texts among the values."""
    if isinstance(data, dict):
        data = list(data.values())
    for item in data if isinstance(data, list) else [data]:
        if isinstance(item, str):
            yield item
        elif isinstance(item, (dict, list)):
            yield from _texts(item)
