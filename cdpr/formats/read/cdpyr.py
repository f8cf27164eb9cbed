"""Reader of robots of CDPyR (cable-robots/cdpyr) in JSON, YAML and XML.

A robot has a frame and platforms with anchors, cables, and kinematic chains that refer to them by index. Infinite
numbers are missing ones. The pulley of an anchor swivels about the z axis of the anchor, the third column of its
`dcm`. The axial stiffness is the first elasticity (Pa) times the cross-section.
"""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np

from cdpr.base.problems import dotted
from cdpr.cables.pulley import Pulley
from cdpr.formats.read.import_options import Choice
from cdpr.formats.read.imported import Imported, slug, unique
from cdpr.formats.read.inertia import filled, six
from cdpr.formats.read.plain_documents import is_missing, items_of, plain_document
from cdpr.formats.read.wirex_parts import ROTATION
from cdpr.formats.read.xml import root_of
from cdpr.formats.read.yaml_reader import Node
from cdpr.model import rotations
from cdpr.scenario.robot_schema import Inertia

KEYS = (b"frame", b"platforms", b"kinematic_chains")
# Free directions by the numbers of translations and rotations: CDPyR's planar robots move in the plane xy.
PATTERNS = {
    (1, 0): ("x",),
    (2, 0): ("x", "y"),
    (3, 0): ("x", "y", "z"),
    (2, 1): ("x", "y", "rz"),
    (3, 3): ("x", "y", "z", "rx", "ry", "rz"),
}
EARTH = (0.0, 0.0, -9.81)


def recognise(content: bytes) -> bool:
    """Return True if the content has the parts of a robot."""
    if content.lstrip()[:1] == b"<":
        return root_of(content)[0] == "robot" and b"<kinematic_chains>" in content
    return all(re.search(rb"(?m)(?:^|[{,]\s*|^\s+)\"?" + key + rb"\"?\s*:", content) is not None for key in KEYS)


def is_main_file(path: Path, content: bytes) -> bool:
    """Return True if a robot is read from this file."""
    return True


def read(path: Path, content: bytes, choice: Choice) -> Imported:
    """Read a robot.

    Raises:
        CdprError: if the file is invalid or not representable.
    """
    top = plain_document(content, str(path))
    given = (top / "name").value
    name = slug(given if isinstance(given, str) else "", slug(path.stem, "robot"))
    found = Imported(name, f"CDPyR: {path.name}", {"name": name}, [top])
    platforms = items_of(top / "platforms")
    if len(platforms) != 1:
        raise (top / "platforms").wrong(f"expected one platform, got {len(platforms)}: keep one, and its chains")
    platform = platforms[0]
    chains = items_of(top / "kinematic_chains")
    rows = [_row(found, top, platform, chain) for chain in chains]
    for k, (row, own) in enumerate(zip(rows, unique([f"cable_{k + 1}" for k in range(len(rows))]), strict=True)):
        rows[k] = {"name": own, **row}
    found.comments |= {("cables", k): f"line {chain.line}" for k, chain in enumerate(chains)}
    found.comments["cables",] = "m; anchors of the frame and the platform, by kinematic_chains"
    limits = [_largest(top, chain) for chain in chains]
    found.robot["dof"] = list(_dof(platform))
    found.comments["dof",] = (platform / "motion_pattern").at
    found.robot["platform"] = _body(found, platform, np.array([row["platform"] for row in rows]))
    found.robot["tension"] = _tension(found, chains, limits, choice.tension)
    found.robot["home"] = _home(platform)
    found.robot["cables"] = rows
    gravity = top / "gravity"
    if not is_missing(gravity.value) and gravity.value not in ([*EARTH], -9.81, 9.81):
        found.left_out.append(f"{path}:{gravity.line}: gravity {gravity.value}: set world.gravity in scenarios")
        gravity.done()
    return found


def _index(chain: Node, key: str, of: list[Node], default: int | None = None) -> Node:
    value = (chain / key).value
    value = default if value is None else value
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value < len(of):
        raise (chain / key).wrong(f"expected an index from 0 to {len(of) - 1}, got {value}")
    return of[value]


