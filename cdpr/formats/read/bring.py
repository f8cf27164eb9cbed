"""From files of other programs to robot and scenario files that load: recognised, read, checked, written."""

from __future__ import annotations

import itertools
import math
import os
import re
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from cdpr.errors import CdprError, FormatError, OutputError
from cdpr.fields import MAX_MAGNITUDE
from cdpr.formats.read import FORMATS
from cdpr.formats.read.choice import Choice
from cdpr.formats.read.imported import Imported, Motion
from cdpr.formats.read.limits import SECONDS, bounded
from cdpr.formats.read.unread import report
from cdpr.formats.read.xml import parse
from cdpr.log.files import create, replace, unwritable
from cdpr.scenario.files import UnreadableError
from cdpr.scenario.files import read as read_bytes
from cdpr.scenario.loader import load_robot, load_scenario
from cdpr.scenario.schema import Simulation
from cdpr.scenario.template.commented import with_comments

MOST_BYTES = 16 * 2**20
MOST_FILES = 10_000
SMALLEST = (
    "{dof: [x], platform: {mass: 1}, tension: {min: 0, max: 1}, cables: [{frame: [1, 0, 0], platform: [0, 0, 0]}]}"
)
HEAD = 2**12  # bytes, enough to see what a file is
# Keys at the left edge of our own files: robots, scenarios, and studies or designs.
OWN = (
    (b"platform", b"cables", b"tension"),
    (b"robot", b"simulation"),
    (b"robot", b"trajectory"),
    (b"scenario", b"axes"),
    (b"robot", b"region"),
)
ENDINGS = tuple(ending for each in FORMATS for ending in each.endings)


@dataclass
class Taken:
    """What became of one source.

    Attributes:
        source: the file.
        files: name and content of what is written of it; empty where it could not be read.
        left_out, warnings: as `Imported` has them.
        error: why it could not be read; "" where it was.
        own: number of files of cdpr in a folder, which need no import; `error` says so.
    """

    source: str
    files: dict[str, str] = field(default_factory=dict)
    left_out: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    error: str = ""
    own: int = 0


def import_any(
    path: str | os.PathLike[str],
    *,
    cable_set: str | None = None,
    trajectory: str | None = None,
    tension: tuple[float, float] | None = None,
    seconds: float = SECONDS,
) -> list[Taken]:
    """Return what became of a file, as `import_file`, or of all that can be read in a folder, as `import_folder`.

    Raises CdprError as `import_file`, and for a folder that holds nothing to read.
    """
    folder = Path(path)
    if not os.path.isdir(folder):  # of names that cannot be, too: reading tells what is wrong with them
        return [import_file(path, cable_set=cable_set, trajectory=trajectory, tension=tension, seconds=seconds)]
    if trajectory is not None:
        raise CdprError(f"{path}: is a folder, and a trajectory belongs to one robot: name its file")
    every = list(import_folder(folder, cable_set=cable_set, tension=tension, seconds=seconds))
    if not every:
        raise CdprError(f"{path}: this folder holds no file with an ending that is known: {', '.join(ENDINGS)}")
    return every


def import_file(
    path: str | os.PathLike[str],
    *,
    cable_set: str | None = None,
    trajectory: str | None = None,
    tension: tuple[float, float] | None = None,
    seconds: float = SECONDS,
) -> Taken:
    """Return robot and scenarios of a file of another program, as YAML that loads.

    Args:
        path: of the file; others of the same model are found beside it.
        cable_set: of CASPR, its default unless said.
        trajectory: a file that belongs to a robot of the Gazebo plug-in.
        tension: lowest and highest tension, N, of cables whose file limits none.
        seconds: of CPU time that reading may take, in a process of its own.

    Raises CdprError, FormatError among them, with file and line, where it is not known, unsound, or says what our
    robots cannot, or takes longer.
    """
    file = Path(path)
    choice = _choice(cable_set, trajectory, tension)

    def read() -> Taken:
        content = content_of(file)
        return _taken(file, _read(_reader(file, content), file, content, choice))

    _load(file)
    return bounded(read, str(path), seconds)


