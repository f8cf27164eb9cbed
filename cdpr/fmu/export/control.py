"""A controller and a tension solver in C, for exported FMUs: where their files lie, and what these are given."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import get_args

import numpy as np

from cdpr.fmu.export.variables import Variable, entrance, parameter
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.tension.policy import Policy

HEAD = '/* Written by the exporter. SPDX-License-Identifier: Apache-2.0 */\n#include "laws.h"\n'
TABLE = "chosen.c"

# The order in which source/control.c numbers them.
POLICIES: tuple[Policy, ...] = ("stop", "hold_tension", "best_effort")
assert set(POLICIES) == set(get_args(Policy))

# The desired motion: name, numbers, unit, text; together the 19 of `cdpr.model`.
DESIRED = (
    ("desired_position", 3, "m", "desired position of the platform's origin, world"),
    ("desired_quaternion", 4, "", "desired attitude, platform to world, w, x, y, z"),
    ("desired_velocity", 3, "m/s", "desired velocity of the origin, world axes"),
    ("desired_angular_velocity", 3, "rad/s", "desired angular velocity, world axes"),
    ("desired_acceleration", 3, "m/s2", "desired acceleration of the origin, world axes"),
    ("desired_angular_acceleration", 3, "rad/s2", "desired angular acceleration, world axes"),
)


def _chosen(law: str, solve: str, respects_bounds: bool) -> bytes:
    known = "".join(f"{kind} {name};\n" for kind, name in (("Law", law), ("Solve", solve)) if name != "NULL")
    rest = f"Law *const CHOSEN_LAW = {law};\nSolve *const CHOSEN_SOLVE = {solve};\n"
    return f"{HEAD}\n{known}{rest}const bool CHOSEN_RESPECTS_BOUNDS = {str(respects_bounds).lower()};\n".encode()


# The table of FMUs without a controller.
NOBODY = {TABLE: _chosen("NULL", "NULL", True)}


@dataclass(frozen=True, eq=False)
class Control:
    """What decides on tensions once in each control step.

    Attributes:
        law, solve: their C files; the functions bear the files' names.
        numbers: the controller's options by name, in the order of its C.
        robot: as controller and solver know it; its dof are the directions in which they balance the wrench.
        gravity: (3,), m/s^2, world.
        policy: what to do about a wrench for which there is no answer; best_effort ends the run unless the solver minds
            no limits, since nothing here searches the nearest wrench.
        desired: (19,) at the start.
    """

    law: Path
    solve: Path
    respects_bounds: bool
    numbers: Mapping[str, Array]
    robot: Robot
    gravity: Array
    control_step: float
    policy: Policy
    desired: Array

    def sources(self) -> dict[str, bytes]:
        """Return the C files of controller and solver by their names, and the table of them."""
        table = _chosen(f"{self.law.stem}_law", f"{self.solve.stem}_solve", self.respects_bounds)
        return {**{path.name: path.read_bytes() for path in (self.law, self.solve)}, TABLE: table}

    def inputs(self) -> list[Variable]:
        """Return the desired motion."""
        found, first = [], 0
        for name, size, unit, text in DESIRED:
            start = self.desired[first : first + size]
            found.append(entrance(name, size, unit, text, start, terminal="desired"))
            first += size
        return found

    def parameters(self) -> list[Variable]:
        """Return the controller's options and its step."""
        own = [
            parameter(f"controller.{name}", values.shape, "", values, f"{name} of the controller {self.law.stem}")
            for name, values in self.numbers.items()
        ]
        step = parameter("control_step", (), "s", [self.control_step], "time between decisions", False, least=0.0)
        return [*own, step]

    def constants(self) -> list[Variable]:
        """Return what it knows of the robot."""
        robot = self.robot
        moved = [float(name in robot.dof) for name in ("x", "y", "z", "rx", "ry", "rz")]
        policy = (float(POLICIES.index(self.policy)), robot.characteristic_length)
        rows = {
            "believed": [*robot.inertial.tolist(), *np.asarray(self.gravity).tolist()],
            "tension_min": robot.tension_min.tolist(),
            "tension_max": robot.tension_max.tolist(),
            "controlled": moved,
            "policy": policy,
        }
        return [
            Variable(name, "constant", (len(row),), "", tuple(map(float, row)), "what the controller knows")
            for name, row in rows.items()
        ]
