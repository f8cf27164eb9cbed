"""SDF elements shared by the export styles."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from xml.etree import ElementTree as ET

import numpy as np

from cdpr.formats.write.export_model import Solid, words
from cdpr.model import rotations
from cdpr.model.robot import Array

SUN, PHYSICS = "sun", "physics"
RESERVED = ("world", SUN, PHYSICS)  # by SDF, and for the light and the physics
UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])


def text(parent: ET.Element, name: str, content: str) -> ET.Element:
    """Add an element that contains text."""
    element = ET.SubElement(parent, name)
    element.text = content
    return element


def called(name: str, kind: str = "robot", taken: Collection[str | None] = RESERVED) -> str:
    """Return a name that is neither taken nor reserved by SDF, as __names like this__ are."""
    while name in taken or (name.startswith("__") and name.endswith("__")):
        name = f"{kind}_{name}"
    return name


def pose(place: Array, attitude: Array = UPRIGHT) -> str:
    """Return a pose as SDF text: position, m, and roll, pitch, yaw, rad."""
    return words([*place, *rotations.to_euler(attitude, "xyz")])


def inertial(link: ET.Element, mass: float, centre: Array, inertia: Array) -> None:
    """Add the inertia (3, 3) about the centre of mass, kg m^2, in link axes."""
    element = ET.SubElement(link, "inertial")
    text(element, "pose", pose(centre))
    text(element, "mass", words([mass]))
    parts = ET.SubElement(element, "inertia")
    for i in range(3):
        for j in range(i, 3):
            text(parts, f"i{'xyz'[i]}{'xyz'[j]}", words([inertia[i, j]]))


def visual(link: ET.Element, name: str, solid: Solid, rgba: list[float]) -> None:
    """Add a visual shape."""
    element = ET.SubElement(link, "visual", name=name)
    text(element, "pose", pose(solid.position, solid.attitude))
    shape = ET.SubElement(ET.SubElement(element, "geometry"), solid.kind)
    if solid.kind == "box":
        text(shape, "size", words(solid.size))
    else:
        text(shape, "radius", words(solid.size[:1]))
    if solid.kind == "cylinder":
        text(shape, "length", words(solid.size[-1:]))
    material = ET.SubElement(element, "material")
    text(material, "ambient", words(rgba))
    text(material, "diffuse", words(rgba))


def plugin(parent: ET.Element, system: Mapping[str, str], **keys: str) -> None:
    """Add gz-sim systems by file and name, with their parameters."""
    for file, name in system.items():
        element = ET.SubElement(parent, "plugin", filename=file, name=name)
        for key, value in keys.items():
            text(element, key, value)


def joint(model: ET.Element, name: str, kind: str, parent: str, child: str) -> ET.Element:
    """Add a joint between two links."""
    element = ET.SubElement(model, "joint", name=name, type=kind)
    text(element, "parent", parent)
    text(element, "child", child)
    return element


def turning(element: ET.Element, name: str, direction: Array, lower: float = -1e16, upper: float = 1e16) -> ET.Element:
    """Add an axis (3,) of a joint, in child axes, and return its limits."""
    axis = ET.SubElement(element, name)
    text(axis, "xyz", words(direction))
    limit = ET.SubElement(axis, "limit")
    text(limit, "lower", words([lower]))
    text(limit, "upper", words([upper]))
    return limit
