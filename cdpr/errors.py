"""The errors of cdpr: each says where, what is wrong, what is allowed and what to do next."""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from typing import TYPE_CHECKING

from cdpr.problems import Problem, printable

if TYPE_CHECKING:
    from cdpr.log.run import Run


class ExitCode(IntEnum):
    """What `cdpr` returns to the shell."""

    OK = 0
    INTERNAL = 1  # a fault of ours
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
    """Return what there is to say of an exception that foreign code raised."""
    text = " ".join(str(error).split())
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


class OptionsLeftOut(UserWarning):
    """Options of a controller or solver that were left out as another one was chosen."""


class CdprError(Exception):
    """Base of every error that cdpr raises on purpose; its text is meant for the user, and printable line by line.

    Attributes:
        rows: what is wrong with a file, each with its mark, path and text, for who shows it beside the value itself.
    """

    exit_code = ExitCode.BAD_INPUT

    run: Run | None = None  # with what was computed, where the error ended a run

    def __init__(self, text: str = "", rows: Sequence[Problem] = ()) -> None:
        super().__init__("\n".join(map(printable, text.split("\n"))))
        self.rows = tuple(rows)


class ScenarioError(CdprError):
    """A scenario or robot file is wrong. `problems` holds one `file:line:col: key: what` line each."""

    def __init__(self, problems: list[str], rows: Sequence[Problem] = ()) -> None:
        super().__init__("\n".join(problems), rows)
        self.problems = problems


class PluginError(CdprError):
    """A plugin is unknown, not installed or broken."""

    exit_code = ExitCode.PLUGIN


class OutputError(CdprError):
    """A file or folder cannot be written."""

    exit_code = ExitCode.NOT_WRITABLE


class FmuError(CdprError):
    """An FMU cannot be used: its file is unsound, not trusted, for another machine, or does not fit the robot."""


class FormatError(CdprError):
    """A file of another program is unsound, or says what our parts cannot; the text begins with file and line."""


class LogError(CdprError):
    """A run folder or its log cannot be read."""


class SimulationStopped(CdprError):  # noqa: N818 - not always a fault
    """A run ended before its time. `run` holds what was computed up to there."""

    run: Run  # `simulate` sees to it


class Infeasible(SimulationStopped):
    """The wrench could not be distributed and the scenario says to stop then."""

    exit_code = ExitCode.INFEASIBLE


class BeyondLimits(Infeasible):
    """A cable left its length or winding speed, or a command its tensions, and the scenario says to stop then."""


class Touched(Infeasible):
    """Cables came too near to each other, their platform or an obstacle, and the scenario says to stop then."""


class Unanswered(Infeasible):
    """The solver gave no valid answer and the scenario says to stop then: whether there is one is not known."""


class Diverged(SimulationStopped):
    """The state left what a sound simulation can reach: NaN, absurd speed, an engine that reset itself."""

    exit_code = ExitCode.DIVERGED


class BackendDied(SimulationStopped):
    """What a plant or a controller runs in failed, crashed, ended or hangs."""

    exit_code = ExitCode.BACKEND_DIED


class PlantEnded(SimulationStopped):
    """A plant or a controller asked for the end of the simulation, which is no fault."""

    exit_code = ExitCode.OK


class Interrupted(SimulationStopped):
    """The user or the system ended the run."""

    exit_code = ExitCode.INTERRUPTED
