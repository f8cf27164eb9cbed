"""The stage of the loop behind a controller that puts out commands: checks them, clips them, books what they do."""

from __future__ import annotations

import numpy as np

from cdpr.errors import BeyondLimits, Diverged
from cdpr.model import Robot
from cdpr.native.bind import bind
from cdpr.tension.acts import Act, perform
from cdpr.tension.policy import Policy
from cdpr.tension.present import Cables, Present
from cdpr.tension.status import BAD_INPUT

BEYOND = "the controller's command is beyond the tension limits"


class CommandStage:
    """Turns a controller's commands into tensions, once per control step, without distributing anything.

    Args:
        robot: gives the limits, unless `cables` does.
        policy: `stop` ends the run at a command beyond the limits; otherwise it is clipped and counted, with the
            status NOT_FOUND: the controller's answer failed the check.
        live: of the present sample; wrench (what the cables exert, W @ tension), tension and report are results, and
            the residual is always 0 N: no wrench was wanted.
        cables: what is allowed and imposed; the robot's limits, and all cables free, unless given.

    Attributes:
        command: (m,) where the controller writes, N. What it says to a locked cable, whose limits are equal, does not
            matter.
        acts: what `distribute` does, one after the other; likewise `imposing`.
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
        self.acts = [Act("distribution", take, self._refuse)]
        self.imposing = [Act("distribution", bind("impose_command", **shared, held=cables.held))]

    arrays = ()  # what comes next depends on none before
    answered = True  # there is no solver to be asked
    refusal = ""

    def forget(self) -> None:
        """Do nothing: there are no answers to forget."""

    def snapshot(self) -> object:
        """Return what future answers depend on beside limits and held cables: nothing."""
        return None

    def restore(self, snapshot: object) -> None:
        """Do nothing, likewise."""

    def impose(self) -> None:
        """Give the cables the tensions that they are `held` at, and report what all tensions do."""
        perform(self.imposing)

    def distribute(self) -> None:
        """Write tensions, wrench and report for the present command.

        Raises Diverged where the command is not finite, BeyondLimits under the policy `stop`.
        """
        perform(self.acts)

    def _refuse(self, status: int) -> None:
        if status == BAD_INPUT:
            raise Diverged("the controller put out a command that is not finite")
        raise BeyondLimits(f"{BEYOND} (policy stop)")
