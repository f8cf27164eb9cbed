"""Parameters of a workspace, as data for files."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cdpr.analysis.workspace.required import NOTHING, Required
from cdpr.base.errors import CdprError
from cdpr.base.problems import shown
from cdpr.model import Robot
from cdpr.model.arrays import checked
from cdpr.model.robot import DOF_NAMES, Array, read_only
from cdpr.model.shapes import Box, Cylinder, Hull, Mesh, Obstacle, Shape, Sphere


@dataclass(frozen=True, eq=False)
class Question:
    """Parameters of all kinds of workspaces; each kind uses a part of them.

    Attributes:
        required: wrenches or accelerations that the cables must provide in addition to the weight at rest.
        gravity: (3,), m/s^2, world.
        length: divisor of moments, m; the robot's characteristic length by default.
        at_least: smallest value inside; that of the kind by default.
        obstacles: bodies that cables may touch, besides each other and their platform.
        diameter: diameter of all cables, m; by default their own, and 10 mm or less if they have none
            (`cdpr.mechanics.assumed_diameters`).
        axial_stiffness: E A of all cables, N; their own by default.
        direction: degree of freedom, such as "z", of the stiffness; the softest direction by default.
    """

    required: Required = NOTHING
    gravity: Array = field(default_factory=lambda: read_only(np.array([0.0, 0.0, -9.81])))
    length: float | None = None
    at_least: float | None = None
    obstacles: tuple[Obstacle, ...] = ()
    diameter: float | None = None
    axial_stiffness: float | None = None
    direction: str | None = None

    def check(self, robot: Robot) -> None:
        """Raise CdprError if a value is invalid."""
        checked(self.gravity, (3,), "gravity", finite=True)
        for name, unit in (("length", "m"), ("axial_stiffness", "N")):
            value = getattr(self, name)
            if value is not None and not 0.0 < value < math.inf:
                raise CdprError(f"{name}: expected a number above 0 {unit}, got {shown(value)}")
        if self.at_least is not None and not math.isfinite(self.at_least):
            raise CdprError(f"at_least: expected a finite number, got {shown(self.at_least)}")
        if self.direction is not None and self.direction not in robot.dof:
            raise CdprError(f"direction: expected one of {', '.join(robot.dof)}, got {shown(self.direction)}")

    def arm(self, robot: Robot) -> float:
        """Return the divisor of moments, m."""
        return robot.characteristic_length if self.length is None else float(self.length)

    def weights(self, robot: Robot) -> Array:
        """Return 1 for forces and 1 / length for moments, (n,), of the robot's degrees of freedom."""
        return np.asarray(np.repeat([1.0, 1.0 / self.arm(robot)], 3)[robot.rows])

    def to_dict(self, robot: Robot) -> dict[str, Any]:
        """Return the parameters as plain data."""
        return {
            "required": self.required.to_dict(),
            "gravity": np.asarray(self.gravity).tolist(),
            "length": self.arm(robot),
            "at_least": self.at_least,
            "obstacles": [
                {"name": each.name, **each.shape.outline, "position": each.position.tolist()}
                | {"attitude": each.attitude.tolist()}
                for each in self.obstacles
            ],
            "diameter": self.diameter,
            "axial_stiffness": self.axial_stiffness,
            "direction": self.direction,
        }

    @classmethod
    def from_plain(cls, data: dict[str, Any]) -> Question:
        """Return the question from the data of `plain`."""
        return cls(
            Required.from_plain(data["required"]),
            checked(data["gravity"], (3,), "gravity", finite=True),
            data["length"],
            data["at_least"],
            tuple(_obstacle(each) for each in data["obstacles"]),
            data["diameter"],
            data["axial_stiffness"],
            data["direction"],
        )


def _obstacle(data: dict[str, Any]) -> Obstacle:
    shape: Shape | Hull
    if "box" in data:
        x, y, z = map(float, data["box"])
        shape = Box((x, y, z))
    elif "sphere" in data:
        shape = Sphere(float(data["sphere"]))
    elif "cylinder" in data:
        shape = Cylinder(*map(float, data["cylinder"]))
    elif "hull" in data:
        shape = Hull("", tuple((float(x), float(y), float(z)) for x, y, z in data["hull"]))
    else:
        low, high = data["mesh"]
        shape = Mesh("", tuple(low), tuple(high))
    position, attitude = np.array(data["position"], dtype=float), np.array(data["attitude"], dtype=float)
    return Obstacle(str(data["name"]), shape, position, attitude)


def directions(robot: Robot) -> list[str]:
    """Return the names of a margin's limits: both directions of each degree of freedom."""
    return [sign + name for name in DOF_NAMES if name in robot.dof for sign in "+-"]
