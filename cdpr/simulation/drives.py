"""Drives that apply the commands of winches imperfectly: late, rounded, limited in their rate, and with backlash."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cdpr.base.columns import GROUPS
from cdpr.base.needs import of_drives
from cdpr.cables import takes_lengths
from cdpr.cables.tables import command_kinds
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.scenario import Scenario
from cdpr.simulation.loop_part import LoopPart, Surroundings
from cdpr.tension.operations import Operation

MOST_WAITING = 64  # commands, each a state of a linearised loop: more take minutes


def imperfections(scenario: Scenario) -> Array:
    """Return the imperfections of the drives, (m, 4), all 0 and without limits if the scenario has none.

    Its columns are: delay in control periods; resolution; largest change of the command in a control period, infinite
    without a limit; half of the backlash. Commands are in N, m or m/s.
    """
    section, robot, step = scenario.sections.drives, scenario.robot, scenario.simulation.control_step
    found = np.tile([0.0, 0.0, np.inf, 0.0], (robot.m, 1))
    for i, cable in enumerate(robot.cables if section is not None else ()):
        assert section is not None
        delay, resolution, rate_max, backlash = section.of_cable(cable.name)
        found[i] = round(delay / step), resolution, np.inf if rate_max is None else step * rate_max, 0.5 * backlash
    return found


def drives_of(scenario: Scenario) -> LoopPart | None:
    """Return the part of the loop with the drives of a scenario; None if they are ideal."""
    return None if scenario.ideal_drives else Drives(imperfections(scenario))


class Drives(LoopPart):
    """Drives between the commands of the winches and the plant.

    A command is rounded, delayed, limited in its rate, and then transmitted with play, in this order. Tensions that
    events impose act at once: a cable that breaks or jams, and a cut of the power, do not pass through a drive.

    Args:
        imperfection: (m, 4), as of `imperfections`.
    """

    name = "drives"
    columns = GROUPS["driven"].columns
    needs = of_drives()

    def __init__(self, imperfection: Array) -> None:
        self._imperfection = imperfection
        m = len(imperfection)
        self._line = np.zeros((int(imperfection[:, 0].max()) + 1, m))
        self._motor, self._drum = np.zeros(m), np.zeros(m)
        self.arrays = (self._line, self._motor, self._drum)

    @property
    def nonlinear(self) -> str:
        """Return why the loop cannot be linearised: resolution, backlash, or too many commands that wait."""
        if self._imperfection[:, [1, 3]].any():
            return "the resolution or the backlash of the drives is not linear"
        waiting = self._line.size - self._line.shape[1]
        return (
            f"{waiting} commands wait in the drives: expected at most {MOST_WAITING}" if waiting > MOST_WAITING else ""
        )

    def connect(self, surroundings: Surroundings) -> None:
        """Bind the operation to the commands of the loop."""
        robot = surroundings.robot
        self._apply = bind(
            "apply_drives",
            command=surroundings.view("winch_command" if takes_lengths(robot) else "tension"),
            imposed=surroundings.imposed,
            takes=command_kinds(robot),
            imperfection=self._imperfection,
            line=self._line,
            motor=self._motor,
            drum=self._drum,
            applied=surroundings.columns["drive_command"],
            period=surroundings.step,
        )

    def commanded(self) -> Sequence[Operation]:
        """Return the operation that writes the applied commands."""
        return [Operation(self.name, self._apply, timed=True, telling=True)]
