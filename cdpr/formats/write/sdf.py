"""SDF export: a world for Gazebo with frame, platform and named anchors, or with legs (`cdpr.formats.write.legs`).

In the style `platform`, cables are not modelled. gz-sim's system ApplyLinkWrench applies wrenches that are published as
gz.msgs.EntityWrench on /world/NAME/wrench (once) or /world/NAME/wrench/persistent, so that W t of an external
controller moves the platform. Version 1.6 has neither frames nor systems; there anchors are drawn as small balls.
"""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree import ElementTree as ET

import numpy as np

from cdpr.formats.write import legs
from cdpr.formats.write.export_model import FRAME, PLATFORM, Options, Solid, Subject, bars, colour, drawn, words
from cdpr.formats.write.sdf_parts import PHYSICS, SUN, called, inertial, joint, plugin, pose, text, turning, visual
from cdpr.mechanics.guide import Guide
from cdpr.model.robot import Array

FRAMES_SINCE = "1.9"
BALL = 0.02  # m, of a drawn anchor
TINY = 1e-6  # kg, of a link between two joints of a guide
TINY_MOMENT = 1e-9  # kg m^2

# Default systems of gz-sim; a world that names any system does not load them automatically.
STOCK = {
    "gz-sim-physics-system": "gz::sim::systems::Physics",
    "gz-sim-user-commands-system": "gz::sim::systems::UserCommands",
    "gz-sim-scene-broadcaster-system": "gz::sim::systems::SceneBroadcaster",
}
WRENCH = {"gz-sim-apply-link-wrench-system": "gz::sim::systems::ApplyLinkWrench"}


def write(subject: Subject, options: Options) -> str:
    """Return the world as text.

    Raises:
        FormatError: if the robot does not support legs.
    """
    robot = subject.robot
    name = called(robot.name)
    root = ET.Element("sdf", version=options.version)
    modern = options.version == FRAMES_SINCE
    world = ET.SubElement(root, "world", name=name)
    if modern:
        plugin(world, STOCK if options.style == "legs" else STOCK | WRENCH)
    physics = ET.SubElement(world, "physics", name=PHYSICS, type="ode")
    text(physics, "max_step_size", words([subject.step]))
    text(physics, "real_time_factor", "1")
    text(world, "gravity", words(subject.gravity))
    light = ET.SubElement(world, "light", name=SUN, type="directional")
    text(light, "direction", "-0.5 0.1 -0.9")
    if options.style == "legs":  # joints connect links of the same model
        model = ET.SubElement(world, "model", name=name)
        _frame(model, subject)
        joint(model, "fixed", "fixed", "world", "frame")
        _platform(model, subject, placed=True)
        legs.add(model, subject, modern)
        _points(model, "platform", robot.platform.tools, modern)
    else:
        stand = ET.SubElement(world, "model", name=f"{name}_frame")
        text(stand, "static", "true")
        _frame(stand, subject)
        _points(stand, "frame", {f"{cable.name}_frame": cable.frame for cable in robot.cables}, modern)
        model = ET.SubElement(world, "model", name=name)
        if robot.n == 6:  # PyBullet reads the pose of a model, but not that of its link
            text(model, "pose", _home_pose(subject))
        _platform(model, subject, placed=robot.n < 6)
        _held(model, subject)
        ends = {f"{cable.name}_platform": cable.platform for cable in robot.cables}
        _points(model, "platform", {**ends, **robot.platform.tools}, modern)
    ET.indent(root)
    return '<?xml version="1.0"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def _frame(model: ET.Element, subject: Subject) -> None:
    """Add the frame at the world's origin."""
    robot = subject.robot
    link = ET.SubElement(model, "link", name="frame")
    inertial(link, 1.0, np.zeros(3), np.eye(3))
    for k, bar in enumerate(bars(robot)):
        assert robot.frame is not None
        visual(link, f"bar_{k + 1}", bar, colour(robot.frame.colour, FRAME))


def _home_pose(subject: Subject) -> str:
    return pose(subject.state[:3], subject.state[3:7])


def _platform(model: ET.Element, subject: Subject, placed: bool) -> None:
    """Add the platform's link, with its own pose if `placed`."""
    platform = subject.robot.platform
    link = ET.SubElement(model, "link", name="platform")
    if placed:
        text(link, "pose", _home_pose(subject))
    inertial(link, platform.mass, platform.center_of_mass, platform.inertia)
    visual(link, "platform", drawn(subject.robot), colour(platform.colour, PLATFORM))


def _held(model: ET.Element, subject: Subject) -> None:
    """Add the guide of a platform without all six degrees of freedom: slides along world axes, a hinge, or a ball."""
    robot = subject.robot
    if robot.n == 6:
        return
    guide = Guide(robot)
    if guide.spherical:
        joint(model, "guide", "ball", "world", "platform")
        return
    steps = [("prismatic", axis) for axis in guide.slides]
    if guide.hinge is not None:
        steps.append(("revolute", guide.hinge))
    parent = "world"
    for k, (kind, axis) in enumerate(steps):
        last = k == len(steps) - 1
        child = "platform" if last else f"carriage_{k + 1}"
        if not last:
            link = ET.SubElement(model, "link", name=child)
            text(link, "pose", pose(subject.state[:3]))
            inertial(link, TINY, np.zeros(3), TINY_MOMENT * np.eye(3))
        # The platform rotates only about its hinge, so that the hinge axis equals the world axis.
        turning(joint(model, f"guide_{k + 1}", kind, parent, child), "axis", np.eye(3)[axis])
        parent = child


def _points(model: ET.Element, link: str, places: Mapping[str, Array], modern: bool) -> None:
    """Add named points of a link: as frames, or as drawn balls."""
    owner = next(each for each in model.iter("link") if each.get("name") == link)
    for name, place in places.items():
        there = model if modern else owner
        free = called(name, "tool", [each.get("name") for each in there])  # joints and links have names of their own
        if modern:
            frame = ET.SubElement(model, "frame", {"name": free, "attached_to": link})
            text(frame, "pose", pose(place))
        else:
            visual(owner, free, Solid("sphere", (BALL,), place), colour(None, FRAME))
