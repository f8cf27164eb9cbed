"""CASPR trajectories as motions of the platform.

Times are relative to the start (`absolute`) or to the previous point (`relative`); coordinates are always absolute.
Between two attitudes given by three angles, CASPR interpolates along the shortest rotation, R_s exp(s(t) log(R_s^T
R_e)), at rest at both ends. Waypoints do the same, so that quintic splines become waypoints with all derivatives. Other
splines, and rotations about one axis by more than half a turn, are sampled into a table at the trajectory's time step.
In operational space each coordinate has its own curve, including angles; the moving point becomes a tool.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.base.files import UnreadableError
from cdpr.base.files import read as read_bytes
from cdpr.base.problems import shown
from cdpr.formats.read.caspr_joints import Joint
from cdpr.formats.read.caspr_spaces import Spaces
from cdpr.formats.read.caspr_splines import BETWEEN, LINEAR, QUINTIC, Points, read
from cdpr.formats.read.imported import Motion, refuse, slug, unique
from cdpr.formats.read.xml import Element
from cdpr.model import rotations
from cdpr.model.robot import Array
from cdpr.scenario.motions.csv import Csv
from cdpr.scenario.motions.table import MAX_ROWS
from cdpr.scenario.motions.waypoints import Waypoints

HEAD = "t,x,y,z,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz,ax,ay,az"
MOST_BYTES = 32 * 2**20
OLDER = "trajectory"  # in older files: a quintic spline with absolute times
FILE = "file_trajectory"
OPERATIONAL = (LINEAR, QUINTIC)  # the kinds that CASPR supports in operational space


def motions(root: Element, joint: Joint, spaces: Spaces) -> tuple[list[Motion], list[str], list[str]]:
    """Return the motions of a trajectory file, omitted items with reasons, and notes on assumptions."""
    found, left_out, notes = [], [], []
    for group in root.children:
        for element in group.children if group.name.endswith("_trajectories") else [group]:
            name = element.attributes.get("id", "")
            try:
                if group.name == "operational_trajectories":
                    motion, taken = _operational(element, joint, spaces)
                    notes += [taken] if taken else []
                else:
                    motion = _motion(element, joint)
                found.append((name, motion))
            except CdprError as error:
                left_out.append(f"{error} (trajectory '{name}')")
                element.done()
    names = unique([slug(name, "motion") for name, _ in found])
    for name, (_, motion) in zip(names, found, strict=True):
        motion.name = name
        motion.tables = {f"{name}.csv": text for text in motion.tables.values()}
        if motion.tables:
            motion.trajectory["file"] = f"{name}.csv"
    return [motion for _, motion in found], left_out, list(dict.fromkeys(notes))


def _motion(element: Element, joint: Joint) -> Motion:
    if element.name == OLDER:
        element = element.known_as(QUINTIC, time_definition="absolute")
    if element.name == FILE:
        return _tabled(_of_file(element, joint), joint)
    if element.name not in BETWEEN:
        raise element.wrong(f"<{element.name}> is unknown; allowed: {', '.join([*BETWEEN, FILE])}")
    points = read(element, len(joint.dof), "q")
    if joint.turns == 3 and _turning(points, joint):
        raise element.wrong("three angles have rates that are not 0 at a point, which CASPR does not support either")
    element.touch("time_step", "blend_time_default")  # unused in kinds where they have no meaning
    if points.kind == QUINTIC and (joint.turns != 1 or _near(points, joint)):
        return _passed(points, joint)
    parts = points.sampled(element)
    return _tabled(parts, joint, _shortest(points, joint, parts[0]) if joint.turns == 3 else None)


def _operational(element: Element, joint: Joint, spaces: Spaces) -> tuple[Motion, str]:
    """Return the motion of a point of the platform, and a note on assumptions."""
    if element.name not in OPERATIONAL:
        known = " and ".join(OPERATIONAL)
        raise element.wrong(f"<{element.name}> is not supported in operational space: CASPR has only {known}")
    space = spaces.space(element, joint)
    points = space.all_six(read(element, len(space.axes), "y"))
    passed = _one_turn(points, space.frame)
    motion = _passed(points, space.frame) if passed else _tabled(points.sampled(element), space.frame)
    if space.tool is not None:
        motion.trajectory["tool"] = space.tool
        motion.initial = _origin(motion.initial, space.frame.quaternion(points.q[0].tolist()), space.reach)
    return motion, space.note


def _turning(points: Points, joint: Joint) -> bool:
    """Return True if a point has angular rates or accelerations."""
    return any(joint.parts(row)[1].any() for each in (points.rates, points.seconds) for row in each)


def _near(points: Points, joint: Joint) -> bool:
    """Return True if no angle changes by half a turn or more between points."""
    angles = np.array([joint.parts(row)[1] for row in points.q])
    return bool(np.abs(np.diff(angles, axis=0)).max() < np.pi)


def _one_turn(points: Points, frame: Joint) -> bool:
    """Return True if waypoints reproduce a quintic's angles: all are constant, or only one is not zero."""
    if points.kind != QUINTIC:
        return False
    angles = np.array([frame.parts(row)[1] for row in points.q])
    still = not np.diff(angles, axis=0).any() and not _turning(points, frame)
    moved = np.concatenate([each[:, 3:] for each in (points.q, points.rates, points.seconds)]).any(axis=0)
    return still or (np.count_nonzero(moved) == 1 and _near(points, frame))


