"""MJCF export: a body on spatial tendons with one actuator each, and sensors of tension, length and pose.

The body frame is that of the mujoco backend: for a free platform at the centre of mass along the principal axes, so
that replayed tensions reproduce that backend's motion to round-off. The site `platform` has the platform's own origin
and axes. A tendon force is positive when it pushes; the gear of -1 makes an actuator's control the cable tension, N,
which its sensor also measures.
"""

from __future__ import annotations

from xml.etree import ElementTree as ET

import numpy as np

from cdpr.base.errors import FormatError
from cdpr.base.fields import MAX_MAGNITUDE
from cdpr.formats.write.export_model import (
    FRAME,
    PLATFORM,
    Options,
    Solid,
    Subject,
    bars,
    colour,
    drawn,
    only_ideal,
    words,
)
from cdpr.mechanics.body_frame import BodyFrame, body_state
from cdpr.model import rotations
from cdpr.model.robot import Array

# MuJoCo's compiler rejects moments that violate the triangle inequality by round-off.
ROUNDING = 1e-12
LEAST = 1e-15  # kg, kg m^2: mjMINVAL, the lower bound of MuJoCo for moving bodies


def write(subject: Subject, options: Options) -> str:
    """Return the model as text.

    Raises:
        FormatError: for winches, elastic cables and pulleys, and for too small masses.
    """
    robot = subject.robot
    only_ideal(robot, "MJCF")
    frame = BodyFrame(robot)
    if (least := min(frame.mass, *frame.moments)) <= LEAST:
        raise FormatError(
            f"robot '{robot.name}': MuJoCo requires masses and moments of inertia above {LEAST:g} (kg, kg m^2); the "
            f"smallest of the platform is {least:.6g}"
        )
    root = ET.Element("mujoco", model=robot.name)
    ET.SubElement(root, "compiler", angle="radian")
    option = ET.SubElement(root, "option", timestep=words([subject.step]), gravity=words(subject.gravity))
    ET.SubElement(option, "flag", contact="disable")
    world = ET.SubElement(root, "worldbody")
    for k, bar in enumerate(bars(robot)):
        assert robot.frame is not None
        _geom(world, f"bar_{k + 1}", bar, colour(robot.frame.colour, FRAME))
    for cable in robot.cables:
        ET.SubElement(world, "site", name=f"{cable.name}_frame", pos=words(cable.frame), size="0.02")
    _platform(world, subject, frame)
    tendons, actuators, sensors = (ET.SubElement(root, name) for name in ("tendon", "actuator", "sensor"))
    for cable in robot.cables:
        spatial = ET.SubElement(tendons, "spatial", name=cable.name)
        if cable.diameter is not None:
            spatial.set("width", words([cable.diameter / 2]))
        if cable.length_max is not None:  # informative: cdpr does not enforce lengths either
            spatial.set("limited", "false")
            spatial.set("range", words([cable.length_min or 0.0, cable.length_max]))
        for end in ("frame", "platform"):
            ET.SubElement(spatial, "site", site=f"{cable.name}_{end}")
        low, high = cable.tension_min, min(cable.tension_max, MAX_MAGNITUDE)
        limits = words([low, high if high > low else np.nextafter(high, np.inf)])  # MuJoCo rejects empty ranges
        actuator = {"name": cable.name, "tendon": cable.name, "gear": "-1", "ctrllimited": "true", "ctrlrange": limits}
        ET.SubElement(actuators, "motor", actuator)
        ET.SubElement(sensors, "actuatorfrc", name=f"{cable.name}_tension", actuator=cable.name)
        ET.SubElement(sensors, "tendonpos", name=f"{cable.name}_length", tendon=cable.name)
    for kind, name in (("framepos", "position"), ("framequat", "attitude")):
        ET.SubElement(sensors, kind, name=f"platform_{name}", objtype="site", objname="platform")
    _key(root, subject, frame)
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def _platform(world: ET.Element, subject: Subject, frame: BodyFrame) -> None:
    """Add the body with its joints and inertia, and its sites and shape in the platform's own axes."""
    robot = subject.robot
    at = _body(subject, frame)
    place = at[:3] if frame.guide is None else at[:3] * (1.0 - frame.guide.packed[:3])
    attitude = {"quat": words(at[3:7])} if frame.guide is None else {}
    body = ET.SubElement(world, "body", {"name": "platform", "pos": words(place), **attitude})
    if frame.guide is None:
        ET.SubElement(body, "freejoint", name="platform")
    elif frame.guide.spherical:
        ET.SubElement(body, "joint", name="platform", type="ball")
    else:
        for axis in frame.guide.slides:
            ET.SubElement(body, "joint", name="xyz"[axis], type="slide", axis=words(np.eye(3)[axis]))
        if (hinge := frame.guide.hinge) is not None:
            ET.SubElement(body, "joint", name=f"r{'xyz'[hinge]}", type="hinge", axis=words(np.eye(3)[hinge]))
    moments = np.minimum(frame.moments, (frame.moments.sum() - frame.moments) * (1.0 - ROUNDING))
    mass = {"mass": words([frame.mass]), "diaginertia": words(moments)}
    ET.SubElement(body, "inertial", {"pos": words(frame.center), "quat": words(frame.axes), **mass})
    origin, turned = -frame.offset[:3], rotations.conjugate(frame.offset[3:])
    ET.SubElement(body, "site", name="platform", pos=words(origin), quat=words(turned), size="0.02")
    solid = drawn(robot)
    place = origin + rotations.matrix(turned) @ solid.position
    shape = Solid(solid.kind, solid.size, place, rotations.multiply(turned, solid.attitude))
    _geom(body, "shape", shape, colour(robot.platform.colour, PLATFORM))
    for cable, row in zip(robot.cables, frame.anchors, strict=True):
        ET.SubElement(body, "site", name=f"{cable.name}_platform", pos=words(row[3:]), size="0.02")
    for name, tool in robot.platform.tools.items():
        place = origin + rotations.matrix(turned) @ tool
        ET.SubElement(body, "site", name=name, pos=words(place), quat=words(turned), size="0.02")


