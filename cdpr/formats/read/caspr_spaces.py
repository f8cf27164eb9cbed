"""CASPR operational spaces: points of the platform, imported as tools, and the meaning of coordinates y.

A point's offset is relative to the joint, in platform axes. The coordinates y are the point's world position along the
active axes, and the platform's angles. `pose_euler_xyz` uses angles about fixed axes, R = Rz(g) Ry(b) Rx(a), despite
its name; `orientation_euler_xyz` uses those of a joint, R = Rx(a) Ry(b) Rz(g).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cdpr.formats.read.caspr_joints import AXES, FIXED, KINDS, Joint
from cdpr.formats.read.caspr_splines import Points
from cdpr.formats.read.imported import apart, slug, unique
from cdpr.formats.read.xml import Element
from cdpr.model import rotations
from cdpr.model.robot import Array

SPATIAL, SPHERICAL = "SPATIAL_EULER_XYZ", "S_EULER_XYZ"
ALL = KINDS[SPATIAL]
POSITION, POSE, ORIENTATION = "position", "pose_euler_xyz", "orientation_euler_xyz"
LETTERS = dict(zip("xyzabg", ALL, strict=True))
ACTIVE = {POSITION: "xyz", POSE: "xyzabg", ORIENTATION: "abg"}


@dataclass(frozen=True)
class Space:
    """Meaning of a trajectory's coordinates y.

    Attributes:
        axes: direction of each coordinate, as names of `dof`.
        tool: name of the moving point; None for the platform's origin.
        reach: (3,), position of the point relative to the joint, platform axes, m.
        frame: joint with six coordinates at the world's origin, whose body is the point.
        held: (6,), values of that joint's coordinates that y does not contain.
        note: note on assumptions, or "".
    """

    axes: tuple[str, ...]
    tool: str | None
    reach: Array
    frame: Joint
    held: Array
    note: str

    def all_six(self, points: Points) -> Points:
        """Return points with all six coordinates from points of y."""
        where = [ALL.index(name) for name in self.axes]

        def spread(values: Array, otherwise: Array) -> Array:
            found = np.tile(otherwise, (len(values), 1))
            found[:, where] = values
            return found

        rates, seconds = (spread(values, np.zeros(6)) for values in (points.rates, points.seconds))
        return replace(points, q=spread(points.q, self.held), rates=rates, seconds=seconds)


@dataclass(frozen=True)
class Spaces:
    """Operational spaces of a model.

    Attributes:
        tools: points (3,), m, platform axes, by name.
        line: position of the first one in its file, or "".
        left_out: operational spaces that do not belong to the platform.
    """

    tools: dict[str, list[float]]
    line: str
    left_out: list[str]
    _named: list[tuple[Element, str]]
    _roots: list[Element]
    _link: str

    def space(self, element: Element, joint: Joint) -> Space:
        """Return the meaning of a trajectory's coordinates y.

        Raises:
            FormatError: if they do not describe a motion of the platform.
        """
        set_ = self._default(element)
        if len(set_.children) != 1:
            raise set_.wrong(f"the operational set contains {len(set_.children)} spaces; expected one")
        marker = set_.children[0]
        if marker.name not in ACTIVE:
            raise marker.wrong(f"<{marker.name}> is unknown; allowed: {', '.join(ACTIVE)}")
        if (on := _link_of(marker)) != self._link:
            raise marker.wrong(f"it is of link {on or '?'}, and the platform is link {self._link}")
        letters = marker.child("axes").attribute("active_axes")
        if len(set(letters)) != len(letters) or set(letters) - set(ACTIVE[marker.name]):
            raise marker.wrong(f"active_axes: expected letters of {ACTIVE[marker.name]}, once each, got '{letters}'")
        axes = tuple(LETTERS[letter] for letter in letters)
        tool = next((name for each, name in self._named if each is marker), None) if set(axes) & set(AXES) else None
        reach = np.zeros(3) if tool is None else np.array(self.tools[tool])
        held, type_, note = _held(marker, axes, joint, reach)
        frame = Joint(type_, ALL, (0.0, 0.0, 0.0), tuple(held.tolist()))
        return Space(axes, tool, reach, frame, held, note)

    def _default(self, element: Element) -> Element:
        """Return the operational set of a trajectory: the default one, or the only one."""
        every = [each for root in self._roots for each in root.everywhere()]
        sets = {each.attributes.get("id", ""): each for each in every if each.name == "operational_set"}
        named = [each.attributes.get("default_operational_set", "").strip() for each in every]
        wanted = next((name for name in named if name), next(iter(sets)) if len(sets) == 1 else None)
        if wanted in sets:
            return sets[wanted]
        if wanted is not None:
            raise element.wrong(f"its coordinates are of operational set '{wanted}', which does not exist")
        known = f"of {', '.join(sets)} none is the default" if sets else "the model has no operational set"
        raise element.wrong(f"its coordinates are not defined: {known}")


def spaces(roots: list[Element], link: Element, cables: list[str]) -> Spaces:
    """Return the operational spaces in these files; tool names differ from those of the cables."""
    sets = [each for root in roots for each in root.everywhere() if each.name == "operational_set"]
    markers = [marker for each in sets for marker in each.children if marker.find("offset") is not None]
    names = unique([slug(marker.attributes.get("name", ""), "tool") for marker in markers])
    own, left_out = {}, []
    for name, marker in zip(names, markers, strict=True):
        on = _link_of(marker)
        if on == link.attribute("num"):
            own[name] = marker
        else:
            text = f"operational space '{name}': a point of link {on or '?'}, not the platform's"
            left_out.append(f"{Path(marker.file).name}:{marker.line}: {text}")
    tools = apart({name: list(marker.child("offset").vector(3)) for name, marker in own.items()}, cables)
    first = next(iter(own.values()), None)
    line = "" if first is None else f"{Path(first.file).name}:{first.line}"
    return Spaces(tools, line, left_out, list(zip(own.values(), tools, strict=True)), roots, link.attribute("num"))


def _link_of(marker: Element) -> str:
    """Return the link number of a space."""
    return marker.child("link").text.strip()


def _held(marker: Element, axes: tuple[str, ...], joint: Joint, reach: Array) -> tuple[Array, str, str]:
    """Return the values of the six coordinates that y does not contain, the type of the angles, and a note."""
    turning = [name for name in joint.dof if name not in AXES]
    named = [name for name in axes if name not in AXES]
    unsaid = [name for name in joint.dof if name in AXES and name not in axes]
    if unsaid:
        raise marker.wrong(f"it does not define the position along {' and '.join(unsaid)}, along which the joint moves")
    if named and set(turning) - set(named):
        missing = " and ".join(sorted(set(turning) - set(named)))
        raise marker.wrong(f"it defines only some of the platform's angles, not {missing}, about which its joint turns")
    held, note = np.zeros(6), ""
    type_ = FIXED if marker.name == POSE or (not named and joint.type == FIXED) else SPHERICAL
    if not named:
        if turning and len(turning) == len(joint.dof):
            raise marker.wrong("it defines a position but no attitude, and the joint only rotates")
        held[3:] = joint.parts(joint.initial)[1]
        if turning:
            note = "the attitude of the platform is not defined; the attitude of q_initial is used"
    home = np.array(joint.at) + rotations.matrix(joint.quaternion(joint.initial)) @ reach
    held[:3] = np.array(joint.at) if not set(axes) & set(AXES) else home
    place = f"{Path(marker.file).name}:{marker.line}"
    return held, type_, f"{place}: {marker.name} '{marker.attributes.get('name', '')}': {note}" if note else ""
