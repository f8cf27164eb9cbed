"""Stage of the loop for controllers whose commands are those of the winches: tensions, unwound lengths or rates."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from cdpr.base.errors import Diverged
from cdpr.base.fields import MAX_UNWOUND
from cdpr.cables import LENGTH, commands_of
from cdpr.cables.tables import SPAN, chain_table
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.tension.command import CommandStage
from cdpr.tension.current_sample import Cables, Present
from cdpr.tension.operations import Operation
from cdpr.tension.policy import Policy
from cdpr.tension.status import BAD_INPUT

SPAN_KINDS = slice(1, 3)  # columns of `chain_table`: kind and lowest tension of the spans


def chains_of_map(robot: Robot, nominal: Robot) -> Array:
    """Return the chains (m, 33) by which tensions become lengths: winches of the robot, spans of the nominal one."""
    chains = np.concatenate([chain_table(robot)[:, :SPAN], chain_table(nominal)[:, SPAN:]], axis=1)
    chains[:, SPAN_KINDS] = chain_table(nominal)[:, SPAN_KINDS]
    return chains


class WinchStage(CommandStage):
    """Stage that passes commands on to winches, and writes the tensions that the nominal robot then has.

    Args:
        robot: nominal robot.
        policy: as for `CommandStage`; it concerns commands that are tensions.
        live: current sample; wrench, tension and report are results.
        cables: limits; tensions are clipped to them. Lengths and rates are not.
        arguments: further arrays of the operation `take_winch_command`, see `cdpr/tension/winding.hpp`.
    """

    def __init__(
        self, robot: Robot, policy: Policy, live: Present, cables: Cables, arguments: Mapping[str, Any]
    ) -> None:
        super().__init__(robot, policy, live, cables)
        self._names, self._takes = [cable.name for cable in robot.cables], commands_of(robot)
        shared = {"limits": cables.limits, "matrix": live.W, "tension": live.tension, "wrench": live.wrench}
        take = bind(
            "take_winch_command",
            **shared,
            **arguments,
            report=live.report,
            given=self.command,
            stop=int(policy == "stop"),
        )
        self.operations = [Operation("distribution", take, self._refuse)]

    def _refuse(self, status: int) -> None:
        if status == BAD_INPUT:
            for name, taken, value in zip(self._names, self._takes, self.command.tolist(), strict=True):
                if taken == LENGTH and not 0.0 < value <= MAX_UNWOUND:
                    wanted = f"expected more than 0 and at most {MAX_UNWOUND:g} m"
                    raise Diverged(f"cable '{name}': a length of {value:.4g} m is commanded: {wanted}")
        super()._refuse(status)