def _origin(first: dict[str, Any], attitude: Array, reach: Array) -> dict[str, Any]:
    """Return the initial pose and velocity of the platform's origin, from those of its tool."""
    arm = rotations.matrix(attitude) @ reach
    spin, velocity = (np.array(first.get(key, np.zeros(3))) for key in ("angular_velocity", "velocity"))
    pose = {**first, "position": (np.array(first["position"]) - arm).tolist()}
    return _begins(pose, (velocity - np.cross(spin, arm)).tolist(), spin.tolist())


def _shortest(points: Points, joint: Joint, at: Array) -> tuple[Array, Array]:
    """Return attitudes (k, 4) and angular velocities (k, 3), world frame, at times (k, 1): shortest rotations."""
    attitudes, speeds = [], []
    for time in at[:, 0].tolist():
        k = min(int(np.searchsorted(points.times, time, side="right")) - 1, len(points.times) - 2)
        share, rate = points.share(k, time)
        first, last = (joint.quaternion(points.q[i].tolist()) for i in (k, k + 1))
        way = rotations.rotation_vector(rotations.multiply(rotations.conjugate(first), last))
        angle = float(np.linalg.norm(way))
        axis = way / angle if angle > 0.0 else np.array([0.0, 0.0, 1.0])
        attitudes.append(rotations.multiply(first, rotations.from_axis_angle(axis, share * angle)))
        speeds.append(rotations.matrix(first) @ way * rate)
    return np.array(attitudes), np.array(speeds)


def _passed(points: Points, joint: Joint) -> Motion:
    """Return waypoints with their derivatives."""
    rows = []
    each = (part.tolist() for part in (points.times, points.q, points.rates, points.seconds))
    for time, at, rate, second in zip(*each, strict=True):
        (velocity, _), (acceleration, _) = joint.parts(rate), joint.parts(second)
        row: dict[str, Any] = {"time": time, **joint.pose(at)}
        row["orientation"] = row.get("orientation", {"rpy": [0.0, 0.0, 0.0]})
        turn, turned = joint.turning(at, rate, second)
        row |= {"velocity": velocity.tolist(), "acceleration": acceleration.tolist()}
        rows.append(row | {"angular_velocity": turn.tolist(), "angular_acceleration": turned.tolist()})
    first = _begins(rows[0], rows[0]["velocity"], rows[0]["angular_velocity"])
    return Motion("", {"type": Waypoints.kind(), "points": rows}, float(points.times[-1]), first)


