"""Stage of the loop for controllers whose commands are those of the winches: tensions, unwound lengths or rates."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from cdpr.model import Robot
from cdpr.native.bind import bind
from cdpr.tension.command import CommandStage
from cdpr.tension.current_sample import Cables, Present
from cdpr.tension.operations import Operation
from cdpr.tension.policy import Policy


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
