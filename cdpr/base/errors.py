"""Errors of cdpr: each states the place, the problem, the allowed values and the remedy."""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from typing import Any

from cdpr.base.problems import Problem, printable

LONGEST = 500  # maximum length of the text of foreign exceptions in messages


class ExitCode(IntEnum):
    """Exit codes of `cdpr`."""

    OK = 0
    INTERNAL = 1  # an internal error
    BAD_INPUT = 2
    PLUGIN = 3
    INFEASIBLE = 4
    DIVERGED = 5
    BACKEND_DIED = 6
    DISAGREES = 7
    NOT_WRITABLE = 8
    INTERRUPTED = 130
    TERMINATED = 143


def one_line(error: BaseException) -> str:
    """Return a description of an exception raised by foreign code, in one line of limited length."""
    try:
        text = " ".join(str(error).split())
    except Exception:  # of a foreign class
        text = ""
    if len(text) > LONGEST:
        text = f"{text[: LONGEST - 3]}..."
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


class OptionsLeftOut(UserWarning):
    """Warning that options of a controller or solver were ignored because another one was chosen."""


class PartsLeftOut(UserWarning):
    """Warning that an export omits parts that its format does not support."""


class CdprError(Exception):
    """Base class of all errors that cdpr raises deliberately; the text is for the user, printable line by line.

    Attributes:
        rows: problems of a file with mark, path and text, for display beside the values.

    Example:
        >>> import cdpr
        >>> try:
        ...     cdpr.load_run("no_such_folder")
        ... except cdpr.CdprError as error:
        ...     print(int(error.exit_code))
        2
    """

    exit_code = ExitCode.BAD_INPUT

    run: Any = None  # partial result, a `cdpr.Run`, if the error ended a run

    def __init__(self, text: str = "", rows: Sequence[Problem] = ()) -> None:
        super().__init__("\n".join(map(printable, text.split("\n"))))
        self.rows = tuple(rows)


class ScenarioError(CdprError):
    """Invalid scenario or robot file. `problems` has one line `file:line:col: key: text` each.

    Example:
        >>> import cdpr
        >>> try:
        ...     cdpr.load_scenario("caroca", overrides={"simulation.duration": -1.0})
        ... except cdpr.ScenarioError as error:
        ...     print(len(error.problems))
        1
    """

    def __init__(self, problems: list[str], rows: Sequence[Problem] = ()) -> None:
        super().__init__("\n".join(problems), rows)
        self.problems = problems


class PluginError(CdprError):
    """Unknown, missing or broken plugin.

    Example:
        >>> import cdpr
        >>> try:
        ...     cdpr.simulate("caroca", solver="no_such_solver")
        ... except cdpr.PluginError as error:
        ...     print(int(error.exit_code))
        3
    """

    exit_code = ExitCode.PLUGIN


class MissingPackageError(PluginError, ImportError):
    """Missing package of a pip extra, raised by importing a module of cdpr.

    Example:
        >>> import cdpr
        >>> issubclass(cdpr.MissingPackageError, ImportError)
        True
    """


class OutputError(CdprError):
    """File or folder that cannot be written.

    Example:
        >>> import cdpr
        >>> try:
        ...     cdpr.simulate("caroca", out="/dev/null/runs")
        ... except cdpr.OutputError as error:
        ...     print(int(error.exit_code))
        8
    """

    exit_code = ExitCode.NOT_WRITABLE


class FmuError(CdprError):
    """FMU that cannot be used: its file is invalid, not trusted, for another platform, or does not fit the robot.

    Example:
        >>> import cdpr
        >>> issubclass(cdpr.FmuError, cdpr.CdprError)
        True
    """


class FormatError(CdprError):
    """File of another program that is invalid or unsupported; the text begins with file and line.

    Example:
        >>> import cdpr
        >>> issubclass(cdpr.FormatError, cdpr.CdprError)
        True
    """


class LogError(CdprError):
    """Run folder or log that cannot be read.

    Example:
        >>> import cdpr
        >>> try:
        ...     cdpr.load_run("no_such_folder")
        ... except cdpr.LogError as error:
        ...     print(error)
        no_such_folder: no such file or folder; give the folder of a run, or a log
    """


class SimulationStopped(CdprError):  # noqa: N818 - not always a fault
    """Early end of a run. `run` has the results up to then.

    Example:
        >>> import cdpr
        >>> weak = {"robot.platform.mass": 5000.0, "solver.infeasible": "stop"}
        >>> try:
        ...     cdpr.simulate("caroca", overrides=weak)
        ... except cdpr.SimulationStopped as stop:
        ...     print(stop.run.status)
        infeasible
    """


class Infeasible(SimulationStopped):
    """Wrench that could not be distributed, if the scenario stops the run then.

    Example:
        >>> import cdpr
        >>> weak = {"robot.platform.mass": 5000.0, "solver.infeasible": "stop"}
        >>> try:
        ...     cdpr.simulate("caroca", overrides=weak)
        ... except cdpr.Infeasible as stop:
        ...     print(stop.run.status)
        infeasible
    """

    exit_code = ExitCode.INFEASIBLE


class LimitViolation(Infeasible):
    """Limit violation of a cable length, winding speed or commanded tension, if the scenario stops the run then.

    Example:
        >>> import cdpr
        >>> issubclass(cdpr.LimitViolation, cdpr.Infeasible)
        True
    """


class CollisionDetected(Infeasible):
    """Cables too close to each other, their platform or an obstacle, if the scenario stops the run then.

    Example:
        >>> import cdpr
        >>> issubclass(cdpr.CollisionDetected, cdpr.Infeasible)
        True
    """


class SolverFailed(Infeasible):
    """Solver without a valid answer, if the scenario stops the run then; a solution may or may not exist.

    Example:
        >>> import cdpr
        >>> issubclass(cdpr.SolverFailed, cdpr.Infeasible)
        True
    """


class Diverged(SimulationStopped):
    """State beyond any valid simulation: NaN, absurd speed, or a reset of the engine.

    Example:
        >>> import cdpr
        >>> class Lost(cdpr.plugins.Controller):
        ...     def control(self, time, state, desired, out):
        ...         out[:] = 1e30
        >>> try:
        ...     cdpr.simulate("caroca", controller=Lost)
        ... except cdpr.Diverged as stop:
        ...     print(stop.run.status)
        <Run of caroca on reference: 4001 samples, finished>
    """

    exit_code = ExitCode.DIVERGED


class BackendDied(SimulationStopped):
    """Process of a plant or a controller that failed, crashed, ended or hangs.

    Example:
        >>> import cdpr
        >>> int(cdpr.BackendDied.exit_code)
        6
    """

    exit_code = ExitCode.BACKEND_DIED


class PlantEnded(SimulationStopped):
    """End of the simulation requested by a plant or a controller, which is no error.

    Example:
        >>> import cdpr
        >>> int(cdpr.PlantEnded.exit_code)
        0
    """

    exit_code = ExitCode.OK


class Interrupted(SimulationStopped):
    """End of the run by the user or the system.

    Example:
        >>> import cdpr
        >>> def enough(done, total):
        ...     if done:
        ...         raise cdpr.Interrupted("enough samples")
        >>> try:
        ...     cdpr.simulate("caroca", progress=enough)
        ... except cdpr.Interrupted as stop:
        ...     print(stop.run.status)
        interrupted
    """

    exit_code = ExitCode.INTERRUPTED
