"""URDF export of frame and platform with a link at each anchor and tool, for RViz and TF.

URDF supports neither cables nor closed loops. The platform is connected by a floating joint, whose transform must be
published. Each link has an inertia, because readers assign 1 kg to links without one: a millionth of a gram for
anchors, and an arbitrary one for the immobile frame.
"""

from __future__ import annotations

from xml.etree import ElementTree as ET

import numpy as np

from cdpr.formats.write.export_model import FRAME, PLATFORM, Options, Solid, Subject, bars, colour, drawn, words
from cdpr.model import rotations
from cdpr.model.robot import Array

TINY = 1e-9  # kg, of an anchor
TINY_MOMENT = 1e-12  # kg m^2
RADIUS = 0.02  # m, of the drawn ball at an anchor


def write(subject: Subject, options: Options) -> str:
    """Return the robot description."""
    robot = subject.robot
    platform = robot.platform
    root = ET.Element("robot", name=robot.name)
    for part, given in ({"frame": FRAME, "platform": PLATFORM} | robot.colours).items():
        ET.SubElement(ET.SubElement(root, "material", name=part), "color", rgba=words(colour(given, FRAME)))
    frame = _link(root, "frame", 1.0, np.zeros(3), np.eye(3))
    for bar in bars(robot):
        _visual(frame, bar, "frame")
    link = _link(root, "platform", platform.mass, platform.center_of_mass, platform.inertia)
    _visual(link, drawn(robot), "platform")
    joint = ET.SubElement(root, "joint", name="platform", type="floating")
    _joined(joint, "frame", "platform", subject.state[:3], subject.state[3:7])
    for cable in robot.cables:
        for parent, place in (("frame", cable.frame), ("platform", cable.platform)):
            _point(root, f"{cable.name}_{parent}", parent, place)
    for name, place in platform.tools.items():
        _point(root, name, "platform", place)
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def _point(root: ET.Element, name: str, parent: str, place: Array) -> None:
    """Add a link at a named point of another link."""
    _visual(_link(root, name, TINY, np.zeros(3), TINY_MOMENT * np.eye(3)), Solid("sphere", (RADIUS,)), parent)
    fixed = ET.SubElement(root, "joint", name=name, type="fixed")
    _joined(fixed, parent, name, place, np.array([1.0, 0.0, 0.0, 0.0]))


def _link(root: ET.Element, name: str, mass: float, centre: Array, inertia: Array) -> ET.Element:
    link = ET.SubElement(root, "link", name=name)
    inertial = ET.SubElement(link, "inertial")
    ET.SubElement(inertial, "origin", xyz=words(centre), rpy="0 0 0")
    ET.SubElement(inertial, "mass", value=words([mass]))
    parts = {f"i{'xyz'[i]}{'xyz'[j]}": words([inertia[i, j]]) for i in range(3) for j in range(i, 3)}
    ET.SubElement(inertial, "inertia", parts)
    return link


def _visual(link: ET.Element, solid: Solid, material: str) -> None:
    visual = ET.SubElement(link, "visual")
    ET.SubElement(visual, "origin", xyz=words(solid.position), rpy=words(rotations.to_euler(solid.attitude, "xyz")))
    shape = {"box": {"size": words(solid.size)}, "sphere": {"radius": words(solid.size[:1])}}
    shape["cylinder"] = {"radius": words(solid.size[:1]), "length": words(solid.size[-1:])}
    ET.SubElement(ET.SubElement(visual, "geometry"), solid.kind, shape[solid.kind])
    ET.SubElement(visual, "material", name=material)


def _joined(joint: ET.Element, parent: str, child: str, place: Array, attitude: Array) -> None:
    ET.SubElement(joint, "parent", link=parent)
    ET.SubElement(joint, "child", link=child)
    ET.SubElement(joint, "origin", xyz=words(place), rpy=words(rotations.to_euler(attitude, "xyz")))