def _row(found: Imported, top: Node, platform: Node, chain: Node) -> dict[str, Any]:
    """Return a cable in the format of a robot file, without its name."""
    _index(chain, "platform", [platform], 0)
    anchor = _index(chain, "frame_anchor", items_of(top / "frame" / "anchors"))
    row: dict[str, Any] = {
        "frame": _point(anchor),
        "platform": _end(found, _index(chain, "platform_anchor", items_of(platform / "anchors"))),
    }
    radius = _size(anchor / "pulley" / "radius")
    if radius is not None and radius > 0.0:
        axis = _rotation(anchor)[:, 2]
        row["exit"] = {"type": Pulley.kind(), "radius": radius, "axis": axis.tolist()}
    cable = _index(chain, "cable", items_of(top / "cables"))
    diameter = _size(cable / "diameter")
    if diameter is not None and diameter > 0.0:
        row["diameter"] = diameter
        modules = cable / "modulus" / "elasticities"
        elasticity = None if is_missing(modules.value) else _size(items_of(modules)[0])
        if elasticity is not None and elasticity > 0.0:
            row["axial_stiffness"] = elasticity * math.pi * diameter**2 / 4.0
    return row


def _point(anchor: Node) -> list[float]:
    """Return the position of an anchor; older versions have it one level deeper."""
    return _place(anchor).vector(3)


def _end(found: Imported, anchor: Node) -> list[float]:
    """Return the position of an anchor of the platform; its origin, with a warning, if it has none."""
    if not is_missing(_place(anchor).value):
        return _point(anchor)
    place = f"{anchor.document.source}:{anchor.line}"
    text = (
        f"{place}: assumed, because the file does not define it: {dotted(anchor.path)}.position, the platform's origin"
    )
    if text not in found.warnings:
        found.warnings.append(text)
    return [0.0, 0.0, 0.0]


def _place(anchor: Node) -> Node:
    place = anchor / "position"
    return place / "position" if isinstance(place.value, dict) else place


