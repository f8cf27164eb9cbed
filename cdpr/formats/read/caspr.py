"""Reader of CASPR models: bodies, cables, trajectories and operational spaces, each in an XML file.

The semantics are those of CASPR's readers (D. Lau et al., "CASPR: A comprehensive cable-robot analysis and simulation
platform for the research of cable-driven parallel robots", IROS 2016). Attachments are relative to the joint or the
centre of mass, and inertias are about either. Joints move a body relative to its pose in the parent. World z is up, as
in cdpr, and gravity acts along -z, for all planar joints.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.base.files import UnreadableError
from cdpr.base.files import read as read_bytes
from cdpr.formats.read import caspr_cables, caspr_joints, caspr_motions, caspr_spaces
from cdpr.formats.read.import_options import Choice
from cdpr.formats.read.imported import Imported, slug
from cdpr.formats.read.inertia import about_centre, filled
from cdpr.formats.read.xml import Element, parse, root_of

BODIES, CABLES, MOTIONS, SPACES = "bodies_system", "cables", "trajectories", "operational_spaces"
SUFFIXES = {BODIES: "bodies", CABLES: "cables", MOTIONS: "trajectories", SPACES: "operational_spaces"}
# Root elements of older files; newer files contain them as children.
LINKS = "links"
OLDER = {LINKS: BODIES, "joint_trajectories": MOTIONS}
MOST_BYTES = 16 * 2**20


def recognise(content: bytes) -> bool:
    """Return True if the content is a file of a CASPR model."""
    return _kind(content) in SUFFIXES and (root_of(content)[0] != LINKS or b"<link_" in content)


def is_main_file(path: Path, content: bytes) -> bool:
    """Return True if a model is read from this file: from its bodies file, or from others if that is missing."""
    return _kind(content) == BODIES or _beside(path, content, BODIES) is None


def read(path: Path, content: bytes, choice: Choice) -> Imported:
    """Read a model from any of its files; `choice` may select the cable set.

    Raises:
        CdprError: if a file is missing, invalid or not representable.
    """
    roots: dict[str, Element | None] = {}
    for kind in SUFFIXES:
        file = path if _kind(content) == kind else _beside(path, content, kind)
        roots[kind] = None if file is None else parse(content if file == path else load(file), str(file))
    bodies, cables = roots[BODIES], roots[CABLES]
    for kind, root in ((BODIES, bodies), (CABLES, cables)):
        if root is None:
            text = f"{path}:1: a model needs a file of its {SUFFIXES[kind]} as well, {_prefix(path, content)}"
            raise CdprError(f"{text}_{SUFFIXES[kind]}.xml in the same folder")
    assert bodies is not None
    assert cables is not None
    return _model(path, bodies, cables, roots[MOTIONS], roots[SPACES], choice.cable_set)


def load(path: Path) -> bytes:
    """Return the content of a file.

    Raises:
        CdprError: if it cannot be read or is too large.
    """
    try:
        content = read_bytes(str(path), MOST_BYTES, (".xml",))
    except UnreadableError as error:
        raise CdprError(str(error)) from None
    if len(content) > MOST_BYTES:
        raise CdprError(f"{path}: is larger than {MOST_BYTES // 2**20} MiB, and no robot")
    return content


def _model(
    path: Path, bodies: Element, cables: Element, motions: Element | None, spaces: Element | None, chosen: str | None
) -> Imported:
    link = _only_link(bodies)
    joint = caspr_joints.joint(link)
    physical = link.child("physical")
    mass, centre = physical.child("mass").number(), physical.child("com_location").vector(3)
    given = physical.child("inertia")
    about = given.attribute("ref")
    if about not in ("com", "joint"):
        raise given.wrong(f"ref of <inertia>: expected com or joint, got '{about}'")
    xx, yy, zz, xy, xz, yz = (given.child(f"I{name}").number() for name in ("xx", "yy", "zz", "xy", "xz", "yz"))
    inertia = (xx, yy, zz, xy, xz, yz)
    if about == "joint":
        inertia = about_centre(inertia, mass, centre)
    set_, rows, comments, left_out = caspr_cables.cables(cables, chosen, centre)
    name = slug(_prefix(path, b""), "robot")
    found = Imported(name, f"CASPR: {bodies.file} and {cables.file}, cable set '{set_}'", {}, [], left_out=left_out)
    found.documents = [root for root in (bodies, cables, motions, spaces) if root is not None]
    try:
        body, note = filled(inertia, mass, np.array([row["platform"] for row in rows]) - centre, joint.turns > 1)
    except ValueError as error:
        raise given.wrong(str(error)) from None
    if joint.turns == 1:  # planar: only the moment about the normal matters
        body, note = inertia, ""
        if inertia["xyz".index(joint.dof[-1][1])] <= 0.0:
            body, note = filled((0.0,) * 6, mass, np.array([row["platform"] for row in rows]) - centre, True)
    if note:
        found.warnings.append(f"{given.file}:{given.line}: {note}")
    platform = {"mass": mass, **({} if body is None else {"inertia": list(body)}), "center_of_mass": centre}
    home = joint.pose(joint.initial)
    found.robot = {
        "name": name,
        "dof": list(joint.dof),
        "platform": platform,
        "tension": _shared(*zip(*(row["tension"] for row in rows), strict=True)),
        "home": home,
        "cables": [{key: value for key, value in row.items() if key != "tension"} for row in rows],
    }
    found.comments = {
        ("dof",): f"joint {joint.type}, {_at(link)}",
        ("platform", "mass"): f"kg, {_at(physical.child('mass'))}",
        ("platform", "inertia"): f'kg m^2 about the centre of mass, from ref="{about}", {_at(given)}',
        ("platform", "center_of_mass"): f"m from the joint, {_at(physical.child('com_location'))}",
        ("tension", "min"): f"N, force_min, from {comments['cables', 0]}",
        ("tension", "max"): f"N, force_max, from {comments['cables', 0]}",
        ("home",): f"q_initial, {_at(link.child('joint'))}",
        ("cables",): f"m; attachments of {_at(cables)}",
        **comments,
    }
    for word in ("q_min", "q_max"):
        if word in link.child("joint").attributes:
            found.left_out.append(f"{_at(link.child('joint'))}: {word}: our robots have no limits of joints")
    own = caspr_spaces.spaces(  # older files have them in the bodies file
        [root for root in (bodies, spaces) if root is not None], link, [row["name"] for row in rows]
    )
    found.left_out += own.left_out
    if own.tools:
        platform["tools"] = own.tools
        found.comments["platform", "tools"] = f"m from the joint; offsets of {own.line}"
    if motions is not None:
        found.motions, skipped, taken = caspr_motions.motions(motions, joint, own)
        found.left_out += skipped
        found.warnings += taken
    return found


def _only_link(bodies: Element) -> Element:
    links = bodies if bodies.name == LINKS else bodies.child(LINKS)
    moving = [each for each in links.children if each.name.startswith("link_")]
    if not moving:
        raise links.wrong("expected a <link_rigid> within <links>, got none")
    if len(moving) > 1:
        second = moving[1]
        raise second.wrong(
            f"link {second.attributes.get('num', '?')} '{second.attributes.get('name', '')}' is a second moving body; "
            "only robots with one platform are supported"
        )
    if moving[0].name != "link_rigid":
        raise moving[0].wrong(f"a <{moving[0].name}> is not supported; expected <link_rigid>")
    return moving[0]


def _shared(lows: tuple[float, ...], highs: tuple[float, ...]) -> dict[str, object]:
    """Return the limits as numbers if all cables share them, else as lists."""
    both = {"min": lows, "max": highs}
    return {key: values[0] if len(set(values)) == 1 else list(values) for key, values in both.items()}


def _kind(content: bytes) -> str:
    """Return the root element's name, in its current form."""
    root = root_of(content)[0]
    return OLDER.get(root, root)


def _at(element: Element) -> str:
    return f"{Path(element.file).name}:{element.line}"


def _prefix(path: Path, content: bytes) -> str:
    """Return the common prefix of a model's files: `ROBOT` of ROBOT_bodies.xml."""
    for suffix in SUFFIXES.values():
        if path.stem.lower().endswith(f"_{suffix}"):
            return path.stem[: -len(suffix) - 1]
    return path.stem


def _beside(path: Path, content: bytes, kind: str) -> Path | None:
    """Return the file of another kind of the same model, ignoring case; None if there is none."""
    wanted = f"{_prefix(path, content)}_{SUFFIXES[kind]}.xml".lower()
    return next((other for other in sorted(path.parent.iterdir()) if other.name.lower() == wanted), None)
