"""Parts of WireX files: cable and winch of a chain, material, rotations and tensors."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from cdpr.base.problems import shown
from cdpr.formats.read.imported import Imported
from cdpr.formats.read.xml import Element
from cdpr.model import rotations
from cdpr.model.robot import Array
from cdpr.scenario.robot_schema import Inertia

ROTATION = 1e-5  # tolerance of matrices with six digits, and of the length of quaternions and axes
WINCH, CABLE = ("winchtype", "winch_type"), ("cabletype", "cable_type")
MATRIX = tuple(f"a{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3))
QUATERNION = ("q0", "q1", "q2", "q3")
AXIS = ("ux", "uy", "uz")
ANGLE = "beta"


class Parts(NamedTuple):
    """Chain with its cable and winch, if present."""

    chain: Element
    cable: Element | None
    winch: Element | None


def parts(found: Imported, root: Element, robot: Element, chain: Element) -> Parts:
    """Return the parts of a chain.

    Raises:
        FormatError: if it refers to a cable that does not exist, or chains end on several platforms.
    """
    chain.touch("id")
    wanted = attribute(chain, WINCH)
    winch = next((each for each in root.all("winch") if each.attributes.get("name") == wanted), None)
    if platform := chain.attributes.get("platform_id", ""):
        others = {each.attributes.get("platform_id", "") for each in robot.child("geometry").all("chain")}
        if others != {platform}:
            raise chain.wrong("chains end on several platforms (platform_id): keep those of one")
    return Parts(chain, _cable(found, root, robot, chain), winch)


def _cable(found_: Imported, root: Element, robot: Element, chain: Element) -> Element | None:
    """Return the cable that a chain refers to by `cable_type` or `cable_id`; by default the first cable.

    In files of CDPyR, ids of cables start at 0, and references to them at 1.
    """
    cables = root.all("cable")
    named, number_ = attribute(chain, CABLE), chain.attributes.get("cable_id", "").strip()
    if named:
        found = [each for each in cables if each.attributes.get("name", "").strip() == named]
    elif number_:
        of = {each.attributes.get("cable_id", "").strip() for each in robot.child("geometry").all("chain")}
        ids = {each.attributes.get("id", "").strip() for each in cables}
        if of - {""} <= ids:
            found = [each for each in cables if each.attributes.get("id", "").strip() == number_]
        elif number_.isdecimal() and {str(int(each) - 1) for each in of if each.isdecimal()} <= ids:
            found = [each for each in cables if each.attributes.get("id", "").strip() == str(int(number_) - 1)]
        else:
            found = []
    else:
        if len(cables) > 1 and not any(cables[0].at in text for text in found_.warnings):
            found_.warnings.append(f"{cables[0].at}: chains name no cable (cable_type): all are the first <cable>")
        return cables[0] if cables else None
    if not found and len(cables) <= 1 and not named:
        return cables[0] if cables else None
    what = f"cable_type '{named}'" if named else f"cable_id '{number_}'"
    there = ", ".join(
        f"'{each.attributes.get('name', '')}' (id {each.attributes.get('id', 'not given')})" for each in cables
    )
    if not found:
        raise chain.wrong(f"{what}: no such <cable>; allowed: {there or 'none'}")
    if any(dict(each.attributes) != dict(found[0].attributes) for each in found[1:]):
        raise found[1].wrong(f"{what}: several <cable>s match, and they differ: give each a unique name and id")
    for each in found:
        each.touch(*found[0].attributes)
    return found[0]


def material(found: Imported, every: list[Parts]) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """Return common properties of all cables, and individual properties of each."""
    if every and len({id(each.cable) for each in every}) == 1:
        cable = every[0].cable
        data = {} if cable is None else _cable_data(cable)
        if cable is not None:
            for key, what in {"diameter": "m, twice radius", "linear_density": "kg/m, weight"}.items():
                found.comments["cable", key] = f"{what}, line {cable.line}"
            found.comments["cable", "axial_stiffness"] = f"N, elasticity times pi radius^2, line {cable.line}"
            found.comments["cable", "length"] = f"m, min_length and max_length, line {cable.line}"
        length = data.pop("length", None)
        return data, [{} if length is None else {"length": dict(length)} for _ in every]
    rows = [{} if each.cable is None else _cable_data(each.cable) for each in every]
    for k, each in enumerate(every):
        if each.cable is not None:
            found.comments["cables", k] += f"; cable '{each.cable.attributes.get('name', '')}', line {each.cable.line}"
    return {}, rows


def _cable_data(cable: Element) -> dict[str, Any]:
    data = dict[str, Any]()
    radius, modulus, weight = (number(cable, key) for key in ("radius", "elasticity", "weight"))
    if radius > 0.0:
        data["diameter"] = 2.0 * radius
        if modulus > 0.0:
            data["axial_stiffness"] = modulus * math.pi * radius**2
    if weight > 0.0:
        data["linear_density"] = weight
    low, high = number(cable, "min_length"), number(cable, "max_length")
    if low > high > 0.0:
        raise cable.wrong(f"min_length, {low:g} m, is above max_length, {high:g} m")
    if low > 0.0 or high > 0.0:
        data["length"] = {**({"min": low} if low > 0.0 else {}), **({"max": high} if high > 0.0 else {})}
    return data


def rotation(element: Element) -> Array:
    """Return the rotation (3, 3) of a base: a matrix, a quaternion (w first), or an axis and angle.

    Raises:
        FormatError: if it is invalid, or several differ.
    """
    found = list[Array]()
    given = element.attributes
    if any(key in given for key in MATRIX):
        identity = np.eye(3)
        values = [element.attribute_number(key, identity.flat[k]) for k, key in enumerate(MATRIX)]
        R = np.array(values).reshape(3, 3)
        if not np.allclose(R @ R.T, identity, atol=ROTATION) or np.linalg.det(R) < 0.0:
            raise element.wrong("a11 to a33 do not form a rotation matrix")
        found.append(R)
    if any(key in given for key in QUATERNION):
        q = np.array([element.attribute_number(key, 0.0) for key in QUATERNION])
        length = float(np.linalg.norm(q))
        if abs(length - 1.0) > ROTATION:
            raise element.wrong(f"expected a quaternion of norm 1 (q0 to q3), got norm {length:g}")
        found.append(rotations.matrix(q / length))
    if any(key in given for key in (*AXIS, ANGLE)):
        axis, angle = np.array([element.attribute_number(key, 0.0) for key in AXIS]), number(element, ANGLE)
        length = float(np.linalg.norm(axis))
        if angle != 0.0 and length < ROTATION:
            raise element.wrong(f"ux, uy, uz: expected an axis for the angle beta, {angle:g} rad, got zeros")
        found.append(rotations.matrix(rotations.from_axis_angle(axis / length, angle)) if angle else np.eye(3))
    if any(not np.allclose(R, found[0], atol=ROTATION) for R in found[1:]):
        raise element.wrong("it has two orientations that differ: keep a11 to a33, q0 to q3, or ux, uy, uz and beta")
    return found[0] if found else np.eye(3)


def tensor(element: Element) -> Inertia:
    """Return ixx, iyy, izz, ixy, ixz, iyz.

    Raises:
        FormatError: if a matrix is not symmetric.
    """
    for first, second in (("Ixy", "Iyx"), ("Ixz", "Izx"), ("Iyz", "Izy")):
        if first in element.attributes and second in element.attributes:
            a, b = number(element, first), number(element, second)
            if a != b:
                raise element.wrong(f"{first}, {a:g}, and {second}, {b:g}, differ: an inertia tensor is symmetric")
    xx, yy, zz = (number(element, key) for key in ("Ixx", "Iyy", "Izz"))
    xy, xz, yz = (
        number(element, first if first in element.attributes else second)
        for first, second in (("Ixy", "Iyx"), ("Ixz", "Izx"), ("Iyz", "Izy"))
    )
    return (xx, yy, zz, xy, xz, yz)


def number(element: Element, name: str) -> float:
    """Return a numeric attribute; 0 if it is missing or infinite, that is, not given.

    Raises:
        FormatError: if it is not a number.
    """
    given = element.attributes.get(name, "").strip().lower().lstrip("+")
    return 0.0 if given in ("inf", "infinity") else element.attribute_number(name, 0.0)


def attribute(element: Element, names: tuple[str, ...]) -> str:
    """Return an attribute with alternative names; "" if it is missing.

    Raises:
        FormatError: if several differ.
    """
    given = {name: element.attributes.get(name, "").strip() for name in names if name in element.attributes}
    if len(set(given.values())) > 1:
        both = " and ".join(f"{name}={shown(value)}" for name, value in given.items())
        raise element.wrong(f"<{element.name}> has {both}: keep one")
    return str(next(iter(given.values()), ""))


def one_of(element: Element, names: tuple[str, ...]) -> Element | None:
    """Return the child with one of these names, or None.

    Raises:
        FormatError: if there are several.
    """
    found = [child for name in names for child in element.all(name)]
    if len(found) > 1:
        raise element.wrong(f"<{element.name}> has <{'>, <'.join(each.name for each in found)}>: keep one")
    return found[0] if found else None