def _rotation(node: Node) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return the rotation matrix `dcm` of a node, the identity if it has none.

    Raises:
        FormatError: if it is not one.
    """
    dcm = node / "dcm"
    if isinstance(dcm.value, dict):
        dcm = dcm / "dcm"
    if is_missing(dcm.value):
        return np.eye(3)
    rows = dcm.items()
    matrix = np.array([row.vector(3) for row in rows]) if len(rows) == 3 else np.zeros((3, 3))
    if np.abs(matrix @ matrix.T - np.eye(3)).max() > ROTATION or np.linalg.det(matrix) < 0.0:
        raise dcm.wrong("expected a rotation matrix, three rows of three numbers")
    return matrix


def _number(node: Node) -> float | None:
    return None if is_missing(node.value) else node.number()


def _size(node: Node) -> float | None:
    """Return a number of at least 0; None if it is missing."""
    found = _number(node)
    if found is not None and found < 0.0:
        raise node.wrong(f"expected at least 0, got {found:g}")
    return found


def _largest(top: Node, chain: Node) -> float | None:
    return _size(_index(chain, "cable", items_of(top / "cables")) / "breaking_load")


def _tension(
    found: Imported, chains: list[Node], breaking: list[float | None], given: tuple[float, float] | None
) -> dict[str, Any]:
    """Return the tension limits: those given, or 0 and the breaking loads."""
    if given is not None:
        found.comments["tension",] = "N, given to the import"
        return {"min": given[0], "max": given[1]}
    highest = [each for each in breaking if each is not None and each > 0.0]
    if len(highest) < len(breaking):
        chain = next(chain for chain, each in zip(chains, breaking, strict=True) if each is None or each <= 0.0)
        raise chain.wrong(
            "its cable has no breaking_load, and the file has no other limit of its tension: give the limits to the "
            "import (--tension MIN,MAX)"
        )
    found.comments["tension", "max"] = "N, breaking_load"
    found.warnings.append(
        f"{chains[0].document.source}:{chains[0].line}: the largest tension is the breaking load of the cable, the "
        "smallest is 0 N: --tension MIN,MAX sets others"
    )
    return {"min": 0.0, "max": highest[0] if len(set(highest)) == 1 else highest}


def _dof(platform: Node) -> tuple[str, ...]:
    """Return the free directions.

    Raises:
        FormatError: if no guide of ours allows them.
    """
    pattern = next((platform / key for key in ("motion_pattern", "motionpattern") if key in platform), None)
    if pattern is None:
        return PATTERNS[3, 3]
    if isinstance(pattern.value, str):
        counts = re.fullmatch(r"(?:([123])R)?([123])T", pattern.value.strip().upper())
        numbers = (int(counts[2]), int(counts[1] or 0)) if counts is not None else (0, 0)
    else:
        moves, turns = ((_number(pattern / key) or 0.0) for key in ("translation", "rotation"))
        if not (moves.is_integer() and turns.is_integer()):
            raise pattern.wrong(f"expected whole numbers of translations and rotations, got {moves:g} and {turns:g}")
        numbers = (int(moves), int(turns))
    if numbers not in PATTERNS:
        allowed = ", ".join(f"{turns}R{moves}T" if turns else f"{moves}T" for moves, turns in PATTERNS)
        raise pattern.wrong(f"expected one of {allowed}, got {numbers[1]}R{numbers[0]}T: change it in the file")
    return PATTERNS[numbers]


def _body(found: Imported, platform: Node, anchors: Any) -> dict[str, Any]:
    """Return the section of the platform."""
    linear, angular = platform / "inertia" / "linear", platform / "inertia" / "angular"
    mass = _diagonal(linear)
    if mass is None:
        raise (platform / "inertia").wrong("expected the mass of the platform, in `linear`: add it to the file")
    if mass <= 0.0:
        raise linear.wrong(f"expected a mass of more than 0 kg, got {mass:g}")
    body: dict[str, Any] = {"mass": mass}
    found.comments["platform", "mass"] = f"kg, {linear.at}"
    tensor: Inertia = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    if not is_missing(angular.value) and len(angular.items()) == 3:
        rows = [row.value for row in angular.items()]
        if not any(is_missing(value) for row in rows if isinstance(row, list) for value in row):
            tensor = six(np.array([row.vector(3) for row in angular.items()]))
    centre = platform / "center_of_gravity"
    place = [0.0, 0.0, 0.0] if is_missing(centre.value) else centre.vector(3)
    turning = any(name.startswith("r") for name in found.robot["dof"])
    try:
        whole, note = filled(tensor, mass, anchors - np.array(place), turning)
    except ValueError as error:
        raise angular.wrong(str(error)) from None
    if note:
        found.warnings.append(f"{platform.document.source}:{platform.line}: {note}")
    if whole is not None:
        body["inertia"] = list(whole)
        found.comments["platform", "inertia"] = f"kg m^2, {angular.at}"
    if any(place):
        body["center_of_mass"] = place
    return body


def _diagonal(linear: Node) -> float | None:
    """Return the mass of a matrix with equal masses on its diagonal, or of a list or number; None without one.

    Raises:
        FormatError: if the masses differ, or the matrix is not diagonal.
    """
    if is_missing(linear.value):
        return None
    rows = items_of(linear)
    values = [[_number(cell) for cell in items_of(row)] for row in rows]
    if isinstance(rows[0].value, list):
        masses = [row[i] if i < len(row) else None for i, row in enumerate(values)]
        others = [value for i, row in enumerate(values) for k, value in enumerate(row) if k != i]
    else:
        masses, others = [row[0] for row in values], []
    if len(masses) > 3 or any(mass != masses[0] for mass in masses) or any(others):
        raise linear.wrong("expected a diagonal matrix with equal masses, kg: cdpr has one mass in all directions")
    return masses[0]


def _home(platform: Node) -> dict[str, Any]:
    pose = platform / "pose"
    place = pose / "linear" / "position"
    home: dict[str, Any] = {"position": [0.0, 0.0, 0.0] if is_missing(place.value) else place.vector(3)}
    matrix = _rotation(pose / "angular")
    if not np.array_equal(matrix, np.eye(3)):
        home["orientation"] = {"quaternion": [float(part) for part in rotations.from_matrix(matrix)]}
    return home
