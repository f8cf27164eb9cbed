"""The stage of the loop behind a controller that puts out commands: checks them, clips them, books what they do."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from cdpr.errors import BeyondLimits, Diverged
from cdpr.model import Robot
from cdpr.model.jit import kernel
from cdpr.model.robot import Array
from cdpr.tension.acts import Act, perform
from cdpr.tension.checks import LIMIT_TOLERANCE, hold, newton, room
from cdpr.tension.policy import Policy
from cdpr.tension.present import Cables, Present
from cdpr.tension.status import BAD_INPUT, NOT_FOUND, OK

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
        result = (cables.limits, live.W, live.tension, live.wrench, live.report)
        self.acts = [Act("distribution", partial(take, policy == "stop", self.command, *result), self._refuse)]
        self.imposing = [Act("distribution", partial(impose, cables.held, *result))]

    arrays = ()  # what comes next depends on none before
    answered = True  # there is no solver to be asked
    refusal = ""

    def forget(self) -> None:
        """Do nothing: there are no answers to forget."""

    def follow(self) -> None:
        """Do nothing: what comes next depends on no answer."""

    def snapshot(self) -> object:
        """Return what future answers depend on beside limits and held cables: nothing."""
        return None

    def restore(self, snapshot: object) -> None:
        """Do nothing, likewise."""

    def warm_up_policy(self) -> None:
        """Do nothing: there is nothing to compile."""

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


@kernel
def take(stop: bool, command: Array, limits: Array, W: Array, tension: Array, wrench: Array, report: Array) -> int:
    """Clip `command` (m,) to the limits (2, m) and write tension, wrench and report.

    Return the status where it ends the run, else 0. Nothing is written where the command is not finite.
    """
    for i in range(command.shape[0]):
        if not math.isfinite(command[i]):
            return BAD_INPUT
    status, tolerance = OK, LIMIT_TOLERANCE * newton(limits)
    for i in range(command.shape[0]):
        low, high = limits[0, i], limits[1, i]
        if low < high and not low - tolerance <= command[i] <= high + tolerance:
            status = NOT_FOUND
        tension[i] = min(max(command[i], low), high)
    report[0] = status
    account(limits, W, tension, wrench, report)
    return status if stop else 0


@kernel
def impose(held: Array, limits: Array, W: Array, tension: Array, wrench: Array, report: Array) -> None:
    """Let `held` tensions (m,) be, and write what all tensions do then, but not the status."""
    hold(held, tension)
    account(limits, W, tension, wrench, report, held)


@kernel
def account(limits: Array, W: Array, tension: Array, wrench: Array, report: Array, held: Array | None = None) -> None:
    """Write the wrench (6,) of the tensions (m,) and report[1:4]; locked and `held` cables count as `room` says."""
    for j in range(6):
        wrench[j] = 0.0
        for i in range(tension.shape[0]):
            wrench[j] += W[j, i] * tension[i]
    report[1] = 0.0
    room(limits, tension, report, held)
