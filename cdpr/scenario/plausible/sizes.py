"""Checks of sizes in millimetres, and of masses and inertias that do not match them.

Few sizes are conclusive on their own: robots exist from 0.2 m to 600 m. Sizes of one robot that differ by orders of
magnitude more than those of any existing robot are conclusive.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from cdpr.base.fields import Section
from cdpr.base.problems import Path
from cdpr.cables.chain import DIAMETER
from cdpr.cables.drum import RADIUS
from cdpr.model.shapes import Hull
from cdpr.scenario.plausible.setup import Finding, Setup
from cdpr.scenario.robot_schema import moments_about, tensor

LARGEST = 3e3  # m between frame anchors; the largest cable robot, the FAST telescope, has 600 m
# Largest ratio of the extents of frame and platform anchors: a camera of 0.3 m above a stadium of 200 m has 700, and
# FAST 50. With one of both in millimetres, the usual 2 to 30 changes by a factor of 1000.
LARGEST_FRAME = 2000.0
LARGEST_BODY = 50.0  # m between platform anchors; the cabin of FAST has 13 m
LARGEST_PLATFORM = 20.0  # the inverse ratio: rings and hoops around a small frame
# Largest ratio between radius of gyration and anchor distance, either way: a heavy core with long arms has 20. Lengths
# in millimetres with kg m^2, or kg mm^2 with metres, give about 1000.
LARGEST_ARM = 200.0
LIGHTEST = 1e-4  # kg/m^3; air 1.2, an open lattice of 10 m and 100 kg 0.1; steel in millimetres 8e-6
DEEPEST = 0.01  # depth of a dent relative to the longest side, below which it counts as a rough corner
THICKEST = 0.3  # m; cables of suspension bridges have 0.2
LARGEST_DRUM = 5.0  # m

METRES = "lengths are in metres"


def proportions(setup: Setup) -> Iterator[Finding]:
    """Yield anchors of frame and platform whose sizes do not match."""
    cables = (*setup.root, "cables")
    frame = setup.extent
    platform = float(np.linalg.norm(np.ptp(setup.robot.anchors[:, 3:], axis=0)))
    if frame > LARGEST:
        yield cables, f"the frame's anchors are {frame:.4g} m apart; {METRES}: in millimetres that is {_metres(frame)}"
    elif platform > LARGEST_PLATFORM * frame > 0.0:
        text = f"the platform's anchors are {platform:.4g} m apart, those on the frame {frame:.4g} m; {METRES}"
        yield cables, f"{text}: in millimetres the platform's are {_metres(platform)}"
    elif frame > LARGEST_FRAME * platform > 0.0:
        text = f"the frame's anchors are {frame:.4g} m apart, those on the platform {platform:.4g} m; {METRES}"
        yield cables, f"{text}: in millimetres the frame's are {_metres(frame)}"
    elif platform > LARGEST_BODY:
        text = f"the platform's anchors are {platform:.4g} m apart, those on the frame {frame:.4g} m; {METRES}"
        yield cables, f"{text}: in millimetres that is {_metres(platform)} and {_metres(frame)}"


def bodies(setup: Setup) -> Iterator[Finding]:
    """Yield inertia and shape of the platform that do not match its mass and anchors."""
    path, section, body = (*setup.root, "platform"), setup.section.platform, setup.robot.platform
    arm = float(np.linalg.norm(setup.robot.anchors[:, 3:], axis=1).max())
    if section.inertia is not None and len(moments_about(section.inertia)) == 3 and arm > 0.0:
        gyration = math.sqrt(float(np.abs(tensor(section.inertia)).max()) / body.mass)
        if not 1.0 / LARGEST_ARM < arm / gyration < LARGEST_ARM:
            text = f"a body of {body.mass:.4g} kg with this inertia is some {gyration:.3g} m large, and its cables end "
            hint = f"; {METRES}: in millimetres that is {_metres(arm)}" if arm > gyration else ""
            yield (*path, "inertia"), f"{text}{arm:.3g} m from its origin; expected kg, m and kg m^2{hint}"
    volume = _volume(body.outline or {})
    if volume > 0.0 and body.mass < LIGHTEST * volume:
        text = f"of {volume:.3g} m^3 a body of {body.mass:.4g} kg would be lighter than air; {METRES}"
        yield (*path, "shape"), text


def dents(setup: Setup) -> Iterator[Finding]:
    """Yield obstacles that are not convex: the convex hull is larger than the obstacle."""
    for i, each in enumerate(setup.obstacles):
        if isinstance(each.shape, Hull) and each.shape.dent > DEEPEST * np.ptp(each.shape.corners, axis=0).max():
            text = f"is not convex: its convex hull counts, {each.shape.dent:.3g} m above its deepest corners; draw "
            yield ("world", "obstacles", i, "mesh"), f"{text}several obstacles where that is too much"


def cable_sizes(setup: Setup) -> Iterator[Finding]:
    """Yield too large diameters of cables and drums."""
    section, root = setup.section, setup.root
    given: list[tuple[Path, Section | None]] = [((*root, "cable"), section.cable)]
    given += [((*root, "cables", i), cable) for i, cable in enumerate(section.cables)]
    for path, cable in given:
        diameter = getattr(cable, DIAMETER.key)
        if diameter is not None and diameter > THICKEST:
            yield (*path, "diameter"), f"a cable {diameter:.4g} m thick; {METRES}: in millimetres {_metres(diameter)}"
    winches = [(root, section.winch)]
    winches += [((*root, "cables", i), cable.winch) for i, cable in enumerate(section.cables)]
    for path, winch in winches:
        radius = getattr(winch, RADIUS.key, None)
        if radius is not None and radius > LARGEST_DRUM:
            text = f"a drum of {radius:.4g} m; {METRES}: in millimetres {_metres(radius)}"
            yield (*path, "winch", RADIUS.key), text


def _metres(millimetres: float) -> str:
    return f"{millimetres / 1000.0:.4g} m"


def _volume(outline: dict[str, object]) -> float:
    """Return the volume (m^3) of a shape of `cdpr.model.shapes` as plain data; 0 if there is none."""
    for kind, size in outline.items():
        value = np.asarray(size, dtype=float)
        if kind == "box":
            return float(np.prod(value))
        if kind == "sphere":
            return float(4.0 / 3.0 * math.pi * value**3)
        if kind == "cylinder":
            return float(math.pi * value[0] ** 2 * value[1])
        return float(np.prod(np.abs(value[1] - value[0])))  # bounding box of a mesh
    return 0.0
