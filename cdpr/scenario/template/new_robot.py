"""A robot from a few sizes: a box as frame, a box as platform, and a layout of cables that is known to hold."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import numpy as np

from cdpr.errors import CdprError
from cdpr.model.rotations import from_rpy
from cdpr.scenario.hold import holds, pulls_against_itself
from cdpr.scenario.robot_schema import RobotSection
from cdpr.scenario.schema import World

Rows = list[tuple[list[float], list[float]]]  # A_i and B_i of each cable, m

CORNERS = ((-1, -1), (1, -1), (1, 1), (-1, 1))
DIGITS = 6  # micrometres

# What a robot may be made from: anchors that micrometres tell apart, and inertias that files may hold.
LENGTHS = (1e-4, 2e3)  # m
MASSES = (1e-9, 1e6)  # kg

# Of the weight: low enough to be found, high enough to keep cables straight, and room for what moves the platform.
LOWEST = 0.05
HIGHEST = (2.0, 5.0, 10.0, 20.0)


@dataclass(frozen=True)
class Sizes:
    """What a new robot is made from.

    Attributes:
        frame: width (x), depth (y) and height (z) of the box at whose corners the cables leave, on the floor, m.
        platform: the same of the platform, m.
        mass: of the platform, kg.
        cables: how many: see `layouts`.
        crossed: whether cables cross at the platform; straight ones hold it less firmly and leave more room around it.
        planar: whether it moves in the plane of x and z alone.
    """

    frame: tuple[float, float, float] = (4.0, 3.0, 2.5)
    platform: tuple[float, float, float] = (0.4, 0.3, 0.2)
    mass: float = 20.0
    cables: int | None = None
    crossed: bool = True
    planar: bool = False


def robot_data(sizes: Sizes, name: str) -> dict[str, Any]:
    """Return the robot as the plain data of its file; CdprError where none of these sizes holds its own weight."""
    for parts, (low, high), unit in (((*sizes.frame, *sizes.platform), LENGTHS, "m"), ((sizes.mass,), MASSES, "kg")):
        for part in parts:
            if not low <= part <= high:  # not a number is neither
                what = "mass" if unit == "kg" else "frame and platform"
                raise CdprError(f"{what}: from {low:g} to {high:g} {unit} is expected, got {part:g} {unit}")
    if any(part >= around for part, around in zip(sizes.platform, sizes.frame, strict=True)):
        raise CdprError(f"the platform, {sizes.platform} m, must be smaller than the frame, {sizes.frame} m")
    count = (4 if sizes.planar else 8) if sizes.cables is None else sizes.cables
    dof, rows = _layout(sizes, count)
    weight = sizes.mass * float(np.linalg.norm(World().gravity))
    home = [0.0, 0.0, _tidy(0.5 * sizes.frame[2])]
    body: dict[str, Any] = {"mass": sizes.mass}
    if "ry" in dof:
        body["inertia"] = _inertia(sizes)
    data: dict[str, Any] = {
        "name": name,
        "dof": dof,
        "platform": {**body, "shape": {"box": list(sizes.platform)}},
        "home": {"position": home},
        "cables": [{"frame": [*map(_tidy, A)], "platform": [*map(_tidy, B)]} for A, B in rows],
    }
    for highest in HIGHEST:
        limits = {"min": _rounded(LOWEST * weight), "max": _rounded(highest * weight)}
        robot = RobotSection.model_validate_json(json.dumps({**data, "tension": limits})).to_robot()
        at = np.array(home), from_rpy(0.0, 0.0, 0.0)
        hangs = np.ptp(robot.anchors[:, 2]) == 0.0
        sound = hangs or pulls_against_itself(robot, *at)
        if sound and holds(robot, *at, np.array(World().gravity)):
            return {**{key: data[key] for key in ("name", "dof", "platform")}, "tension": limits, **data}
    remedy = "a smaller platform or a higher frame" if sizes.crossed else "crossed cables (--crossed)"
    raise CdprError(f"{count} cables of these sizes do not hold the platform in the middle of the frame: try {remedy}")


def _layout(sizes: Sizes, count: int) -> tuple[list[str], Rows]:
    """Degrees of freedom, and the cables."""
    (X, Y, Z), (x, y, z) = (0.5 * np.array(size) for size in (sizes.frame, sizes.platform))
    if sizes.planar:
        if count != 4:
            raise CdprError(f"a planar robot has 4 cables, one at each corner, got {count}")
        turned = -1.0 if sizes.crossed else 1.0
        return ["x", "z", "ry"], [
            ([a * X, 0.0, Z + b * Z], [a * x, 0.0, turned * b * z]) for a, b in ((-1, 1), (1, 1), (1, -1), (-1, -1))
        ]
    if count == 3:  # two corners and the middle of the edge between the others
        return ["x", "y", "z"], [([a * X, b * Y, 2.0 * Z], [0.0, 0.0, 0.0]) for a, b in ((-1, -1), (1, -1), (0, 1))]
    if count == 4:
        return ["x", "y", "z"], [([a * X, b * Y, 2.0 * Z], [0.0, 0.0, 0.0]) for a, b in CORNERS]
    if count == 7:  # four from above, two corners and the middle of an edge below; crossed, they hold it fast
        turned = -1.0 if sizes.crossed else 1.0
        above = [([a * X, b * Y, 2.0 * Z], [turned * a * x, b * y, z]) for a, b in CORNERS]
        below = [([a * X, b * Y, 0.0], [turned * a * x, b * y, z]) for a, b in ((-1, -1), (1, -1), (0, 1))]
        return ["x", "y", "z", "rx", "ry", "rz"], [*above, *below]
    if count != 8:
        text = (
            "8 or 7 cables move a platform in space, 3 or 4 a point that hangs from them, 4 a planar robot (--planar)"
        )
        raise CdprError(f"{text}, got {count}; to have others, write one of these and change its cables")
    rows: Rows = []
    for level in (1.0, -1.0):
        for a, b in CORNERS:
            if sizes.crossed:  # the upper ones to the lower corners across x, the lower ones to the upper across y
                end = [-level * a * x, level * b * y, -level * z]
            else:  # to the middles of the edges: at the corners, similar boxes could not be turned about z
                end = [a * x * (level > 0), b * y * (level < 0), level * z]
            rows.append(([a * X, b * Y, Z + level * Z], end))
    return ["x", "y", "z", "rx", "ry", "rz"], rows


def _inertia(sizes: Sizes) -> list[float]:
    """Of a homogeneous box."""
    a, b, c = (size**2 * sizes.mass / 12.0 for size in sizes.platform)
    return [*map(_rounded_to_six, (b + c, a + c, a + b)), 0.0, 0.0, 0.0]


def _rounded_to_six(value: float) -> float:
    return float(f"{value:.6g}")


def _rounded(value: float) -> float:
    return float(f"{value:.2g}")


def _tidy(value: float) -> float:
    return round(float(value), DIGITS) + 0.0