def _geom(parent: ET.Element, name: str, solid: Solid, rgba: list[float]) -> None:
    """Add a shape without collisions and mass."""
    size = solid.size
    if solid.kind == "box":
        size = tuple(side / 2 for side in size)
    elif solid.kind == "cylinder":
        size = (size[0], size[1] / 2)
    place = {"pos": words(solid.position), "quat": words(solid.attitude)}
    drawn_only = {"contype": "0", "conaffinity": "0", "mass": "0", "rgba": words(rgba)}
    ET.SubElement(parent, "geom", {"name": name, "type": solid.kind, "size": words(size), **place, **drawn_only})


def _key(root: ET.Element, subject: Subject, frame: BodyFrame) -> None:
    """Add the initial state as a keyframe."""
    at = _body(subject, frame)
    if frame.guide is None:
        q = at[:7]
        spin = rotations.matrix(at[3:7]).T @ at[10:]  # MuJoCo's angular velocity of a free joint is in body axes
        rates = np.concatenate([at[7:10], spin])
    elif frame.guide.spherical:
        q, rates = at[3:7], rotations.matrix(at[3:7]).T @ at[10:]
    else:
        q, rates = frame.guide.coordinates(at, at[:3] * (1.0 - frame.guide.packed[:3]))
    low = words([cable.tension_min for cable in subject.robot.cables])
    ET.SubElement(ET.SubElement(root, "keyframe"), "key", name="start", qpos=words(q), qvel=words(rates), ctrl=low)


def _body(subject: Subject, frame: BodyFrame) -> Array:
    """Return the state (13,) of the body frame."""
    return body_state(frame.offset, subject.state)
