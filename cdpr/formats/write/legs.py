"""Cables as legs in SDF: a universal joint, a slide and a ball joint each, as the thesis's generator writes them.

Its errors are corrected. Axes are those of the leg, not of the world. Legs end at the anchors even if the platform is
rotated. Slides allow lengths from zero to twice the frame's diagonal. Each link has a valid inertia, and masses from
the file are not replaced.

Legs form closed loops. Gazebo classic (ODE) supports them. gz-sim's engines do not support them in SDF, but its system
DetachableJoint welds two links at start, in each engine (gz-physics: `AttachFixedJoint`). Therefore each leg ends in a
separate foot that is welded to the platform, and released when the cable breaks.
"""

from __future__ import annotations

from xml.etree import ElementTree as ET

import numpy as np

from cdpr.base.errors import FormatError
from cdpr.base.fields import MAX_MAGNITUDE
from cdpr.formats.write import sdf_parts as sdf
from cdpr.formats.write.export_model import Solid, Subject, colour, only_ideal, words
from cdpr.mechanics.properties import check_lengths
from cdpr.model import Cable, rotations
from cdpr.model.robot import Array

MASS = 0.01  # kg, of each half of a leg
RADIUS = 0.005  # m, default radius
CABLE = "#202020"
FORCE = {"gz-sim-apply-joint-force-system": "gz::sim::systems::ApplyJointForce"}
WELD = {"gz-sim-detachable-joint-system": "gz::sim::systems::DetachableJoint"}
FOOT = 0.02  # m, radius of a foot


def add(model: ET.Element, subject: Subject, modern: bool) -> None:
    """Add the legs of all cables.

    Raises:
        FormatError: for guided platforms, pulleys, winches and elastic cables.
        CdprError: if a cable has zero length.
    """
    robot = subject.robot
    if robot.n < 6:
        raise FormatError(
            f"style: legs are for platforms that are free in all six directions; robot '{robot.name}' is not: "
            "choose style platform"
        )
    only_ideal(robot, "a leg")
    check_lengths(robot, subject.state[:7])
    R, p = rotations.matrix(subject.state[3:7]), subject.state[:3]
    across = float(np.linalg.norm(np.ptp(robot.anchors[:, :3], axis=0)))
    for cable in robot.cables:
        end = p + R @ cable.platform
        upper = _leg(model, cable, (cable.frame, end), 2.0 * across)
        ball = f"{cable.name}_ball"
        if modern:
            foot = _foot(model, cable, sdf.pose(end, subject.state[3:7]))
            sdf.joint(model, ball, "ball", upper, foot)
            sdf.plugin(model, FORCE, joint_name=f"{cable.name}_slide")
            weld = {"parent_link": foot, "child_model": "__model__", "child_link": "platform"}
            sdf.plugin(model, WELD, **weld, detach_topic=f"/model/{model.get('name')}/{cable.name}/detach")
        else:
            sdf.text(sdf.joint(model, ball, "ball", upper, "platform"), "pose", sdf.pose(cable.platform))


def _foot(model: ET.Element, cable: Cable, stands: str) -> str:
    """Add a leg's foot at the platform, a ball with the platform's attitude; return its name."""
    link = ET.SubElement(model, "link", name=f"{cable.name}_foot")
    sdf.text(link, "pose", stands)
    sdf.inertial(link, MASS, np.zeros(3), 0.4 * MASS * FOOT**2 * np.eye(3))
    sdf.visual(link, "foot", Solid("sphere", (FOOT,), np.zeros(3)), colour(None, CABLE))
    return f"{cable.name}_foot"


def _leg(model: ET.Element, cable: Cable, ends: tuple[Array, Array], longest: float) -> str:
    """Add a leg along z of its links, from frame anchor to platform anchor (`ends`, world frame).

    Returns:
        Name of the link at the platform end.
    """
    name, radius = cable.name, RADIUS if cable.diameter is None else cable.diameter / 2
    way = ends[1] - ends[0]
    length = float(np.linalg.norm(way))
    attitude = rotations.from_matrix(_axes(way / length))
    for part, at, middle in (("lower", ends[0], 0.25), ("upper", ends[1], -0.25)):
        link = ET.SubElement(model, "link", name=f"{name}_{part}")
        sdf.text(link, "pose", sdf.pose(at, attitude))
        centre = np.array([0.0, 0.0, middle * length])
        across, along = MASS * (3 * radius**2 + (length / 2) ** 2) / 12, MASS * radius**2 / 2
        sdf.inertial(link, MASS, centre, np.diag([across, across, along]))
        sdf.visual(link, "leg", Solid("cylinder", (radius, length / 2), centre), colour(None, CABLE))
    universal = sdf.joint(model, f"{name}_universal", "universal", "frame", f"{name}_lower")
    sdf.turning(universal, "axis", np.array([1.0, 0.0, 0.0]))
    sdf.turning(universal, "axis2", np.array([0.0, 1.0, 0.0]))
    slide = sdf.joint(model, f"{name}_slide", "prismatic", f"{name}_lower", f"{name}_upper")
    reach = sdf.turning(slide, "axis", np.array([0.0, 0.0, 1.0]), -length, longest - length)
    sdf.text(reach, "effort", words([min(cable.tension_max, MAX_MAGNITUDE)]))
    return f"{name}_upper"


def _axes(along: Array) -> Array:
    """Return a rotation (3, 3) whose third column is `along` and whose first is horizontal."""
    level = np.cross([0.0, 0.0, 1.0], along)
    first = level / np.linalg.norm(level) if np.linalg.norm(level) > 1e-6 else np.array([1.0, 0.0, 0.0])
    first = first - (first @ along) * along
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(along, first), along], axis=1)