def import_folder(
    path: str | os.PathLike[str],
    *,
    cable_set: str | None = None,
    tension: tuple[float, float] | None = None,
    seconds: float = SECONDS,
) -> Iterator[Taken]:
    """Yield what became of each robot in a folder and those within; errors are told, not raised.

    Of robots that would be files of the same names the later ones get a number. Each file may take so many `seconds`.
    Our own YAML files are skipped; the last item has their number.
    """
    names: set[str] = set()
    choice = _choice(cable_set, None, tension)

    def read(file: Path) -> Taken | None:
        content = content_of(file)
        reader = _reader(file, content)
        if not reader.leads(file, content):
            return None
        return _apart(file, _read(reader, file, content, choice), names)

    own = 0
    for file in _files(Path(path)):
        try:
            if _is_own(file):
                own += 1
                continue
            _load(file)
            taken = bounded(partial(read, file), str(file), seconds)
        except CdprError as error:
            taken = Taken(str(file), error=str(error).splitlines()[0])
        if taken is not None:
            names |= taken.files.keys()
            yield taken
    if own:
        count = f"{own} YAML file{'s' * (own > 1)}"
        yield Taken(str(path), error=f"{path}: skipped {count} of cdpr's own format: no import needed", own=own)


def _is_own(file: Path) -> bool:
    """Return whether a file is a robot, scenario, study or design of our own, by its keys."""
    if file.suffix.lower() not in (".yaml", ".yml"):
        return False
    content = content_of(file)
    if any(import_module(each.module).recognise(content) for each in FORMATS):
        return False
    keys = set(re.findall(rb"^([a-z_]+):", content, re.MULTILINE))
    return any(keys.issuperset(these) for these in OWN)


def _load(file: Path) -> None:
    """Import what reading a file needs, once for all forks: each of them would have to."""
    _warm()
    try:
        begin = read_bytes(str(file), HEAD, ENDINGS)
    except UnreadableError:
        return
    for each in FORMATS:
        module = import_module(each.module)
        if module.recognise(begin) and hasattr(module, "load_library"):
            module.load_library()


@cache
def _warm() -> None:
    """Load one robot, so that what checks robots is built once and not in each fork."""
    load_robot("warm.yaml", text=SMALLEST)


def _choice(cable_set: str | None, trajectory: str | None, tension: tuple[float, float] | None) -> Choice:
    if tension is not None and not 0.0 <= tension[0] < tension[1] <= MAX_MAGNITUDE:
        raise CdprError(
            f"tension: expected 0 <= MIN < MAX <= {MAX_MAGNITUDE:g} N, got {tension[0]:g} and {tension[1]:g}"
        )
    return Choice(cable_set, None if trajectory is None else Path(trajectory), tension)


def write(taken: Taken, folder: Path, *, force: bool, otherwise: str = "choose another folder") -> list[Path]:
    """Write files into a folder, which is made.

    Raises OutputError, which leaves nothing where nothing was; unless forced it writes over nothing, not through a
    link either, and says what to do `otherwise`.
    """
    there = {name for name in taken.files if os.path.lexists(folder / name)}
    for name in taken.files:
        if name in there and not force:
            raise OutputError(f"'{folder / name}' is there already: it is not written over; {otherwise}")
    written: list[Path] = []
    if not taken.files:
        return written
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in taken.files.items():
            written.append(folder / name)
            if name in there:
                replace(written[-1], text)
            else:
                create(written[-1], text)
    except (OSError, OutputError) as error:
        for path in written:
            if path.name not in there:
                with suppress(OSError):
                    path.unlink(missing_ok=True)
        if isinstance(error, OutputError):
            raise
        raise unwritable(folder, error) from error
    return written


def content_of(path: Path) -> bytes:
    """Return what is in a file. Raises FormatError."""
    try:
        content = read_bytes(str(path), MOST_BYTES, ENDINGS)
    except UnreadableError as error:
        raise FormatError(str(error)) from None
    if len(content) > MOST_BYTES:
        raise FormatError(f"{path}: is larger than {MOST_BYTES // 2**20} MiB, and no robot")
    return content


def _reader(path: Path, content: bytes) -> ModuleType:
    for each in FORMATS:
        module = import_module(each.module)
        if module.recognise(content):
            return module
    if content.lstrip()[:1] == b"<":
        parse(content, str(path))  # where it is no sound XML, that is what is wrong
    names = ", ".join(each.name for each in FORMATS)
    ours = "; our own robots and scenarios need no import" if path.suffix in (".yaml", ".yml") else ""
    raise FormatError(f"{path}: is in no format that is known; there are {names}{ours}")


def _read(reader: ModuleType, path: Path, content: bytes, choice: Choice) -> Imported:
    """Return what a reader found; every element, attribute and key that it did not read is among `left_out`."""
    found: Imported = reader.read(path, content, choice)
    found.left_out += report(found.documents)
    return found


