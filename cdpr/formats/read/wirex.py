"""Reader of WireX robots, .wcrfx: chains, platform, winches and cables.

WireX is the library of Fraunhofer IPA (A. Pott, Cable-Driven Parallel Robots, Springer 2018, appendix). The orientation
of a base maps winch axes to world axes; the cable arrives along z and leaves over a pulley of `radius`. `elasticity` is
Young's modulus of the cable, so that E A = E pi r^2. If the XML specification (0.32) and files written by WireX use
different names, both are read. The number `inf` means not given.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from cdpr.base.problems import Path as Key
from cdpr.cables.pulley import Pulley
from cdpr.formats.read import wirex_parts
from cdpr.formats.read.import_options import Choice
from cdpr.formats.read.imported import Imported, slug, unique
from cdpr.formats.read.inertia import filled
from cdpr.formats.read.wirex_parts import Parts, attribute, number
from cdpr.formats.read.xml import Element, parse, root_of
from cdpr.model.robot import DOF_NAMES

PATTERNS = {"3R3T": DOF_NAMES, "3T": DOF_NAMES[:3]}
PLANAR = {"1R2T": 1, "2T": 0}
BREAKS = "breaking_load"
FLAT = 1e-9  # largest distance of a planar robot's anchors from its plane, relative to their extent
# Alternative names: in files, and in the specification.
PATTERN = ("motionpattern", "motion_pattern")
PLATFORM = ("platform", "end_effector")
TENSOR = ("inertiatensor", "inertia")
CENTRE = ("centerofgravity", "centre_of_gravity", "center_of_gravity")
META = ("id", "version", "author", "description", "generator", "creator", "name", "material")  # metadata


def recognise(content: bytes) -> bool:
    """Return True if the content is a file of robots with chains."""
    return root_of(content)[0] == "models" and b"<chain" in content


def is_main_file(path: Path, content: bytes) -> bool:
    """Return True: a robot can be read from each WireX file."""
    return True


def read(path: Path, content: bytes, choice: Choice) -> Imported:
    """Read a robot.

    Raises:
        FormatError: if the file is invalid or not representable.
    """
    root = parse(content, str(path))
    robots = root.all("robot")
    if len(robots) != 1:
        raise root.wrong(f"expected one <robot>, got {len(robots)}: keep one per file")
    robot = robots[0]
    chains = robot.child("geometry").all("chain")
    if not chains:
        raise robot.wrong("the robot has no <chain>, so no cable")
    name = slug(robot.attributes.get("name", ""), slug(path.stem, "robot"))
    author = robot.attributes.get("author", "").strip()
    source = f"WireX: {path.name}, robot '{robot.attributes.get('name', '')}'" + (
        f", author {author}" if author else ""
    )
    found = Imported(name, source, {"name": name}, [root])
    for element in (root, robot, *root.all("cable"), *root.all("winch")):
        element.touch(*META)
    platform = wirex_parts.one_of(robot, PLATFORM)
    if platform is None:
        raise robot.wrong("expected one <platform> within <robot>, got 0")
    parts = [wirex_parts.parts(found, root, robot, chain) for chain in chains]
    rows = _cables(found, robot, parts)
    anchors = np.array([[*row["frame"], *row["platform"]] for row in rows])
    dof = _dof(robot, platform, anchors)
    found.robot["dof"] = list(dof)
    found.robot["platform"] = _platform(found, platform, anchors[:, 3:], dof)
    found.robot["tension"] = _tension(found, robot, parts, choice.tension)
    shared, own = wirex_parts.material(found, parts)
    if shared:
        found.robot["cable"] = shared
    found.robot["cables"] = [row | more for row, more in zip(rows, own, strict=True)]
    found.comments["dof",] = f"motionpattern, line {robot.line}"
    for key in ("damping", BREAKS):
        cable = next((each.cable for each in parts if each.cable is not None), None)
        if cable is not None and number(cable, key) > 0.0 and key not in found.comments["tension", "max"]:
            found.left_out.append(f"{cable.at}: {key} of <cable>: its unit or its purpose differs")
    return found


def _cables(found: Imported, robot: Element, parts: list[Parts]) -> list[dict[str, Any]]:
    rows, comments = list[dict[str, Any]](), dict[Key, str]()
    names = unique([slug(each.chain.attributes.get("id", ""), "cable") for each in parts])
    radii = set()
    for k, (each, name) in enumerate(zip(parts, names, strict=True)):
        base, platform = each.chain.child("base"), each.chain.child("platform")
        row: dict[str, Any] = {"name": name, "frame": _point(base), "platform": _point(platform)}
        R = wirex_parts.rotation(base)
        if (radius := number(base, "radius")) > 0.0:
            radii.add(radius)
            row["exit"] = {"type": Pulley.kind(), "radius": radius, "axis": R[:, 2].tolist()}
        if not np.array_equal(wirex_parts.rotation(platform), np.eye(3)):
            found.left_out.append(f"{platform.at}: orientation of <platform> in <chain>: cables end in points")
        if each.winch is not None and (speed := number(each.winch.child("cable"), "max_velocity")) > 0.0:
            row["speed_max"] = speed
        rows.append(row)
        comments["cables", k] = f"line {each.chain.line}"
    comments["cables",] = "m; base and platform of each chain"
    if radii:
        sizes = ", ".join(f"{radius:g}" for radius in sorted(radii))
        found.warnings.append(
            f"{parts[0].chain.at}: cables leave over pulleys of {sizes} m, radius of <base>, which WireX "
            "leaves out in its standard kinematics; without the keys exit they leave from points"
        )
    found.comments |= comments
    return rows


def _dof(robot: Element, platform: Element, anchors: Any) -> tuple[str, ...]:
    given = attribute(robot, PATTERN) or "3R3T"
    own = attribute(platform, PATTERN)
    if own not in ("", given):
        raise platform.wrong(
            f"motionpattern of the platform is '{own}', and that of the robot '{given}': make them equal"
        )
    if given in PATTERNS:
        return tuple(PATTERNS[given])
    if given not in PLANAR:
        known = ", ".join([*PATTERNS, *PLANAR])
        raise robot.wrong(f"motionpattern: expected one of {known}, got '{given}'")
    frames = anchors[:, :3]
    extents = np.ptp(frames, axis=0)
    flat = np.flatnonzero(extents <= FLAT * extents.max())
    if len(flat) != 1:
        raise robot.wrong(f"motionpattern: '{given}' moves in a plane, and the bases do not lie in one along the axes")
    normal = int(flat[0])
    moves = [name for k, name in enumerate("xyz") if k != normal]
    return (*moves, *([f"r{'xyz'[normal]}"] if PLANAR[given] else []))


def _platform(found: Imported, element: Element, anchors: Any, dof: tuple[str, ...]) -> dict[str, Any]:
    element.touch("id", "name", "description")
    mass = element.attribute_number("mass")
    centre_, tensor = wirex_parts.one_of(element, CENTRE), wirex_parts.one_of(element, TENSOR)
    centre = [0.0, 0.0, 0.0] if centre_ is None else _point(centre_)
    values = (0.0,) * 6 if tensor is None else wirex_parts.tensor(tensor)
    turns = [name for name in dof if name.startswith("r")]
    try:
        inertia, note = filled(values, mass, anchors - centre, turning=bool(turns))
    except ValueError as error:
        raise (tensor or element).wrong(str(error)) from None
    if note:
        found.warnings.append(f"{(tensor or element).at}: {note}")
    if inertia is None and any(values):
        found.left_out.append(f"{(tensor or element).at}: inertia: ignored, because the platform does not rotate")
    found.comments["platform", "mass"] = f"kg, line {element.line}"
    found.comments["platform", "center_of_mass"] = "m, centerofgravity"
    found.comments["platform", "inertia"] = "kg m^2, inertiatensor"
    return {"mass": mass, **({} if inertia is None else {"inertia": list(inertia)}), "center_of_mass": centre}


def _tension(found: Imported, robot: Element, parts: list[Parts], given: tuple[float, float] | None) -> dict[str, Any]:
    """Return the tension limits: of the application, the winches, the cables' breaking loads, or those given."""
    use = robot.find("application")
    if use is not None:
        use.touch("name", "description")
    lows, highs = list[float](), list[float]()
    broken: Parts | None = None
    unlimited = list[Element]()
    for each in parts:
        limits = ((use, "min_cable_load"), (each.cable, "minimum_load"))
        low = next((value for of, key in limits if of is not None and (value := number(of, key)) > 0.0), 0.0)
        winch = None if each.winch is None else each.winch.child("cable")
        loads = [(use, "max_cable_load"), (winch, "f_max"), (each.cable, BREAKS)]
        parsed = [(number(of, key), key, of.line) for of, key in loads if of is not None]
        high, key, line = next((one for one in parsed if one[0] > 0.0), (0.0, "", 0))
        chain = each.chain
        if high == 0.0 and given is not None:
            unlimited.append(chain)
            low, high, key, line = low or given[0], given[1], "given to the import", 0
        if not high > low:
            text = "max_cable_load of <application>, f_max of its winch's <cable> and breaking_load of <cable>"
            raise chain.wrong(
                f"chain '{chain.attributes.get('id', '')}': expected a largest tension above {low:g} N in {text}; add "
                '<application max_cable_load="N"/> to <robot>; or give both limits to the import (--tension MIN,MAX)'
            )
        if key == BREAKS and broken is None:
            broken = each
        lows.append(low)
        highs.append(high)
        found.comments["tension", "max"] = f"N, {key}" + (f", line {line}" if line else "")
    if broken is not None:
        of = f"{min(highs):g} N" if len(set(highs)) == 1 else f"{min(highs):g} to {max(highs):g} N"
        found.warnings.append(
            f"{broken.chain.at}: the largest tension is what the cable breaks at, {of}: winchtype "
            f"'{attribute(broken.chain, wirex_parts.WINCH)}' is not a winch of this file with an f_max"
        )
    if unlimited and given is not None:
        names = ", ".join(f"'{chain.attributes.get('id', '')}'" for chain in unlimited)
        found.warnings.append(
            f"{unlimited[0].at}: the file has no largest tension of chains {names}: {given[1]:g} N is the one given to "
            "the import"
        )
    if min(lows) == 0.0 and not unlimited:
        found.warnings.append(f"{robot.at}: the smallest tension is 0 N, because min_cable_load is missing")
    both = {"min": lows, "max": highs}
    return {key: values[0] if len(set(values)) == 1 else values for key, values in both.items()}


def _point(element: Element) -> list[float]:
    return [element.attribute_number(axis) for axis in "xyz"]
