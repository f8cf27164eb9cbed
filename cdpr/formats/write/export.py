"""Export of a robot, scenario or run to a file of another program, for the Python interface and `cdpr export`."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import cast

from cdpr.base.errors import CdprError, FormatError, PartsLeftOut
from cdpr.base.nearest import did_you_mean
from cdpr.base.problems import shown
from cdpr.formats.write import TARGETS
from cdpr.formats.write.export_model import Options, begin, left_out
from cdpr.formats.write.export_model import export as text_of
from cdpr.log.export import EXPORTS
from cdpr.log.export import export as write_table
from cdpr.log.files import (
    NAME_OR_FORCE,
    NAME_OR_FORCE_IN_PYTHON,
    make_folder,
    name_from,
    output_path,
    replace,
    require_new,
)
from cdpr.log.reader import load_run
from cdpr.log.run import Run
from cdpr.model import Robot
from cdpr.scenario import Scenario, load_scenario
from cdpr.scenario.loader import AnyRobot, AnyScenario, robot_or_scenario
from cdpr.scenario.option_migration import outside
from cdpr.simulation.needs import omitted as left_out_of

PACKAGES, NATIVE = "ros2", "native"  # folders, not files


def export(
    what: AnyRobot | Run, to: str, out: str | os.PathLike[str] | None = None, *, force: bool = False, **options: str
) -> Path:
    """Write a robot or scenario for another program, or a run as a table.

    Args:
        what: a Robot, a Scenario, a Run, their file or folder, the name of an example, or a dict.
        to: of a robot or scenario "mjcf", "sdf" or "urdf"; of a scenario also "ros2" (folder of packages) or "native"
            (C++ header and numbers); of a run "csv", "npz", "mat" or "parquet".
        out: file or folder; NAME.FORMAT in the working folder by default.
        force: replace an existing file.
        options: of SDF style and version; of MJCF and SDF pulleys, as `cdpr export` has them.

    Returns:
        The file or folder. A PartsLeftOut warning lists each part that the format does not support.

    Raises:
        FormatError: if the format is unknown or cannot represent the robot.
        OutputError: if the file exists without `force`, or cannot be written.

    Example:
        >>> import pathlib, tempfile
        >>> import cdpr
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     file = cdpr.export("caroca", "mjcf", pathlib.Path(folder, "caroca.xml"))
        ...     print(file.name, len(file.read_text()) > 1000)
        caroca.xml True
    """
    known = [*TARGETS, PACKAGES, NATIVE, *EXPORTS]
    if not isinstance(to, str) or to not in known:
        hint = did_you_mean(to, known) if isinstance(to, str) else ""
        raise FormatError(f"export(to=): expected one of {', '.join(known)}, got {shown(to)}; {hint}".rstrip("; "))
    for name in options:
        if name not in (allowed := TARGETS[to].options if to in TARGETS else ()):
            raise FormatError(f"export({name}=): {to} has {'only ' + ', '.join(allowed) if allowed else 'no options'}")
    if to in EXPORTS:
        if not isinstance(what, Run | str | os.PathLike):
            raise CdprError(f"export(what=): {to} is for runs, expected a Run or its folder, got {shown(what)}")
        loaded: Robot | Scenario | Run = what if isinstance(what, Run) else load_run(os.fspath(what))
    elif isinstance(what, Run):
        raise CdprError(f"export(what=): {to} is for robots and scenarios, got a run: {', '.join(EXPORTS)}")
    elif to in (PACKAGES, NATIVE):
        loaded = load_scenario(cast(AnyScenario, what))  # which rejects robots
    else:
        loaded = robot_or_scenario(what)
    target = None if out is None else output_path(out, "export(out=)", "folder" if to in (PACKAGES, NATIVE) else "file")
    written = write(loaded, to, target, Options(**options), force=force, remedy=NAME_OR_FORCE_IN_PYTHON)
    for each in written.omitted:
        warnings.warn(f"left out: {each}", PartsLeftOut, stacklevel=outside())
    return written.path


@dataclass(frozen=True)
class Written:
    """Written file or folder.

    Attributes:
        path: its path.
        omitted: parts that the format does not support.
        counts: number of `rows` of a table, or of `files` of a folder.
    """

    path: Path
    omitted: Sequence[str] = ()
    counts: Mapping[str, int] = field(default_factory=dict)


def write(
    what: Robot | Scenario | Run,
    to: str,
    out: Path | None,
    options: Options,
    *,
    force: bool = False,
    remedy: str = NAME_OR_FORCE,
) -> Written:
    """Write a loaded robot, scenario or run, as `export` does; `remedy` is that of the error if the file exists."""
    if isinstance(what, Run):
        out = out or Path(f"{name_from(what.header.scenario)}.{to}")
        write_table(what, to, out, force, remedy)
        return Written(out, counts={"rows": len(what.rows)})
    if to in (PACKAGES, NATIVE):
        assert isinstance(what, Scenario)
        return _folder(what, to, out or Path(f"{what.name}_{to}"), force, remedy)
    subject = begin(what, to)
    out = out or Path(f"{name_from(subject.robot.name)}{TARGETS[to].ending}")
    text = text_of(subject, to, options)
    require_new(out, force, remedy)
    make_folder(out.parent)
    replace(out, text, force)
    return Written(out, left_out(subject, to))


def _folder(scenario: Scenario, to: str, out: Path, force: bool, remedy: str) -> Written:
    from cdpr.formats.write.native import write_native
    from cdpr.formats.write.ros2 import write_ros2

    if to == PACKAGES:
        files, omitted = write_ros2(scenario, out, force, remedy)
    else:
        files, omitted = write_native(scenario, out, force, remedy), left_out_of(scenario, "native")
    return Written(out, omitted, {"files": len(files)})
