"""Export of a robot, scenario or run to a file of another program: the verb of the Python interface."""

from __future__ import annotations

import os
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from cdpr.base.errors import CdprError, FormatError, PartsLeftOut
from cdpr.base.nearest import did_you_mean
from cdpr.base.problems import shown
from cdpr.formats.write import TARGETS
from cdpr.formats.write.export_model import Options, begin, left_out
from cdpr.formats.write.export_model import export as text_of
from cdpr.log.export import EXPORTS
from cdpr.log.export import export as write_table
from cdpr.log.files import make_folder, name_from, output_path, replace, require_new
from cdpr.log.reader import load_run
from cdpr.log.run import Run
from cdpr.scenario import load_scenario
from cdpr.scenario.loader import AnyRobot, robot_or_scenario
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
    if to not in known:
        hint = did_you_mean(to, known) if isinstance(to, str) else ""
        raise FormatError(f"export(to=): expected one of {', '.join(known)}, got {shown(to)}; {hint}".rstrip("; "))
    for name in options:
        if name not in (allowed := TARGETS[to].options if to in TARGETS else ()):
            raise FormatError(f"export({name}=): {to} has {'only ' + ', '.join(allowed) if allowed else 'no options'}")
    if to in EXPORTS:
        if not isinstance(what, Run | str | os.PathLike):
            raise CdprError(f"export(what=): {to} is for runs, expected a Run or its folder, got {shown(what)}")
        run = what if isinstance(what, Run) else load_run(os.fspath(what))
        target = _output(f"{name_from(run.header.scenario)}.{to}" if out is None else out)
        write_table(run, to, target, force)
        return target
    if isinstance(what, Run):
        raise CdprError(f"export(what=): {to} is for robots and scenarios, got a run: {', '.join(EXPORTS)}")
    return _packages(what, to, out, force) if to in (PACKAGES, NATIVE) else _model(what, to, out, force, options)


def _output(name: object, kind: str = "file") -> Path:
    return output_path(name, "export(out=)", kind)


def _packages(what: Any, to: str, out: str | os.PathLike[str] | None, force: bool) -> Path:
    from cdpr.formats.write.native import write_native
    from cdpr.formats.write.ros2 import write_ros2

    scenario = load_scenario(what)
    target = _output(f"{scenario.name}_{to}" if out is None else out, "folder")
    omitted: Sequence[str] = []
    if to == PACKAGES:
        _, omitted = write_ros2(scenario, target)
    else:
        write_native(scenario, target, force)
        omitted = left_out_of(scenario, "native")
    _warn(omitted)
    return target


def _model(what: AnyRobot, to: str, out: str | os.PathLike[str] | None, force: bool, options: dict[str, str]) -> Path:
    subject = begin(robot_or_scenario(what), to)
    target = _output(f"{name_from(subject.robot.name)}{TARGETS[to].ending}" if out is None else out)
    text = text_of(subject, to, Options(**options))
    require_new(target, force, "choose another name, or force=True")
    make_folder(target.parent)
    replace(target, text)
    _warn(left_out(subject, to))
    return target


def _warn(omitted: Sequence[str]) -> None:
    """Warn about each part that the format omits."""
    for each in omitted:
        warnings.warn(f"left out: {each}", PartsLeftOut, stacklevel=outside())
