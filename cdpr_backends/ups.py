"""Cables as rigid legs, as in chapter 5 of the thesis: universal joint, actuated slide, ball joint.

A universal joint holds the leg at the frame, a slide along the leg pulls with the cable's tension, and a ball joint
closes the loop at the platform. It is a plant by other means, to compare the massless cables with; besides the legs'
weight, and the damping of their joints where that is asked for, it adds nothing but cost.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from cdpr.errors import PluginError
from cdpr.model import Robot, rotations
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.plugins import RigidBodyBackend
from cdpr_backends.ideal import require_ideal


@dataclass(frozen=True, eq=False)
class Leg:
    """One leg at the start, where all its joints stand at zero and its axes lie along the world's.

    Attributes:
        anchor: (3,) A_i, m, world.
        center: (3,) its centre of mass, half way to the platform, from the anchor, m.
        mass: kg.
        inertia: moment of inertia about its centre, kg m^2, the same about all axes: a rod has none along itself,
            which engines refuse, and the leg does not turn that way.
        tip: (3,) B_i in the body frame, m.
        axes: (3, 3) rows: the two hinges of the universal joint and the slide, world; forces along the slide push.
        rates: (3,) of these joints, rad/s, rad/s, m/s.
    """

    anchor: Array
    center: Array
    mass: float
    inertia: float
    tip: Array
    axes: Array
    rates: Array


def make_legs(anchors: Array, body: Array, mass: float) -> list[Leg]:
    """Legs of one mass (kg) between the anchors (m, 6) that close the loops in a body state (13,)."""
    R = rotations.matrix(body[3:7])
    legs = []
    for row in anchors:
        arm = R @ row[3:]
        reach = body[:3] + arm - row[:3]
        length = float(np.linalg.norm(reach))
        along = reach / length
        # The first hinge lies level: a leg may rise and fall as it likes, and is stuck only 90 degrees to its side.
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
    """A free platform on legs. The engine's `write` builds its world anew, with the legs for that pose.

    `applied` holds the external wrench alone; the engine pulls its slides with `command`, and damps all joints of the
    legs by their rates before the step (explicitly: very strong damping of light legs diverges).
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

    def legs(self) -> list[Leg]:
        """The legs for the pose in `body`."""
        return make_legs(self.frame.anchors, self.body, self.options.leg_mass)

    def forces(self, rates: Array) -> Array:
        """What acts at the joints (..., 3) of the legs with these rates: damping, and along the slides the pull."""
        forces = -self._damping * rates
        forces[..., 2] -= self.command
        return forces