def _of_file(element: Element, joint: Joint) -> list[Array]:
    """Return the samples of a .traj file.

    The file contains `time_step,STEP` and rows `t,TIME,p,...,v,...,a,...`; older files have `q` and no time.
    """
    name = Path(element.attribute("filename"))
    if name.is_absolute() or ".." in name.parts:  # an untrusted model must not read files outside its folder
        raise element.wrong(f"filename: {shown(str(name))} leads out of the folder of the model: put the file there")
    n, path = len(joint.dof), Path(element.file).parent / name
    try:
        text = read_bytes(str(path), MOST_BYTES, (".traj",)).decode("utf-8")
    except (UnreadableError, UnicodeDecodeError) as error:
        raise element.wrong(f"filename: {error}") from None
    rows: list[list[float]] = []
    step = 0.0
    for number, line in enumerate(text.splitlines(), 1):
        words = [word.strip() for word in line.split(",")]
        if not line.strip():
            continue
        try:
            if words[0] == "time_step":
                step = float(words[1])
                continue
            timed = words[0] == "t"
            rows.append(_row(words if timed else ["t", repr(len(rows) * step), *words], n))
        except (ValueError, IndexError):
            text = f"expected t,TIME,p,...,v,...,a,... with {n} numbers each, got '{line[:60]}'"
            raise refuse(str(path), number, text) from None
        if len(rows) > MAX_ROWS:
            raise refuse(str(path), number, f"more than {MAX_ROWS} points")
    table = np.array(rows)
    if len(rows) < 2 or not np.isfinite(table).all() or (np.diff(table[:, 0]) <= 0.0).any():
        raise refuse(str(path), 1, "expected two or more points of finite numbers, at times that rise")
    table[:, 0] -= table[0, 0]
    return [table[:, :1], *(table[:, 1 + k * n : 1 + (k + 1) * n] for k in range(3))]


def _row(words: list[str], n: int) -> list[float]:
    """Return time, coordinates, rates and second derivatives of a row of a .traj file.

    Raises:
        ValueError: if the row is malformed.
        IndexError: if the row is too short.
    """
    width = n + 1
    expected = 2 + 3 * width
    labels = [words[k] for k in range(2, expected, width)]
    if labels[1:] != ["v", "a"] or labels[0] not in ("p", "q"):
        raise ValueError
    return [float(word) for k, word in enumerate(words[1:expected]) if (k - 1) % width or k == 0]


def _tabled(parts: list[Array], joint: Joint, turned: tuple[Array, Array] | None = None) -> Motion:
    """Return a table of poses and velocities; `turned` overrides the attitudes and angular velocities of the angles."""
    lines = [HEAD]
    for k, ((time,), q, rate, second) in enumerate(zip(*(part.tolist() for part in parts), strict=True)):
        place = np.array(joint.at) + joint.parts(q)[0]
        velocity, acceleration = joint.parts(rate)[0], joint.parts(second)[0]
        attitude, turn = joint.quaternion(q), joint.turning(q, rate, second)[0]
        if turned is not None:
            attitude, turn = turned[0][k], turned[1][k]
        row = [time, *place, *attitude, *velocity, *turn, *acceleration]
        lines.append(",".join(repr(float(value)) for value in row))
    q, rate, second = (part[0].tolist() for part in parts[1:])
    turn = joint.turning(q, rate, second)[0] if turned is None else turned[1][0]
    first = _begins(joint.pose(q), joint.parts(rate)[0].tolist(), turn.tolist())
    table = "\n".join(lines) + "\n"
    return Motion("", {"type": Csv.kind(), "file": ""}, float(parts[0][-1, 0]), first, tables={"": table})


def _begins(pose: dict[str, Any], velocity: list[float], turn: list[float]) -> dict[str, Any]:
    """Return the initial pose and velocity, so that the platform moves from the first step."""
    first = {"position": pose["position"], "orientation": pose.get("orientation", {"rpy": [0.0, 0.0, 0.0]})}
    return first | {key: v for key, v in (("velocity", velocity), ("angular_velocity", turn)) if any(v)}
