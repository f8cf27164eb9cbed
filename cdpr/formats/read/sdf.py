"""Reader of SDF robots with cables as legs, as written by generators of the Gazebo plug-in.

A leg is a prismatic joint between two links; one is connected to the link `frame`, the other to the link `platform`, by
revolute, universal or ball joints and possibly intermediate links. These joints define the cable's ends: A_i in the
world, B_i on the platform. Names of legs and intermediate links do not matter. A joint's pose is relative to its child
link. If gz-sim's system DetachableJoint welds a link to the platform, the cable ends at that link's origin.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cdpr.base.errors import FormatError
from cdpr.formats.read.import_options import Choice
from cdpr.formats.read.imported import Imported, slug, unique
from cdpr.formats.read.inertia import filled, six
from cdpr.formats.read.xml import Element, parse, root_of
from cdpr.model import rotations
from cdpr.model.robot import Array
from cdpr.scenario.robot_schema import Inertia

FRAME, PLATFORM, WORLD = "frame", "platform", "world"
SLIDE = "prismatic"
HINGES = ("revolute", "revolute2", "universal", "ball", "fixed")
PARTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
# Further properties of legs; one line reports all of them as omitted.
OF_LEGS = {"inertial", "mass", "inertia", *PARTS, "axis", "xyz", "limit", "effort", "velocity", "lower", "upper"}
OF_LEGS |= {"dynamics", "damping", "friction"}
MODEL = ("", "__model__")  # supported values of a pose's reference
WELD = "DetachableJoint"  # ending of that system's name


class Pose(NamedTuple):
    """Position (3,), m, and rotation (3, 3)."""

    place: Array
    turned: Array

    def then(self, other: Pose) -> Pose:
        """Return the composition with a pose relative to this one."""
        return Pose(self.place + self.turned @ other.place, self.turned @ other.turned)


def recognise(content: bytes) -> bool:
    """Return True if the content is SDF."""
    return root_of(content)[0] == "sdf"


def is_main_file(path: Path, content: bytes) -> bool:
    """Return True: a robot can be read from each SDF file."""
    return True


def read(path: Path, content: bytes, choice: Choice) -> Imported:
    """Read a robot.

    Raises:
        FormatError: if the file is invalid or not representable.
    """
    root = parse(content, str(path))
    models = [each for each in root.everywhere() if each.name == "model" and PLATFORM in _named(each, "link")]
    if len(models) != 1:
        raise root.wrong(f"expected one <model> with a <link> named '{PLATFORM}', got {len(models)}")
    model = models[0]
    links, stands = _links(model), _pose(model)
    platform = links[PLATFORM]
    at = stands.then(_pose(platform))
    given = Path(model.attributes.get("name", "")).name  # the thesis's generator writes a path
    name = slug(given, slug(path.stem, "robot"))
    found = Imported(name, f"SDF with cables as legs: {path.name}, model '{given}'", {"name": name}, [root])
    rows, limits, comments, radii = _legs(model, links, stands, at)
    anchors = np.array([row["platform"] for row in rows])
    body = _body(found, platform, anchors)
    found.robot["platform"] = body
    found.robot["tension"] = {"min": 0.0, "max": limits[0] if len(set(limits)) == 1 else limits}
    if len(set(radii)) == 1 and None not in radii:
        found.robot["cable"] = {"diameter": 2.0 * (radii[0] or 0.0)}
        found.comments["cable", "diameter"] = "m, twice the radius of the legs' cylinders"
    found.robot["home"] = {"position": at.place.tolist()}
    if not np.array_equal(at.turned, np.eye(3)):
        found.robot["home"]["orientation"] = {"quaternion": rotations.from_matrix(at.turned).tolist()}
    found.robot["cables"] = rows
    found.comments |= comments
    found.comments["home", "position"] = f"m, pose of link '{PLATFORM}', line {platform.line}"
    found.comments["tension", "max"] = "N, effort of each slide"
    found.comments["cables",] = f"m: where legs meet the links '{FRAME}' and '{PLATFORM}'"
    found.warnings.append(f"{model.file}:{model.line}: the smallest tension is 0 N: SDF has no lower limit")
    _report_omitted(found, model)
    return found


def _named(model: Element, kind: str) -> list[str]:
    return [each.attributes.get("name", "") for each in model.all(kind)]


def _links(model: Element) -> dict[str, Element]:
    links: dict[str, Element] = {}
    for link in model.all("link"):
        name = link.attribute("name")
        if name in links:
            raise link.wrong(f"link '{name}' occurs twice")
        links[name] = link
    return links


def _pose(element: Element) -> Pose:
    """Return the pose of an element; roll, pitch, yaw are about fixed axes."""
    given = element.find("pose")
    if given is None:
        return Pose(np.zeros(3), np.eye(3))
    others = {key: value for key, value in given.attributes.items() if key not in ("relative_to", "frame")}
    relative = [given.attributes.get(key, "") for key in ("relative_to", "frame")]
    if others or any(base not in MODEL for base in relative):
        raise given.wrong("expected a <pose> without attributes: x, y, z (m) and roll, pitch, yaw (rad)")
    x, y, z, roll, pitch, yaw = given.vector(6)
    return Pose(np.array([x, y, z]), rotations.matrix(rotations.from_rpy(roll, pitch, yaw)))


def _legs(
    model: Element, links: dict[str, Element], stands: Pose, at: Pose
) -> tuple[list[dict[str, Any]], list[float], dict[tuple[str | int, ...], str], list[float | None]]:
    """Return the cables, their largest tensions, N, comments, and the radii of the drawn legs, m."""
    slides = [joint for joint in model.all("joint") if joint.attributes.get("type") == SLIDE]
    if not slides:
        raise model.wrong("no joint is prismatic: only cables as legs are supported in SDF")
    beside: dict[str, list[tuple[str, Element]]] = {}
    for joint in model.all("joint"):
        if joint.attributes.get("type") in HINGES:
            parent, child = _ends(joint, links)
            beside.setdefault(parent, []).append((child, joint))
            beside.setdefault(child, []).append((parent, joint))
    for weld in _welds(model):
        parent, child = _ends(weld, links)
        beside.setdefault(parent, []).append((child, weld))
        beside.setdefault(child, []).append((parent, weld))
    rows, limits, radii = list[dict[str, Any]](), list[float](), list[float | None]()
    names = unique([slug(slide.attribute("name").removesuffix("_slide"), "cable") for slide in slides])
    for slide, name in zip(slides, names, strict=True):
        ends = dict(_reached(slide, side, beside) for side in _ends(slide, links))
        if ends.keys() != {FRAME, PLATFORM}:
            raise slide.wrong(f"slide '{name}' is not a leg: it does not lead from '{FRAME}' to '{PLATFORM}'")
        place = {end: stands.then(_at(joint, links)).place for end, joint in ends.items()}
        anchor = at.turned.T @ (place[PLATFORM] - at.place)
        rows.append({"name": name, "frame": place[FRAME].tolist(), "platform": anchor.tolist()})
        limits.append(_effort(slide))
        radii.append(_radius(links[slide.child("child").text.strip()]))
    return rows, limits, {("cables", k): f"line {slide.line}" for k, slide in enumerate(slides)}, radii


def _welds(model: Element) -> list[Element]:
    """Return the systems that weld two links of the model at start."""
    inside = (*MODEL, model.attributes.get("name", ""))
    found = [each for each in model.all("plugin") if each.attributes.get("name", "").endswith(WELD)]
    return [each for each in found if each.child("child_model").text.strip() in inside]


def _ends(joint: Element, links: dict[str, Element]) -> tuple[str, str]:
    """Return the names of the links that a joint or weld connects; the world is allowed."""
    suffix = "" if joint.name == "joint" else "_link"
    names = [joint.child(f"{end}{suffix}").text.strip() for end in ("parent", "child")]
    for name in names:
        if name not in links and name != WORLD:
            raise joint.wrong(
                f"{joint.name} '{joint.attributes.get('name', '')}' joins the link '{name}', which does not exist"
            )
    return names[0], names[1]


def _reached(slide: Element, side: str, beside: dict[str, list[tuple[str, Element]]]) -> tuple[str, Element]:
    """Return the end of a leg ("frame" or "platform") on one side of a slide, and the joint there."""
    if side in (FRAME, WORLD, PLATFORM):
        return (PLATFORM if side == PLATFORM else FRAME), slide
    seen, waiting = {side}, [side]
    found: dict[str, Element] = {}
    while waiting:
        for other, joint in beside.get(waiting.pop(), []):
            if other in (FRAME, WORLD, PLATFORM):
                found.setdefault(PLATFORM if other == PLATFORM else FRAME, joint)
            elif other not in seen:
                seen.add(other)
                waiting.append(other)
    if len(found) != 1:
        name = slide.attributes.get("name", "")
        raise slide.wrong(f"slide '{name}' is not a leg: link '{side}' is joined to {' and '.join(found) or 'neither'}")
    return next(iter(found.items()))


def _at(joint: Element, links: dict[str, Element]) -> Pose:
    """Return the pose of a joint in the model; for a weld, that of the link that is not the platform."""
    if joint.name != "joint":
        return _pose(links[next(name for name in _ends(joint, links) if name not in (FRAME, WORLD, PLATFORM))])
    child = joint.child("child").text.strip()
    return (_pose(links[child]) if child in links else Pose(np.zeros(3), np.eye(3))).then(_pose(joint))


def _effort(slide: Element) -> float:
    limit = slide.child("axis").find("limit")
    effort = None if limit is None else limit.find("effort")
    name = slide.attributes.get("name", "")
    try:
        value = 0.0 if effort is None else effort.number()
    except FormatError as error:  # SDF writes 1e16 for an unlimited effort
        raise FormatError(f"{error}: of slide '{name}' it is the largest tension, N") from None
    if not value > 0.0:
        raise slide.wrong(f"slide '{name}': expected <effort>, the largest tension in N")
    return value


def _radius(link: Element) -> float | None:
    for each in link.everywhere():
        if each.name == "cylinder" and (radius := each.find("radius")) is not None and radius.number() > 0.0:
            return radius.number()
    return None


def _body(found: Imported, platform: Element, anchors: Array) -> dict[str, Any]:
    """Return the section `platform` of a robot file."""
    inertial = platform.child("inertial")
    mass, tensor = inertial.child("mass").number(), inertial.find("inertia")
    at = _pose(inertial)
    parts = [0.0] * 6 if tensor is None else [_part(tensor, part) for part in PARTS]
    xx, yy, zz, xy, xz, yz = parts
    turned: Inertia = (xx, yy, zz, xy, xz, yz)
    if not np.array_equal(at.turned, np.eye(3)):
        turned = six(at.turned @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ at.turned.T)
    try:
        whole, note = filled(turned, mass, anchors - at.place, turning=True)
    except ValueError as error:
        raise (tensor or inertial).wrong(str(error)) from None
    if note:
        found.warnings.append(f"{platform.file}:{inertial.line}: {note}")
    assert whole is not None
    found.comments["platform", "mass"] = f"kg, line {inertial.line}"
    found.comments["platform", "inertia"] = "kg m^2, about the centre of mass"
    found.comments["platform", "center_of_mass"] = "m, pose of <inertial>"
    body: dict[str, Any] = {"mass": mass, "inertia": list(whole), "center_of_mass": at.place.tolist()}
    for visual in platform.all("visual"):
        boxes = [each for each in visual.everywhere() if each.name == "box"]
        if boxes and not _pose(visual).place.any() and np.array_equal(_pose(visual).turned, np.eye(3)):
            body["shape"] = {"box": boxes[0].child("size").vector(3)}
            break
    return body


def _part(tensor: Element, part: str) -> float:
    given = tensor.find(part)
    return 0.0 if given is None else given.number()


def _report_omitted(found: Imported, model: Element) -> None:
    """Report omitted parts, and values that are probably wrong."""
    slides = [joint for joint in model.all("joint") if joint.attributes.get("type") == SLIDE]
    limits = slides[0].child("axis").find("limit")
    speed = None if limits is None else limits.find("velocity")
    if speed is not None and speed.number() == _effort(slides[0]):
        found.warnings.append(
            f"{model.file}:{speed.line}: effort and velocity of slides are the same: a generator of the plug-in wrote "
            "the velocity in both; check the largest tension"
        )
    first = slides[0].line
    found.left_out.append(
        f"{model.file}:{first}: masses, damping, speed and range of the legs: not supported by cables"
    )
    welds = _welds(model)
    plugins = {
        plugin.attributes.get("filename", ""): plugin.line
        for plugin in reversed(model.all("plugin"))
        if plugin not in welds
    }
    for name, line in sorted(plugins.items(), key=lambda one: one[1]):
        found.left_out.append(f"{model.file}:{line}: plugin '{name}'")
    for plugin in model.all("plugin"):
        if plugin not in welds:
            plugin.done()
    for part in (*model.all("link"), *model.all("joint")):
        for each in part.everywhere() if part.attributes.get("name") != PLATFORM else ():
            if each.name in OF_LEGS:
                each.touch()
                if not each.children:
                    each.text  # noqa: B018 - recorded as read: the line above names them
