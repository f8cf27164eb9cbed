"""Stage of the loop for controllers whose commands are those of the winches: tensions, unwound lengths or rates."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from cdpr.cables.tables import SPAN, chain_table
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.tension.command import CommandStage
from cdpr.tension.current_sample import Cables, Present
from cdpr.tension.operations import Operation
from cdpr.tension.policy import Policy

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
