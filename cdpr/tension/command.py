"""Stage of the loop for controllers with command output: checks, clips and records the commands."""

from __future__ import annotations

import numpy as np

from cdpr.base.errors import Diverged, LimitViolation
from cdpr.model import Robot
from cdpr.native.bind import bind
from cdpr.tension.current_sample import Cables, Present
from cdpr.tension.operations import Operation, perform
from cdpr.tension.policy import Policy
from cdpr.tension.status import BAD_INPUT

BEYOND = "the controller's command is beyond the tension limits"


class CommandStage:
    """Stage that converts a controller's commands into tensions, once per control step, without a distribution.

    Args:
        robot: robot with the limits, unless `cables` has them.
        policy: `stop` ends the run at a command beyond the limits; otherwise it is clipped and counted, with the status
            NOT_FOUND: the controller's answer failed the check.
        live: current sample; wrench (of the cables, W @ tension), tension and report are results. The residual is
            always 0 N, because no wrench was required.
        cables: limits and imposed tensions; by default the robot's limits, with all cables free.

    Attributes:
        command: (m,), output of the controller, N. Commands of locked cables, whose limits are equal, are ignored.
        operations: those of `distribute` in order; `imposing` likewise.
        live, cables: as given.
    """

    def __init__(
        self,
        robot: Robot,
        policy: Policy,
        live: Present,
        cables: Cables | None = None,
    ) -> None:
        self.command = np.zeros(robot.m)
        self.live = live
        self.cables = cables = cables or Cables.of(robot)
        shared = {"limits": cables.limits, "matrix": live.W, "tension": live.tension, "wrench": live.wrench}
        shared |= {"report": live.report}
        take = bind("take_command", **shared, command=self.command, stop=int(policy == "stop"))
        self.operations = [Operation("distribution", take, self._refuse)]
        self.imposing = [Operation("distribution", bind("impose_command", **shared, held=cables.held))]

    arrays = ()  # no memory
    answered = True  # there is no solver
    refusal = ""

    def unanswered(self) -> str:
        """Return no message: there is no solver."""
        return ""

    def forget(self) -> None:
        """Do nothing: there are no answers to forget."""

    def reset(self) -> None:
        """Do nothing: there is no memory."""

    def snapshot(self) -> object:
        """Return the memory besides limits and held cables: none."""
        return None

    def restore(self, snapshot: object) -> None:
        """Do nothing."""

    def impose(self) -> None:
        """Set cables to their `held` tensions, and report the wrench of all tensions."""
        perform(self.imposing)

    def distribute(self) -> None:
        """Write tensions, wrench and report for the current command.

        Raises:
            Diverged: if the command is not finite.
            LimitViolation: under the policy `stop`.
        """
        perform(self.operations)

    def _refuse(self, status: int) -> None:
        if status == BAD_INPUT:
            raise Diverged("the controller put out a command that is not finite")
        raise LimitViolation(f"{BEYOND} (policy stop)")
