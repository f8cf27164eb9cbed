"""New robots from a few sizes: boxes as frame and platform, and a cable layout without interference."""

from __future__ import annotations

import json
from collections.abc import Iterable
from copy import deepcopy
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.model import Robot
from cdpr.model.rotations import from_rpy
from cdpr.scenario.robot_schema import RobotSection
from cdpr.scenario.schema import World
from cdpr.scenario.static_feasibility import holds, pulls_against_itself
from cdpr.scenario.template import layouts
from cdpr.scenario.template.free_share import FreeShare, free_share

DIGITS = 6  # micrometres

# Allowed sizes: anchors that differ by micrometres, and inertias that files may contain.
LENGTHS = (1e-4, 2e3)  # m
MASSES = (1e-9, 1e6)  # kg

# Limits relative to the weight: low enough to be feasible, high enough to keep cables straight, and reserves for
# motion.
LOWEST = 0.05
HIGHEST = (2.0, 5.0, 10.0, 20.0)

# Required interference-free fraction of the static workspace, else a warning; 0.8 with a margin for the coarse grid.
FREE = 0.85


@dataclass(frozen=True)
class Sizes:
    """Sizes of a new robot.

    Attributes:
        frame: width (x), depth (y) and height (z) of the box, standing on the floor, whose corners are the anchors, m.
        platform: width, depth and height of the platform, m.
        mass: mass of the platform, kg.
        cables: number of cables, see `layouts`; None for the default.
        crossed: True for cables that cross at the platform; straight ones are less stiff.
        planar: True for motion in the x-z plane.
        suspended: True for eight cables from above; three, four and six always are.
    """

    frame: tuple[float, float, float] = (4.0, 3.0, 2.5)
    platform: tuple[float, float, float] = (0.4, 0.3, 0.2)
    mass: float = 20.0
    cables: int | None = None
    crossed: bool = True
    planar: bool = False
    suspended: bool = False


def robot_data(sizes: Sizes, name: str) -> dict[str, Any]:
    """Return the plain data of the robot file; raise CdprError if no layout balances the weight."""
    for parts, (low, high), unit in (((*sizes.frame, *sizes.platform), LENGTHS, "m"), ((sizes.mass,), MASSES, "kg")):
        for part in parts:
            if not low <= part <= high:  # also rejects NaN
                what = "mass" if unit == "kg" else "frame and platform"
                hint = "; lengths are in metres" if unit == "m" and part > high else ""
                raise CdprError(f"{what}: expected {low:g} to {high:g} {unit}, got {part:g} {unit}{hint}")
    if any(part >= around for part, around in zip(sizes.platform, sizes.frame, strict=True)):
        raise CdprError(f"the platform, {sizes.platform} m, must be smaller than the frame, {sizes.frame} m")
    return {"name": name, **deepcopy(_freest(sizes)[0])}


@lru_cache(16)
def _freest(sizes: Sizes) -> tuple[dict[str, Any], FreeShare]:
    """Return the data of the robot whose cables interfere least, without a name, and its share."""
    count = (4 if sizes.planar else 8) if sizes.cables is None else sizes.cables
    best: tuple[dict[str, Any], FreeShare] | None = None
    most = -1.0
    for rows in _layouts(sizes, count):
        data = _robot(sizes, rows, count)
        if data is None:
            continue
        share = share_of(_section(data).to_robot(), sizes)
        free = share.value if share.home else 0.0
        if free > most:
            best, most = (data, share), free
        if free >= FREE:
            break
    if best is None:
        remedy = "a smaller platform or a higher frame" if sizes.crossed else "crossed cables (--crossed)"
        raise CdprError(
            f"{count} cables of these sizes do not hold the platform in the middle of the frame: try {remedy}"
        )
    return best


def share_of(robot: Robot, sizes: Sizes) -> FreeShare:
    """Return the interference-free share of a new robot's static workspace."""
    (x, y, z), (X, Y, Z) = (0.5 * np.array(size) for size in (sizes.platform, sizes.frame))
    low, high = np.array([x - X, y - Y, z]), np.array([X - x, Y - y, 2.0 * Z - z])
    if sizes.planar:
        low[1] = high[1] = 0.0
    return free_share(robot, low, high, np.array(World().gravity))


