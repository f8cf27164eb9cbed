"""Reader of robots of the Gazebo plug-in for cable robots.

There are two dialects: the thesis's, below the key `model`, and a later one. Both contain anchors A_i in the world and
B_i in platform axes, m; tension limits as `min` and `effort` of the actuated joint, N; and an initial pose with roll,
pitch, yaw about fixed axes, rad. In the later dialect the inertia is about the centre of mass, which is the origin. The
thesis's generator uses the inertia of the box from `lower` to `upper` and ignores `inertial`; so does this reader.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from cdpr.base import defaults
from cdpr.base.colours import COLOURS
from cdpr.base.errors import FormatError
from cdpr.base.problems import short_repr
from cdpr.formats.read.import_options import Choice
from cdpr.formats.read.imported import Imported, Motion, slug
from cdpr.formats.read.inertia import filled
from cdpr.formats.read.yaml_reader import Node, document_of
from cdpr.scenario.motions.quintic import Quintic
from cdpr.scenario.robot_schema import Inertia

CENTRED = 1e-9  # largest distance of a box's centre from the origin, relative to its size: files are rounded
FRAMES = {"box": "box", "poles": "posts"}
ENDS = (("t1", "B"), ("t4", "C"))  # keys of the straight line's end, time and position: current and former
WITHOUT_EFFECT = {
    "controllers": "gains of the plug-in's joints; our controllers have their own",
    "sim_cables": "whether Gazebo simulates cables as legs",
    "filepath": "a path of its author's machine",
    "global_frame": "the plug-in ignores it, too: anchors are in the world",
}


def recognise(content: bytes) -> bool:
    """Return True if the content has anchor points of cables, or times and positions of a trajectory."""
    ours = re.search(rb"^\s*cables:", content, re.MULTILINE) is not None
    return (all(word in content for word in (b"points:", b"platform:", b"frame:")) and not ours) or is_motion(content)


def is_motion(content: bytes) -> bool:
    """Return True if the content is a trajectory, which belongs to a robot."""
    times, places = (re.search(rb"^" + word + rb"\s*:", content, re.MULTILINE) for word in (b"time", b"position"))
    return times is not None and places is not None and b"points:" not in content


def is_main_file(path: Path, content: bytes) -> bool:
    """Return True if a robot is read from this file; trajectories are not read alone."""
    return not is_motion(content)


def read(path: Path, content: bytes, choice: Choice) -> Imported:
    """Read a robot.

    Raises:
        CdprError: if the file is invalid.
    """
    top = document_of(content, str(path))
    if is_motion(content):
        raise top.wrong("this is a trajectory: import its robot, and name this as its trajectory (--trajectory)")
    thesis = "model" in top
    root = top / "model" if thesis else top
    dialect = "the thesis's dialect" if thesis else "oKermorgant/cdpr's dialect"
    name = slug(path.stem, "robot")
    found = Imported(name, f"Gazebo plug-in for cable robots, {dialect}: {path.name}", {"name": name}, [top])
    points = (root / "points").items()
    frames = [(point / "frame").vector(3) for point in points]
    anchors = [(point / "platform").vector(3) for point in points]
    platform, limits = root / "platform", root / "joints" / "actuated"
    mass = (platform / "mass").number()
    robot: dict[str, Any] = {"name": name, "platform": {"mass": mass}}
    inertia, shape = _body(found, platform, mass, np.array(anchors), thesis)
    robot["platform"]["inertia"] = list(inertia)
    if shape is not None:
        robot["platform"]["shape"] = {"box": shape}
        found.comments["platform", "shape"] = f"m, {(platform / ('lower' if thesis else 'size')).at}"
    if (colour := _colour(found, platform)) is not None:
        robot["platform"]["colour"] = colour
    robot["tension"] = {"min": (limits / "min").number(), "max": (limits / "effort").number()}
    place, turned = platform / "position" / "xyz", platform / "position" / "rpy"
    robot["home"] = {"position": place.vector(3)}
    if turned.value is not None and any(turned.vector(3)):
        robot["home"]["orientation"] = {"rpy": turned.vector(3)}
    if "frame" in root:
        robot["frame"] = _frame(found, root / "frame")
        found.comments["frame",] = (root / "frame").at
    radius = root / "cable" / "radius"
    if radius.value is not None and radius.number() > 0.0:
        robot["cable"] = {"diameter": 2.0 * radius.number()}
        found.comments["cable", "diameter"] = f"m, twice {radius.at}"
    robot["cables"] = [{"frame": a, "platform": b} for a, b in zip(frames, anchors, strict=True)]
    found.robot = robot
    found.comments |= {
        ("platform", "mass"): f"kg, {(platform / 'mass').at}",
        ("tension", "min"): f"N, {(limits / 'min').at}",
        ("tension", "max"): f"N, {(limits / 'effort').at}",
        ("home", "position"): f"m, {place.at}",
        ("cables",): "m: A_i in the world, B_i on the platform, of points",
    }
    found.comments |= {("cables", k): f"line {point.line}" for k, point in enumerate(points)}
    for key, why in WITHOUT_EFFECT.items():
        for node in (top / key, root / key):
            if node.value is not None and node.path not in [(other,) for other in ("model",)]:
                text = f"{path}:{node.line}: {key}: {why}"
                found.left_out += [text] if text not in found.left_out else []
                node.done()
    for node, why in (
        (root / "cable" / "mass", "cables here have a linear_density, and the plug-in ignores it, too"),
        (root / "joints" / "passive", "damping of joints at the cables' ends, which are free here"),
        (limits / "damping", "damping of the joint that represents a cable"),
        (limits / "velocity", "a limit of Gazebo's joint, which its engine ignores"),
    ):
        if node.value is not None:
            found.left_out.append(f"{path}:{node.line}: {'.'.join(map(str, node.path))}: {why}")
            node.done()
    found.motions = [_motion(found, choice.trajectory, robot["home"])] if choice.trajectory is not None else []
    return found


def _body(
    found: Imported, platform: Node, mass: float, anchors: Any, thesis: bool
) -> tuple[Inertia, list[float] | None]:
    """Return the inertia about the centre of mass, kg m^2, and the sizes of the box shape."""
    if not thesis:
        given = (platform / "inertia").vector(6) if "inertia" in platform else [0.0] * 6  # early files have none
        xx, yy, zz, xy, xz, yz = given
        found.comments["platform", "inertia"] = f"kg m^2, {(platform / 'inertia').at}"
        shape = (platform / "size").vector(3) if (platform / "type").value == "box" and "size" in platform else None
        return _sound(found, platform / "inertia", (xx, yy, zz, xy, xz, yz), mass, anchors), shape
    if "lower" in platform and "upper" in platform:
        low, high = (platform / "lower").vector(3), (platform / "upper").vector(3)
        a, b, c = (end - begin for begin, end in zip(low, high, strict=True))
        inertia = (mass / 12 * (b * b + c * c), mass / 12 * (a * a + c * c), mass / 12 * (a * a + b * b), 0.0, 0.0, 0.0)
        found.comments["platform", "inertia"] = "kg m^2, of the box from lower to upper, as the thesis's generator"
        if "inertial" in platform:
            node = platform / "inertial"
            found.left_out.append(f"{platform.document.source}:{node.line}: inertial: its generator ignores it")
            node.done()
        centred = all(abs(low[k] + high[k]) <= CENTRED * (high[k] - low[k]) for k in range(3))
        return _sound(found, platform / "lower", inertia, mass, anchors), [a, b, c] if centred else None
    node = platform / "inertial"
    parts = [(node / key).number() for key in ("xx", "yy", "zz", "xy", "xz", "yz")] if node.value else [0.0] * 6
    xx, yy, zz, xy, xz, yz = parts
    found.comments["platform", "inertia"] = "kg m^2, inertial"
    return _sound(found, node, (xx, yy, zz, xy, xz, yz), mass, anchors), None


def _sound(found: Imported, node: Node, inertia: Inertia, mass: float, anchors: Any) -> Inertia:
    try:
        whole, note = filled(inertia, mass, anchors, turning=True)
    except ValueError as error:
        raise node.wrong(str(error)) from None
    if note:
        found.warnings.append(f"{node.document.source}:{node.line}: {note}")
    assert whole is not None
    return whole


def _frame(found: Imported, node: Node) -> dict[str, Any]:
    kind = (node / "type").value
    drawn: dict[str, Any] = {"lower": (node / "lower").vector(3), "upper": (node / "upper").vector(3)}
    if isinstance(kind, str) and kind in FRAMES:
        drawn["shape"] = FRAMES[kind]
    else:
        found.left_out.append(
            f"{node.document.source}:{node.line}: frame.type: {short_repr(kind)}; boxes and posts are drawn"
        )
    if (colour := _colour(found, node)) is not None:
        drawn["colour"] = colour
    return drawn


def _colour(found: Imported, node: Node) -> str | None:
    value = (node / "color").value
    if value is None:
        return None
    if str(value).lower() in COLOURS:
        return str(value).lower()
    found.left_out.append(f"{node.document.source}:{(node / 'color').line}: color: {short_repr(value)} is unknown")
    return None


def _motion(found: Imported, path: Path, home: dict[str, Any]) -> Motion:
    """Return the straight motion of a trajectory file: quintic, from A at t0 to B at t1.

    The plug-in's straight line reads these keys. An older revision used t4 and C instead of t1 and B.
    """
    from cdpr.formats.read.import_files import content_of

    top = document_of(content_of(path), str(path))
    found.documents.append(top)
    time, position = top / "time", top / "position"
    given = [(time / at, position / where) for at, where in ENDS if at in time and where in position]
    if "t0" not in time or "A" not in position or not given:
        raise _other_revision(top)
    t0, start = time / "t0", position / "A"
    end, goal = given[0]
    begins, ends = t0.number(), end.number()
    if not begins < ends:
        raise end.wrong(f"expected a time after t0, {begins:g} s, got {ends:g}")
    first, last = start.vector(3), goal.vector(3)
    turned = {"orientation": home.get("orientation", {"rpy": [0.0, 0.0, 0.0]})}
    move = {"type": Quintic.kind(), "start": max(begins, 0.0), "duration": ends - begins, "to": {"position": last}}
    controller = None
    gains = {key: top / "gain" / name for key, name in (("kp", "Kp"), ("kd", "Kd"))}
    if all(node.value is not None for node in gains.values()):
        controller = {"type": defaults.CONTROLLER, **{key: node.number() for key, node in gains.items()}}
    keys = [str(node.path[-1]) for node in (start, t0, goal, end)]
    found.warnings.append(
        f"{path}:{position.line}: imported as the straight line of the plug-in: a quintic move from {keys[0]} at "
        f"{keys[1]} to {keys[2]} at {keys[3]}; the file does not name the node that plays it"
    )
    if "orientation" in home:
        found.warnings.append(
            f"{path}:{position.line}: the platform keeps its home orientation; the plug-in commands zero angles"
        )
    return Motion(slug(path.stem, "motion"), move, ends, {"position": first, **turned}, controller)


def _other_revision(top: Node) -> FormatError:
    """Return the error for a trajectory of another kind, with the keys of the file."""
    there = [
        f"{key}.{inner}" if isinstance(inner, str) else str(key)
        for key, value in (top.value or {}).items()
        for inner in (value if isinstance(value, dict) else [None])
    ]
    return top.wrong(
        "expected time.t0, time.t1, position.A and position.B (or time.t4 and position.C of an older revision), which "
        f"the plug-in's straight line reads; this file has {', '.join(there)}. Trajectories of its other nodes and of "
        "other revisions are not supported: rename the keys"
    )
