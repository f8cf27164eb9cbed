"""Robots of WireX, .wcrfx: chains, platform, winches and cables.

WireX is the library of Fraunhofer IPA (A. Pott, Cable-Driven Parallel Robots, Springer 2018, appendix). The matrix
a11 to a33 of a base turns the winch's axes into the world's; its cable arrives along their z and leaves over a pulley
of `radius`. `elasticity` is Young's modulus of the cable, so that E A = E pi r^2.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from cdpr.cables.pulley import Pulley
from cdpr.formats.read.choice import Choice
from cdpr.formats.read.imported import Imported, slug, unique
from cdpr.formats.read.inertia import filled
from cdpr.formats.read.xml import Element, parse, root_of
from cdpr.model.robot import DOF_NAMES
from cdpr.problems import Path as Key

PATTERNS = {"3R3T": DOF_NAMES, "3T": DOF_NAMES[:3]}
PLANAR = {"1R2T": 1, "2T": 0}
BREAKS = "breaking_load"
FLAT = 1e-9  # of their extent, how far anchors of a planar robot may be from its plane
ROTATION = 1e-5  # of a matrix of six digits


def recognise(content: bytes) -> bool:
    """Whether it is a file of robots with chains."""
    return root_of(content)[0] == "models" and b"<chain" in content


def leads(path: Path, content: bytes) -> bool:
    """Whether a robot is read from here."""
    return True


def read(path: Path, content: bytes, choice: Choice) -> Imported:
    """Read a robot. Raises FormatError."""
    root = parse(content, str(path))
    robots = root.all("robot")
    if len(robots) != 1:
        raise root.wrong(f"one <robot> is expected, got {len(robots)}: keep one in a file of its own")
    robot = robots[0]
    chains = robot.child("geometry").all("chain")
    if not chains:
        raise robot.wrong("the robot has no <chain>, so no cable")
    name = slug(robot.attributes.get("name", ""), slug(path.stem, "robot"))
    author = robot.attributes.get("author", "").strip()
    source = f"WireX: {path.name}, robot '{robot.attributes.get('name', '')}'" + (
        f", author {author}" if author else ""
    )
    found = Imported(name, source, {"name": name})
    rows, comments = _cables(found, root, robot, chains)
    anchors = np.array([[*row["frame"], *row["platform"]] for row in rows])
    dof = _dof(robot, anchors)
    found.robot["dof"] = list(dof)
    found.robot["platform"] = _platform(found, robot.child("platform"), anchors[:, 3:], dof)
    found.robot["tension"] = _tension(found, root, robot, rows)
    if (shared := _material(found, root)) is not None:
        found.robot["cable"] = shared
    found.robot["cables"] = rows
    found.comments |= comments
    found.comments["dof",] = f"motionpattern, line {robot.line}"
    return found


def _cables(
    found: Imported, root: Element, robot: Element, chains: list[Element]
) -> tuple[list[dict[str, Any]], dict[Key, str]]:
    rows, comments = list[dict[str, Any]](), dict[Key, str]()
    names = unique([slug(chain.attributes.get("id", ""), "cable") for chain in chains])
    radii = set()
    for k, (chain, name) in enumerate(zip(chains, names, strict=True)):
        base, platform = chain.child("base"), chain.child("platform")
        row: dict[str, Any] = {"name": name, "frame": _point(base), "platform": _point(platform)}
        radius = base.attribute_number("radius", 0.0)
        if radius > 0.0:
            radii.add(radius)
            row["exit"] = {"type": Pulley.kind(), "radius": radius, "axis": _matrix(base)[:, 2].tolist()}
        if (winch := _winch(root, chain)) is not None:
            speed = winch.child("cable").attribute_number("max_velocity", 0.0)
            if speed > 0.0:
                row["speed_max"] = speed
        rows.append(row)
        comments["cables", k] = f"line {chain.line}"
    comments["cables",] = "m; base and platform of each chain"
    if radii:
        sizes = ", ".join(f"{radius:g}" for radius in sorted(radii))
        found.warnings.append(
            f"{robot.file}:{chains[0].line}: cables leave over pulleys of {sizes} m, radius of <base>, which WireX "
            "leaves out in its standard kinematics; without the keys exit they leave from points"
        )
    return rows, comments


def _dof(robot: Element, anchors: Any) -> tuple[str, ...]:
    pattern = robot.attributes.get("motionpattern", "3R3T").strip()
    if pattern in PATTERNS:
        return tuple(PATTERNS[pattern])
    if pattern not in PLANAR:
        known = ", ".join([*PATTERNS, *PLANAR])
        raise robot.wrong(f"motionpattern: '{pattern}' is none that our robots have; there are {known}")
    frames = anchors[:, :3]
    extents = np.ptp(frames, axis=0)
    flat = np.flatnonzero(extents <= FLAT * extents.max())
    if len(flat) != 1:
        raise robot.wrong(
            f"motionpattern: '{pattern}' moves in a plane, and the bases do not lie in one along the axes"
        )
    normal = int(flat[0])
    moves = [name for k, name in enumerate("xyz") if k != normal]
    return (*moves, *([f"r{'xyz'[normal]}"] if PLANAR[pattern] else []))


def _platform(found: Imported, element: Element, anchors: Any, dof: tuple[str, ...]) -> dict[str, Any]:
    mass = element.attribute_number("mass")
    centre_, tensor = element.find("centerofgravity"), element.find("inertiatensor")
    centre = [0.0, 0.0, 0.0] if centre_ is None else _point(centre_)
    parts = ("Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz")
    xx, yy, zz, xy, xz, yz = (0.0 if tensor is None else tensor.attribute_number(part, 0.0) for part in parts)
    turns = [name for name in dof if name.startswith("r")]
    try:
        inertia, told = filled((xx, yy, zz, xy, xz, yz), mass, anchors - centre, turning=bool(turns))
    except ValueError as error:
        raise (tensor or element).wrong(str(error)) from None
    if told:
        found.warnings.append(f"{element.file}:{(tensor or element).line}: {told}")
    found.comments["platform", "mass"] = f"kg, line {element.line}"
    found.comments["platform", "center_of_mass"] = "m, centerofgravity"
    found.comments["platform", "inertia"] = "kg m^2, inertiatensor"
    return {"mass": mass, **({} if inertia is None else {"inertia": list(inertia)}), "center_of_mass": centre}


def _tension(found: Imported, root: Element, robot: Element, rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Limits: those of the application, else of the winches, else what the cable breaks at."""
    use, cable = robot.find("application"), root.find("cable")
    low = use.attribute_number("min_cable_load", 0.0) if use else 0.0
    low = low or (cable.attribute_number("minimum_load", 0.0) if cable else 0.0)
    highs = list[float]()
    for chain in robot.child("geometry").all("chain"):
        winch = _winch(root, chain)
        given = [
            (use, "max_cable_load"),
            (winch.child("cable") if winch is not None else None, "f_max"),
            (cable, BREAKS),
        ]
        told = [(each.attribute_number(key, 0.0), key, each.line) for each, key in given if each is not None]
        high, key, line = next((one for one in told if one[0] > 0.0), (0.0, "", 0))
        if not high > low:
            text = "max_cable_load of <application>, f_max of its winch's <cable> and breaking_load of <cable>"
            raise chain.wrong(
                f"chain '{chain.attributes.get('id', '')}': no largest tension above {low:g} N; {text} say one"
            )
        if key == BREAKS and not highs:
            found.warnings.append(
                f"{chain.file}:{chain.line}: the largest tension is what the cable breaks at, {high:g} N: winchtype "
                f"'{chain.attributes.get('winchtype', '')}' is no winch of this file with an f_max"
            )
        highs.append(high)
        found.comments["tension", "max"] = f"N, {key}, line {line}"
    if low == 0.0:
        found.warnings.append(f"{robot.file}:{robot.line}: the smallest tension is 0 N: no min_cable_load is there")
    return {"min": low, "max": highs[0] if len(set(highs)) == 1 else highs}