def crowded(sizes: Sizes) -> str | None:
    """Return a warning if less than `FREE` of a new robot's static workspace is free of interference."""
    _, share = _freest(sizes)
    if share.value >= FREE and share.home:
        return None
    remedy = "a deeper platform" if sizes.planar else "a larger platform"
    if sizes.crossed:
        remedy += ", or straight cables (--straight)"
    where = "" if share.home else "at home, and "
    return (
        f"cables of {1e3 * share.diameter:.3g} mm touch each other or the platform {where}at "
        f"{share.static - share.free} of the {share.static} upright poses at which they hold it, of {share.poses} "
        f"on a grid within the frame: try {remedy}"
    )


def _robot(sizes: Sizes, rows: layouts.Rows, count: int) -> dict[str, Any] | None:
    """Return the data of a robot with these cables and the lowest feasible limits; None if none are feasible."""
    dof = layouts.PLANE if sizes.planar else layouts.POINT if count < 6 else layouts.SPACE
    weight = sizes.mass * float(np.linalg.norm(World().gravity))
    home = [0.0, 0.0, _tidy(0.5 * sizes.frame[2])]
    body: dict[str, Any] = {"mass": sizes.mass}
    if "ry" in dof:
        body["inertia"] = _inertia(sizes)
    data: dict[str, Any] = {
        "dof": dof,
        "platform": {**body, "shape": {"box": list(sizes.platform)}},
        "home": {"position": home},
        "cables": [{"frame": [*map(_tidy, A)], "platform": [*map(_tidy, B)]} for A, B in rows],
    }
    for highest in HIGHEST:
        limits = {"min": _rounded(LOWEST * weight), "max": _rounded(highest * weight)}
        robot = _section({**data, "tension": limits}).to_robot()
        at = np.array(home), from_rpy(0.0, 0.0, 0.0)
        hangs = np.ptp(robot.anchors[:, 2]) == 0.0
        sound = hangs or pulls_against_itself(robot, *at)
        if sound and holds(robot, *at, np.array(World().gravity)):
            return {**{key: data[key] for key in ("dof", "platform")}, "tension": limits, **data}
    return None


def _section(data: dict[str, Any]) -> RobotSection:
    return RobotSection.model_validate_json(json.dumps(data))


def _layouts(sizes: Sizes, count: int) -> Iterable[layouts.Rows]:
    """Return the layouts to try, in order of preference."""
    frame, platform, crossed = sizes.frame, sizes.platform, sizes.crossed
    if sizes.planar:
        if count != 4 or sizes.suspended:
            raise CdprError(f"a planar robot has 4 cables, one at each corner, got {_layout(sizes, count)}")
        return [layouts.planar(frame, platform, crossed=crossed)]
    if count in (3, 4):
        return [layouts.point(frame, platform, count)]
    if count == 6:
        return [layouts.six(frame, platform)]
    if count == 7 and not sizes.suspended:
        return layouts.seven(frame, platform, crossed=crossed)
    if count == 8 and sizes.suspended:
        return layouts.crossed_suspended(frame, platform) if crossed else [layouts.suspended(frame, platform)]
    if count == 8:
        return layouts.eight(frame, platform, crossed=crossed)
    raise CdprError(
        "8 or 7 cables hold a platform from all sides; suspended (--suspended), 8 or 6 move it in space, and 3 or 4 a "
        f"point; a planar robot (--planar) has 4; got {_layout(sizes, count)}; to have others, write one of these and "
        "change its cables"
    )


def _layout(sizes: Sizes, count: int) -> str:
    return f"{count} suspended" if sizes.suspended else f"{count}"


def _inertia(sizes: Sizes) -> list[float]:
    """Return the inertia of a homogeneous box."""
    a, b, c = (size**2 * sizes.mass / 12.0 for size in sizes.platform)
    return [*map(_rounded_to_six, (b + c, a + c, a + b)), 0.0, 0.0, 0.0]


def _rounded_to_six(value: float) -> float:
    return float(f"{value:.6g}")


def _rounded(value: float) -> float:
    return float(f"{value:.2g}")


def _tidy(value: float) -> float:
    return round(float(value), DIGITS) + 0.0
