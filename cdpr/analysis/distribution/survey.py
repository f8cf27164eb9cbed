"""Lengths, rates and tensions along a desired motion, without simulation: inverse kinematics and dynamics."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from cdpr.base import tolerances
from cdpr.cables.tables import line_table
from cdpr.mechanics.properties import check_lengths
from cdpr.model.arrays import checked
from cdpr.model.robot import Array, Robot
from cdpr.native.bind import bind
from cdpr.tension.current_sample import Present
from cdpr.tension.stage import Solve, StageSolver, TensionStage


class StageChanges(Protocol):
    """Changes of limits, tensions, external wrench and mass at given samples."""

    def distribute(self) -> None:
        """Distribute tensions instead of the stage."""

    def begin(self) -> int:
        """Return the first sample at which `apply` is due; negative if there is none."""

    def apply(self, k: int) -> int:
        """Apply the changes due at sample k; return the next sample that is due, negative if there is none."""


# Inputs: the stage, the live external wrench (6,) and the live mass properties (13,).
ChangesFactory = Callable[[TensionStage, Array, Array], StageChanges]


@dataclass(frozen=True, eq=False)
class Survey:
    """K samples of a motion of a robot with m cables; conventions of `cdpr.model`."""

    time: Array  # (K,), s
    desired: Array  # (K, 19)
    length: Array  # (K, m), m
    rate: Array  # (K, m), m/s
    wrench: Array  # (K, 6), N and N m, required wrench of the cables
    tension: Array  # (K, m), N; closest to the wrench if no distribution is admissible
    status: Array  # (K,), `cdpr.tension.Status`
    residual: Array  # (K,), N, moments divided by the characteristic length
    margin: Array  # (K,), N, smallest distance of a tension from its limits

    @property
    def feasible(self) -> Array:
        """True if tensions within the limits balance the wrench, (K,)."""
        return np.asarray(self.status == 0.0)


def survey(
    robot: Robot,
    time: Array,
    desired: Array,
    gravity: Array,
    solve: Solve,
    *,
    changes_of: ChangesFactory | None = None,
    samples: Array | None = None,
) -> Survey:
    """Return lengths, rates and tensions along a desired motion, with the wrench of inverse dynamics.

    Args:
        robot: the robot.
        time: (K,), s.
        desired: (K, 19), desired motion; a static pose is one sample without velocity and acceleration.
        gravity: (3,), m/s^2, world.
        solve: bound method of a solver for this robot.
        changes_of: factory of changes during the motion; the cables also balance its external wrench, and move its
            mass.
        samples: (K,), increasing sample numbers to which these changes refer.
    """
    time, desired = checked(time, (None,), "time"), checked(desired, (len(time), 19), "desired")
    gravity, count, m = checked(gravity, (3,), "gravity"), len(time), robot.m
    live, external, inertial = Present.of(m), np.zeros(6), robot.inertial.copy()
    stage = TensionStage(robot, StageSolver(solve, "survey"), live)
    changes = changes_of(stage, external, inertial) if changes_of else None
    distribute = changes.distribute if changes else stage.distribute
    due = changes.begin() if changes else -1
    numbers = np.arange(count) if samples is None else samples
    length, rate, tension = np.zeros((count, m)), np.zeros((count, m)), np.zeros((count, m))
    wrench, reports = np.zeros((count, 6)), np.zeros((count, 4))
    state, at = np.zeros(13), {"length": np.zeros(m), "rate": np.zeros(m)}
    accelerations = {"acceleration": np.zeros(3), "angular_acceleration": np.zeros(3)}
    required = np.zeros(6)
    geometry = bind("geometry", lines=line_table(robot), state=state, matrix=live.W, **at)
    given = {"inertial": inertial, "gravity": gravity, "state": state, **accelerations}
    inverse_dynamics = bind("inverse_dynamics", **given, wrench=required)
    for k, row in enumerate(desired):
        while changes and 0 <= due <= numbers[k]:
            due = changes.apply(due)
        state[:] = row[:13]
        geometry()
        length[k], rate[k] = at["length"], at["rate"]
        if not (length[k] >= tolerances.LENGTH).all():
            check_lengths(robot, row[:7])
        accelerations["acceleration"][:], accelerations["angular_acceleration"][:] = row[13:16], row[16:19]
        inverse_dynamics()
        live.wrench[:] = required - external
        distribute()
        wrench[k], tension[k], reports[k] = live.wrench, live.tension, live.report
    status, residual, margin, _ = reports.T
    return Survey(
        time=time,
        desired=desired,
        length=length,
        rate=rate,
        wrench=wrench,
        tension=tension,
        status=status,
        residual=residual,
        margin=margin,
    )