def _files(folder: Path) -> Iterator[Path]:
    """All files of a folder and those within whose ending some format has, in the order of their names."""
    count = 0
    for above, folders, names in os.walk(folder):
        folders.sort()
        for name in sorted(names):
            if name.lower().endswith(ENDINGS):
                count += 1
                if count > MOST_FILES:
                    raise FormatError(f"{folder}: holds more than {MOST_FILES} files; name one of its folders")
                yield Path(above) / name


def _apart(path: Path, found: Imported, names: set[str]) -> Taken:
    """Write texts under a name of which no file is among `names`."""
    given, taken = found.name, _taken(path, found)
    for count in itertools.count(2):
        if not names & taken.files.keys():
            return taken
        found.name = found.robot["name"] = f"{given}_{count}"
        taken = _taken(path, found)
    raise AssertionError("numbers do not end")


def _taken(path: Path, found: Imported) -> Taken:
    """Write texts, and load them: what our own checks refuse is told with its source."""
    robot, comments = f"{found.name}.yaml", found.comments
    taken = Taken(str(path), {}, found.left_out, found.warnings)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        motions = [_scenario(found, motion, robot, f"{path.parent}{os.sep}") for motion in found.motions]
        taken.files[robot] = with_comments(found.robot, lambda key: comments.get(key, ""), _head(found, path.parent))
        (folder / robot).write_text(taken.files[robot], encoding="utf-8")
        try:
            load_robot(folder / robot)
        except CdprError as error:
            place = _place(path, found, error)
            raise FormatError(f"{place}: it makes no robot that our checks accept: {_first(error)}") from None
        for motion, files in zip(found.motions, motions, strict=True):
            for each, text in files.items():
                (folder / each).write_text(text, encoding="utf-8")
            try:
                load_scenario(folder / next(iter(files)))
            except CdprError as error:
                taken.left_out.append(f"{path}: motion '{motion.name}': our checks refuse it: {_first(error)}")
            else:
                taken.files |= files
    head = _head(found, path.parent)  # now that all is known that is left out
    taken.files[robot] = with_comments(found.robot, lambda key: comments.get(key, ""), head)
    return taken


def _first(error: CdprError) -> str:
    """What the first line of an error says, without the file that is about to be written."""
    return str(error).splitlines()[0].partition(": ")[2]


def _place(path: Path, found: Imported, error: CdprError) -> str:
    """Where in the source the first thing stands that our checks refuse, by the comment on it; else the source."""
    key = error.rows[0].path if error.rows else ()
    if key[:1] == ("tension",) and len(key) == 3:
        key = ("cables", key[2])  # one limit for each
    while key and key not in found.comments:
        key = key[:-1]
    comment = found.comments.get(key, "")
    if (beside := re.search(r"(\S+\.\w+):(\d+)", comment)) is not None:
        return f"{path.parent / beside[1]}:{beside[2]}"
    line = re.search(r"\bline (\d+)", comment)
    return str(path) if line is None else f"{path}:{line[1]}"


def _whole(duration: float) -> float:
    """Return the duration that is a whole number of control steps, s, and no shorter."""
    step = Simulation.model_fields["control_step"].default
    return float(round(math.ceil(duration / step - 1e-6) * step, 9))


def _scenario(found: Imported, motion: Motion, robot: str, above: str) -> dict[str, str]:
    """A scenario, and the files that it names."""
    name = f"{found.name}_{motion.name}"
    tables = {f"{found.name}_{key}": value for key, value in motion.tables.items()}
    data: dict[str, Any] = {
        "robot": robot,
        "simulation": {"duration": _whole(motion.duration)},
        "initial": motion.initial,
        "trajectory": {**motion.trajectory, **({"file": next(iter(tables))} if tables else {})},
        **({} if motion.controller is None else {"controller": motion.controller}),
    }
    head = f"Motion '{motion.name}' of {found.source}.\nController and solver are ours.".replace(above, "")
    return {f"{name}.yaml": with_comments(data, lambda key: "", head), **tables}


def _head(found: Imported, folder: Path) -> str:
    """What stands above a robot, with names of files as they are in their folder: the same bytes wherever that is."""
    lines = [f"Imported from {found.source}.", *found.warnings]
    if found.left_out:
        lines += ["Left out:", *(f"- {each}" for each in found.left_out)]
    return "\n".join(lines).replace(f"{folder}{os.sep}", "")
