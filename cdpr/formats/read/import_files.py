"""Import of other programs' files as valid robot and scenario files: recognition, reading, validation and writing."""

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

from cdpr.base.errors import CdprError, FormatError, OutputError
from cdpr.base.fields import MAX_MAGNITUDE
from cdpr.base.files import UnreadableError
from cdpr.base.files import read as read_bytes
from cdpr.base.problems import shown
from cdpr.formats.read import FORMATS
from cdpr.formats.read.import_options import Choice
from cdpr.formats.read.imported import Imported, Motion
from cdpr.formats.read.limits import SECONDS, bounded
from cdpr.formats.read.unread import report
from cdpr.formats.read.xml import parse
from cdpr.log.files import create, replace, unwritable
from cdpr.model.frozen import given_name, given_numbers
from cdpr.scenario.loader import load_robot, load_scenario
from cdpr.scenario.schema import Simulation
from cdpr.scenario.template.commented import with_comments

MOST_BYTES = 16 * 2**20
MOST_FILES = 10_000
SMALLEST = (
    "{dof: [x], platform: {mass: 1}, tension: {min: 0, max: 1}, cables: [{frame: [1, 0, 0], platform: [0, 0, 0]}]}"
)
HEAD = 2**12  # bytes, enough to recognise a format
# Top-level keys of cdpr's own files: robots, scenarios, and studies or designs.
OWN = (
    (b"platform", b"cables", b"tension"),
    (b"robot", b"simulation"),
    (b"robot", b"trajectory"),
    (b"scenario", b"axes"),
    (b"robot", b"region"),
)
ENDINGS = tuple(dict.fromkeys(ending for each in FORMATS for ending in each.endings))