def _material(found: Imported, root: Element) -> dict[str, Any] | None:
    """What all cables have in common."""
    cable = root.find("cable")
    if cable is None:
        return None
    radius, modulus = cable.attribute_number("radius", 0.0), cable.attribute_number("elasticity", 0.0)
    weight, made = cable.attribute_number("weight", 0.0), dict[str, Any]()
    if radius > 0.0:
        made["diameter"] = 2.0 * radius
        found.comments["cable", "diameter"] = f"m, twice radius, line {cable.line}"
        if modulus > 0.0:
            made["axial_stiffness"] = modulus * math.pi * radius**2
            found.comments["cable", "axial_stiffness"] = f"N, elasticity times pi radius^2, line {cable.line}"
    if weight > 0.0:
        made["linear_density"] = weight
        found.comments["cable", "linear_density"] = f"kg/m, weight, line {cable.line}"
    for key in ("damping", BREAKS):
        if cable.attribute_number(key, 0.0) > 0.0 and key not in found.comments["tension", "max"]:
            found.left_out.append(f"{cable.file}:{cable.line}: {key} of <cable>: its unit, or what it is for, differs")
    for winch in root.all("winch"):
        found.left_out.append(
            f"{winch.file}:{winch.line}: winch '{winch.attributes.get('name', '')}': motor and drum; for winches of "
            "your own see docs/cables.md"
        )
    return made or None


def _winch(root: Element, chain: Element) -> Element | None:
    wanted = chain.attributes.get("winchtype", "")
    return next((each for each in root.all("winch") if each.attributes.get("name") == wanted), None)


def _point(element: Element) -> list[float]:
    return [element.attribute_number(axis) for axis in "xyz"]


def _matrix(element: Element) -> Any:
    """The rotation (3, 3) of a base."""
    identity = np.eye(3)
    rows = [[element.attribute_number(f"a{i}{j}", identity[i - 1, j - 1]) for j in (1, 2, 3)] for i in (1, 2, 3)]
    R = np.array(rows)
    if not np.allclose(R @ R.T, identity, atol=ROTATION) or np.linalg.det(R) < 0.0:
        raise element.wrong("a11 to a33 are no rotation")
    return R
