"""Sizes as if in millimetres, masses and inertias that do not go with them.

Few sizes tell by themselves: there are robots of 0.2 m and of 600 m. What tells is that the sizes of one robot do not
go together, by orders of magnitude more than those of any robot that was built.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from cdpr.cables.chain import DIAMETER
from cdpr.cables.drum import RADIUS
from cdpr.fields import Section
from cdpr.model.shapes import Hull
from cdpr.problems import Path
from cdpr.scenario.plausible.setup import Finding, Setup
from cdpr.scenario.robot_schema import moments_about, tensor

LARGEST = 3e3  # m between frame anchors; those of the largest cable robot, the FAST telescope, are 600 m apart
# Frame anchors are apart by at most this times what platform anchors are: a camera of 0.3 m above a stadium of 200 m
# has 700, and FAST 50. One of both in millimetres shifts what is 2 to 30 otherwise by 1000, either way.
LARGEST_FRAME = 2000.0
LARGEST_PLATFORM = 20.0  # the other way round: rings and hoops around a small frame
# Of a body, the radius of gyration and the distance of its anchors: by less than this, a heavy core with long arms has
# 20. With lengths in millimetres beside kg m^2, or kg mm^2 beside metres, it is some 1000.
LARGEST_ARM = 200.0
LIGHTEST = 1e-4  # kg/m^3; air has 1.2, and an open lattice of 10 m and 100 kg 0.1; in millimetres steel has 8e-6
DEEPEST = 0.01  # of its longest side, how deep a dent is that is nothing but rough corners
THICKEST = 0.3  # m; the cables that carry bridges have 0.2
LARGEST_DRUM = 5.0  # m

METRES = "lengths are in metres"


def proportions(setup: Setup) -> Iterator[Finding]:
    """Anchors of frame and platform, against one another."""
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


def bodies(setup: Setup) -> Iterator[Finding]:
    """Inertia and shape of the platform, against its mass and its anchors."""
    path, section, body = (*setup.root, "platform"), setup.section.platform, setup.robot.platform
    arm = float(np.linalg.norm(setup.robot.anchors[:, 3:], axis=1).max())
    if section.inertia is not None and len(moments_about(section.inertia)) == 3 and arm > 0.0:
        gyration = math.sqrt(float(np.abs(tensor(section.inertia)).max()) / body.mass)
        if not 1.0 / LARGEST_ARM < arm / gyration < LARGEST_ARM:
            text = f"a body of {body.mass:.4g} kg with this inertia is some {gyration:.3g} m large, and its cables end "
            yield (*path, "inertia"), f"{text}{arm:.3g} m from its origin; kg, m and kg m^2 are expected"
    volume = _volume(body.outline or {})
    if volume > 0.0 and body.mass < LIGHTEST * volume:
        text = f"of {volume:.3g} m^3 a body of {body.mass:.4g} kg would be lighter than air; {METRES}"
        yield (*path, "shape"), text


def dents(setup: Setup) -> Iterator[Finding]:
    """Obstacles that are not convex: what cables may not touch is more than is there."""
    for i, each in enumerate(setup.obstacles):
        if isinstance(each.shape, Hull) and each.shape.dent > DEEPEST * np.ptp(each.shape.corners, axis=0).max():
            text = f"is not convex: its convex hull counts, {each.shape.dent:.3g} m above its deepest corners; draw "
            yield ("world", "obstacles", i, "mesh"), f"{text}several obstacles where that is too much"


def cable_sizes(setup: Setup) -> Iterator[Finding]:
    """Diameters of cables and drums."""
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
    """Volume (m^3) of a shape of `cdpr.model.shapes` as plain data; 0 where there is none."""
    for kind, size in outline.items():
        value = np.asarray(size, dtype=float)
        if kind == "box":
            return float(np.prod(value))
        if kind == "sphere":
            return float(4.0 / 3.0 * math.pi * value**3)
        if kind == "cylinder":
            return float(math.pi * value[0] ** 2 * value[1])
        return float(np.prod(np.abs(value[1] - value[0])))  # the box around a mesh
    return 0.0