@dataclass
class ImportResult:
    """Result for one source file.

    Attributes:
        source: the file.
        files: name and content of each file to write; empty if reading failed.
        left_out: as in `Imported`.
        warnings: as in `Imported`.
        error: reason of a failure; "" on success.
        own: number of cdpr's own files in a folder, which need no import; `error` mentions them.
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
) -> list[ImportResult]:
    """Return the results for a file, as `import_file`, or for a folder, as `import_folder`.

    Raises:
        CdprError: as `import_file`, and if a folder contains nothing to read.
    """
    folder = Path(path)
    if not os.path.isdir(folder):  # False also for invalid names, which reading reports
        return [import_file(path, cable_set=cable_set, trajectory=trajectory, tension=tension, seconds=seconds)]
    if trajectory is not None:
        raise CdprError(f"{path}: is a folder; with a trajectory, give the file of its robot")
    every = list(import_folder(folder, cable_set=cable_set, tension=tension, seconds=seconds))
    if not every:
        raise CdprError(f"{path}: this folder contains no file of a supported format: {', '.join(ENDINGS)}")
    return every


def import_file(
    path: str | os.PathLike[str],
    *,
    cable_set: str | None = None,
    trajectory: str | None = None,
    tension: tuple[float, float] | None = None,
    seconds: float = SECONDS,
) -> ImportResult:
    """Return the robot and scenarios of another program's file, as valid YAML.

    Args:
        path: the file; other files of the same model are found next to it.
        cable_set: cable set of a CASPR model; defaults to the model's default.
        trajectory: trajectory file for a robot of the Gazebo plug-in.
        tension: lowest and highest tension, N, for cables without limits.
        seconds: limit of CPU time; the file is read in a separate process.

    Returns:
        Names and contents of the robot and scenario files, what was left out, and warnings; nothing is written.

    Raises:
        CdprError: with file and line, if the format is unknown, the file is invalid or not representable, or reading
            takes too long. This includes FormatError.

    Example:
        >>> import cdpr
        >>> try:
        ...     cdpr.import_file("no_such_file.xml")
        ... except cdpr.CdprError as error:
        ...     print(int(error.exit_code))
        2
    """
    if not isinstance(path, str | os.PathLike):
        raise CdprError(f"import_file(path=): expected a file name, got {shown(path)}")
    file = Path(path)
    choice = _choice(cable_set, trajectory, tension)

    def read() -> ImportResult:
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
) -> Iterator[ImportResult]:
    """Yield the result for each robot in a folder and its subfolders; errors are returned, not raised.

    Duplicate robot names get a number. `seconds` limits the CPU time per file. cdpr's own YAML files are skipped; the
    last result has their number.
    """
    names: set[str] = set()
    choice = _choice(cable_set, None, tension)

    def read(file: Path) -> ImportResult | None:
        content = content_of(file)
        reader = _reader(file, content)
        if not reader.is_main_file(file, content):
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
            taken = ImportResult(str(file), error=str(error).splitlines()[0])
        if taken is not None:
            names |= taken.files.keys()
            yield taken
    if own:
        count = f"{own} YAML file{'s' * (own > 1)}"
        yield ImportResult(str(path), error=f"{path}: skipped {count} of cdpr's own format: no import needed", own=own)


def _is_own(file: Path) -> bool:
    """Return True if a file is a robot, scenario, study or design of cdpr, judged by its keys."""
    if file.suffix.lower() not in (".yaml", ".yml"):
        return False
    content = content_of(file)
    if any(import_module(each.module).recognise(content) for each in FORMATS):
        return False
    keys = set(re.findall(rb"^([a-z_]+):", content, re.MULTILINE))
    return any(keys.issuperset(these) for these in OWN)


def _load(file: Path) -> None:
    """Import the modules that reading a file needs, once for all forked processes."""
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
    """Load a minimal robot, so that validators are built once and not in each fork."""
    load_robot("warm.yaml", text=SMALLEST)


def _choice(cable_set: str | None, trajectory: str | None, tension: tuple[float, float] | None) -> Choice:
    if tension is not None:
        low, high = given_numbers(tension, 2, "tension")
        if not 0.0 <= low < high <= MAX_MAGNITUDE:
            raise CdprError(f"tension: expected 0 <= MIN < MAX <= {MAX_MAGNITUDE:g} N, got {low:g} and {high:g}")
        tension = low, high
    if cable_set is not None:
        given_name(cable_set, "cable_set")
    if trajectory is not None and not isinstance(trajectory, str | os.PathLike):
        raise CdprError(f"trajectory: expected the name of a file, got {shown(trajectory)}")
    return Choice(cable_set, None if trajectory is None else Path(trajectory), tension)


def write(taken: ImportResult, folder: Path, *, force: bool, otherwise: str = "choose another folder") -> list[Path]:
    """Write the files into a folder, which is created if necessary.

    Args:
        taken: result of an import.
        folder: output folder.
        force: overwrite existing files.
        otherwise: remedy in the message about an existing file.

    Returns:
        Paths of the written files.

    Raises:
        OutputError: if a file exists (without `force`) or cannot be written; new files are removed then.
    """
    there = {name for name in taken.files if os.path.lexists(folder / name)}
    for name in taken.files:
        if name in there and not force:
            raise OutputError(f"'{folder / name}' already exists and is not overwritten: {otherwise}")
    written: list[Path] = []
    if not taken.files:
        return written
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in taken.files.items():
            if name in there:
                replace(folder / name, text)
            else:
                create(folder / name, text)
            written.append(folder / name)
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
    """Return the content of a file.

    Raises:
        FormatError: if it cannot be read or is too large.
    """
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
        parse(content, str(path))  # report invalid XML as such
    names = ", ".join(each.name for each in FORMATS)
    hint = "; our own robots and scenarios need no import" if path.suffix in (".yaml", ".yml") else ""
    hint = "; this is text in UTF-16: save it as UTF-8" if content[:2] in (b"\xff\xfe", b"\xfe\xff") else hint
    raise FormatError(f"{path}: unknown format; supported are {names}{hint}")


def _read(reader: ModuleType, path: Path, content: bytes, choice: Choice) -> Imported:
    """Return the result of a reader; unread elements, attributes and keys are added to `left_out`."""
    found: Imported = reader.read(path, content, choice)
    found.left_out += report(found.documents)
    return found


def _files(folder: Path) -> Iterator[Path]:
    """Yield all files with a known ending in a folder and its subfolders, sorted by name."""
    count = 0
    for above, folders, names in os.walk(folder):
        folders.sort()
        for name in sorted(names):
            if name.lower().endswith(ENDINGS):
                count += 1
                if count > MOST_FILES:
                    raise FormatError(f"{folder}: contains more than {MOST_FILES} files; give one of its folders")
                yield Path(above) / name


def _apart(path: Path, found: Imported, names: set[str]) -> ImportResult:
    """Return the result under a robot name whose files are not among `names`."""
    given, taken = found.name, _taken(path, found)
    for count in itertools.count(2):
        if not names & taken.files.keys():
            return taken
        found.name = found.robot["name"] = f"{given}_{count}"
        taken = _taken(path, found)
    raise AssertionError("numbers do not end")


def _taken(path: Path, found: Imported) -> ImportResult:
    """Return the files as text after validation; validation errors are reported with their source."""
    robot, comments = f"{found.name}.yaml", found.comments
    taken = ImportResult(str(path), {}, found.left_out, found.warnings)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        motions = [_scenario(found, motion, robot, f"{path.parent}{os.sep}") for motion in found.motions]
        taken.files[robot] = with_comments(found.robot, lambda key: comments.get(key, ""), _head(found, path.parent))
        (folder / robot).write_text(taken.files[robot], encoding="utf-8")
        try:
            load_robot(folder / robot)
        except CdprError as error:
            place = _place(path, found, error)
            raise FormatError(f"{place}: the robot is invalid: {_first(error)}") from None
        for motion, files in zip(found.motions, motions, strict=True):
            for each, text in files.items():
                (folder / each).write_text(text, encoding="utf-8")
            try:
                load_scenario(folder / next(iter(files)))
            except CdprError as error:
                taken.left_out.append(f"{path}: motion '{motion.name}'is invalid: {_first(error)}")
            else:
                taken.files |= files
    head = _head(found, path.parent)  # rewritten, because more may be left out now
    taken.files[robot] = with_comments(found.robot, lambda key: comments.get(key, ""), head)
    return taken


def _first(error: CdprError) -> str:
    """Return the first line of an error, without the name of the generated file."""
    return str(error).splitlines()[0].partition(": ")[2]


def _place(path: Path, found: Imported, error: CdprError) -> str:
    """Return the position in the source of the first validation error, found by its comment; otherwise the source."""
    key = error.rows[0].path if error.rows else ()
    if key[:1] == ("tension",) and len(key) == 3:
        key = ("cables", key[2])  # a single limit per cable
    while key and key not in found.comments:
        key = key[:-1]
    comment = found.comments.get(key, "")
    if (beside := re.search(r"(\S+\.\w+):(\d+)", comment)) is not None:
        return f"{path.parent / beside[1]}:{beside[2]}"
    line = re.search(r"\bline (\d+)", comment)
    return str(path) if line is None else f"{path}:{line[1]}"


def _whole(duration: float) -> float:
    """Return the duration rounded up to whole control steps, s."""
    step = Simulation.model_fields["control_step"].default
    return float(round(math.ceil(duration / step - 1e-6) * step, 9))


def _scenario(found: Imported, motion: Motion, robot: str, above: str) -> dict[str, str]:
    """Return a scenario and the files that it references, by name."""
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
    """Return the head comment of a robot file, with relative file names, so that it does not depend on the folder."""
    lines = [f"Imported from {found.source}.", *found.warnings]
    if found.left_out:
        lines += ["Left out:", *(f"- {each}" for each in found.left_out)]
    return "\n".join(lines).replace(f"{folder}{os.sep}", "")
