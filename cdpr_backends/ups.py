"""Cables as rigid legs, as in chapter 5 of the thesis: universal joint, actuated slide, spherical joint.

A universal joint holds the leg at the frame. A slide along the leg pulls with the tension of the cable. A spherical
joint closes the loop at the platform. The legs serve for comparisons with massless cables. Apart from their weight and
the optional damping of their joints, they add only computation time.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from cdpr.base.errors import PluginError
from cdpr.mechanics.anchors import Anchors
from cdpr.model import Robot, rotations
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.plugins import RigidBodyBackend
from cdpr_backends.ideal import require_ideal


@dataclass(frozen=True, eq=False)
class Leg:
    """Leg at the start of a run, with all joints at zero and its axes along those of the world.

    Attributes:
        anchor: (3,) anchor A_i in the world frame [m].
        center: (3,) centre of mass, half way to the platform, relative to the anchor [m].
        mass: mass [kg].
        inertia: moment of inertia about the centre of mass [kg m^2], the same about all axes. A rod has none about its
            own axis, which engines reject, and the leg does not rotate about it.
        tip: (3,) anchor B_i in the body frame [m].
        axes: (3, 3) rows: the two hinges of the universal joint and the slide, in world axes; positive slide forces
            push.
        rates: (3,) rates of these joints [rad/s, rad/s, m/s].
    """

    anchor: Array
    center: Array
    mass: float
    inertia: float
    tip: Array
    axes: Array
    rates: Array


def make_legs(anchors: Array, body: Array, mass: float) -> list[Leg]:
    """Return the legs of one mass [kg] between the anchors (m, 6) that close the loops in a body state (13,)."""
    R = rotations.matrix(body[3:7])
    legs = []
    for row in anchors:
        arm = R @ row[3:]
        reach = body[:3] + arm - row[:3]
        length = float(np.linalg.norm(reach))
        along = reach / length
        # The first hinge is horizontal. A leg swings freely up and down, and is singular only at 90 degrees to the
        # side.
        level = np.cross([0.0, 0.0, 1.0], along)
        if np.linalg.norm(level) < 1e-6:
            level = np.array([1.0, 0.0, 0.0]) - along[0] * along
        first = level / np.linalg.norm(level)
        second = np.cross(along, first)
        velocity = body[7:10] + np.cross(body[10:], arm)
        swing = np.cross(along, velocity) / length
        rates = np.array([first @ swing, second @ swing, along @ velocity])
        axes = np.array([first, second, along])
        legs.append(Leg(row[:3], reach / 2, mass, mass * length**2 / 12, row[3:], axes, rates))
    return legs


class UpsBackend(RigidBodyBackend):
    """Free platform on legs. `write` of the engine rebuilds its world with the legs for the pose.

    `applied` contains only the external wrench. The engine pulls its slides with `command`. It damps all joints of the
    legs by their rates before the step. (This is explicit: very strong damping of light legs diverges.)
    """

    def __init__(self, robot: Robot, gravity: Array, physics_step: float, options: Any) -> None:
        if robot.n < 6:
            raise PluginError(f"cables: ups needs a free platform; robot '{robot.name}' has dof {', '.join(robot.dof)}")
        require_ideal(robot, "ups")
        super().__init__(robot, gravity, physics_step, options)
        frame = self.frame
        self._damping = np.array([options.hinge_damping, options.hinge_damping, options.slide_damping])
        slack = np.zeros(robot.m)  # the slides already pull
        self._pull = bind(
            "applied_wrench",
            lines=frame.line_table,
            offset=frame.offset,
            tension=slack,
            external=self.external,
            body=self.body,
            applied=self.applied,
        )

    def follow(self, anchors: Anchors) -> None:
        """Reject anchors that move: the legs are joined to the world.

        Raises:
            PluginError: always.
        """
        raise PluginError("cables: ups does not support anchors that move; set cables: ideal")

    def legs(self) -> list[Leg]:
        """Return the legs for the pose in `body`."""
        return make_legs(self.frame.anchors, self.body, self.options.leg_mass)

    def forces(self, rates: Array) -> Array:
        """Return the joint forces (..., 3) of legs with these rates: damping, and the pull of the slides."""
        forces = -self._damping * rates
        forces[..., 2] -= self.command
        return forces
