"""Errors of cdpr: each states the place, the problem, the allowed values and the remedy."""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from typing import Any

from cdpr.base.problems import Problem, printable


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
    """Return a description of an exception raised by foreign code, in one line."""
    text = " ".join(str(error).split())
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


class OptionsLeftOut(UserWarning):
    """Warning that options of a controller or solver were ignored because another one was chosen."""


class CdprError(Exception):
    """Base class of all errors that cdpr raises deliberately; the text is for the user, printable line by line.

    Attributes:
        rows: problems of a file with mark, path and text, for display beside the values.
    """

    exit_code = ExitCode.BAD_INPUT

    run: Any = None  # partial result, a `cdpr.Run`, if the error ended a run

    def __init__(self, text: str = "", rows: Sequence[Problem] = ()) -> None:
        super().__init__("\n".join(map(printable, text.split("\n"))))
        self.rows = tuple(rows)


class ScenarioError(CdprError):
    """Invalid scenario or robot file. `problems` has one line `file:line:col: key: text` each."""

    def __init__(self, problems: list[str], rows: Sequence[Problem] = ()) -> None:
        super().__init__("\n".join(problems), rows)
        self.problems = problems


class PluginError(CdprError):
    """Unknown, missing or broken plugin."""

    exit_code = ExitCode.PLUGIN


class OutputError(CdprError):
    """File or folder that cannot be written."""

    exit_code = ExitCode.NOT_WRITABLE


class FmuError(CdprError):
    """FMU that cannot be used: its file is invalid, not trusted, for another platform, or does not fit the robot."""


class FormatError(CdprError):
    """File of another program that is invalid or unsupported; the text begins with file and line."""


class LogError(CdprError):
    """Run folder or log that cannot be read."""


class SimulationStopped(CdprError):  # noqa: N818 - not always a fault
    """Early end of a run. `run` has the results up to then."""


class Infeasible(SimulationStopped):
    """Wrench that could not be distributed, if the scenario stops the run then."""

    exit_code = ExitCode.INFEASIBLE


class LimitViolation(Infeasible):
    """Limit violation of a cable length, winding speed or commanded tension, if the scenario stops the run then."""


class CollisionDetected(Infeasible):
    """Cables too close to each other, their platform or an obstacle, if the scenario stops the run then."""


class SolverFailed(Infeasible):
    """Solver without a valid answer, if the scenario stops the run then; a solution may or may not exist."""


class Diverged(SimulationStopped):
    """State beyond any valid simulation: NaN, absurd speed, or a reset of the engine."""

    exit_code = ExitCode.DIVERGED


class BackendDied(SimulationStopped):
    """Process of a plant or a controller that failed, crashed, ended or hangs."""

    exit_code = ExitCode.BACKEND_DIED


class PlantEnded(SimulationStopped):
    """End of the simulation requested by a plant or a controller, which is no error."""

    exit_code = ExitCode.OK


class Interrupted(SimulationStopped):
    """End of the run by the user or the system."""

    exit_code = ExitCode.INTERRUPTED
