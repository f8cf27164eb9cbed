"""Trajectories of CASPR in joint space, as motions of the platform.

Times are from the start (`absolute`) or from the point before (`relative`); coordinates always are absolute. Between
two attitudes with three angles CASPR goes the shortest way, R_s exp(s(t) log(R_s^T R_e)), at rest at both: so do
waypoints, so that quintic splines are these, with all their derivatives. All others are evaluated at their own time
step into a table, and so are turns about one axis by more than half a turn, where the shortest way is another.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cdpr.errors import CdprError
from cdpr.formats.read.caspr_joints import Joint
from cdpr.formats.read.imported import Motion, refuse, slug, unique
from cdpr.formats.read.xml import Element
from cdpr.model import rotations
from cdpr.model.robot import Array
from cdpr.problems import shown
from cdpr.scenario.files import UnreadableError
from cdpr.scenario.files import read as read_bytes
from cdpr.scenario.motions import Csv, Waypoints
from cdpr.scenario.motions.table import MAX_ROWS

HEAD = "t,x,y,z,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz,ax,ay,az"
MOST_BYTES = 32 * 2**20
SUFFIX = "_trajectory"
QUINTIC = "quintic_spline_trajectory"
OLDER = "trajectory"  # of older files: a quintic spline with times from the start
FILE = "file_trajectory"

# Coordinates, rates and second rates, each (k, n), of a point, of the next, for times (k,) after it, of T s between.
Between = Callable[[Array, Array, Array, float, float], tuple[Array, Array, Array]]


def motions(root: Element, joint: Joint) -> tuple[list[Motion], list[str]]:
    """Return the motions of a file of trajectories, and what was left out and why."""
    found, left_out = [], []
    for group in root.children:
        for element in group.children if group.name.endswith("_trajectories") else [group]:
            name, place = element.attributes.get("id", ""), f"{element.file}:{element.line}"
            if group.name == "operational_trajectories":
                left_out.append(f"{place}: trajectory '{name}' is of operational space, which our robots do not have")
                continue
            try:
                found.append((name, _motion(element, joint)))
            except CdprError as error:
                left_out.append(f"{error} (trajectory '{name}')")
    names = unique([slug(name, "motion") for name, _ in found])
    for name, (_, motion) in zip(names, found, strict=True):
        motion.name = name
        motion.tables = {f"{name}.csv": text for text in motion.tables.values()}
        if motion.tables:
            motion.trajectory["file"] = f"{name}.csv"
    return [motion for _, motion in found], left_out


def _motion(element: Element, joint: Joint) -> Motion:
    if element.name == OLDER:
        element = replace(element, name=QUINTIC, attributes={"time_definition": "absolute", **element.attributes})
    if element.name == FILE:
        return _tabled(_of_file(element, joint), joint)
    if element.name not in BETWEEN:
        raise element.wrong(f"<{element.name}> is not known; there are {', '.join([*BETWEEN, FILE])}")
    points = element.child("points").all("point")
    if len(points) < 2:
        raise element.wrong(f"two or more points are expected, got {len(points)}")
    times, n = _times(element, points), len(joint.dof)
    q = np.array([point.child("q").vector(n) for point in points])
    rests = joint.turns < 3 or _turns_at_rest(points, joint)
    if not rests:
        raise element.wrong("three angles have rates that are not 0 at a point, which CASPR does not take either")
    angles = np.array([joint.parts(row)[1] for row in q])
    if element.name == QUINTIC and (joint.turns != 1 or np.abs(np.diff(angles, axis=0)).max() < np.pi):
        return _passed(points, times, q, joint)
    step = element.attribute_number("time_step")
    count = float(times[-1]) / step if step > 0.0 else np.inf
    if not count < MAX_ROWS:
        raise element.wrong(f"time_step: {step:g} s makes more than {MAX_ROWS} points, or none, of {times[-1]:g} s")
    parts = _sampled(element, points, times, q, step)
    turned = None if joint.turns < 3 else _shortest(element, points, times, q, joint, parts[0])
    return _tabled(parts, joint, turned)


def _turns_at_rest(points: list[Element], joint: Joint) -> bool:
    """Whether nothing turns at any point."""
    given = [each for point in points for name in ("q_dot", "q_ddot") for each in point.all(name)]
    return not any(joint.parts(each.vector(len(joint.dof)))[1].any() for each in given)


def _shortest(
    element: Element, points: list[Element], times: Array, q: Array, joint: Joint, at: Array
) -> tuple[Array, Array]:
    """Attitudes (k, 4) and angular velocities (k, 3), world axes, at times (k, 1), the shortest way between points."""
    attitudes, speeds = [], []
    blends = _blends(element, points)
    for time in at[:, 0].tolist():
        k = min(int(np.searchsorted(times, time, side="right")) - 1, len(times) - 2)
        T = float(times[k + 1] - times[k])
        still, there = np.zeros((3, 1)), np.array([[1.0], [0.0], [0.0]])
        share, rate, _ = BETWEEN[element.name](still, there, np.array([time - times[k]]), T, blends[k + 1])
        first, last = joint.quaternion(q[k].tolist()), joint.quaternion(q[k + 1].tolist())
        way = rotations.rotation_vector(rotations.multiply(rotations.conjugate(first), last))
        angle = float(np.linalg.norm(way))
        axis = way / angle if angle > 0.0 else np.array([0.0, 0.0, 1.0])
        attitudes.append(rotations.multiply(first, rotations.from_axis_angle(axis, float(share[0, 0]) * angle)))
        speeds.append(rotations.matrix(first) @ way * float(rate[0, 0]))
    return np.array(attitudes), np.array(speeds)


def _blends(element: Element, points: list[Element]) -> list[float]:
    """How long the parabolas before each point take, s."""
    if element.name != "parabolic_blend_trajectory":
        return [0.0] * len(points)
    default = element.attribute_number("blend_time_default", 0.0)
    found = [point.attribute_number("blend_time", default) for point in points]
    if min(found) < 0.0:
        raise points[found.index(min(found))].wrong(f"blend_time: at least 0 s is expected, got {min(found):g}")
    return found


def _times(element: Element, points: list[Element]) -> Array:
    """When points are reached, (k,), s, from 0."""
    definition = element.attribute("time_definition")
    if definition not in ("absolute", "relative"):
        raise element.wrong(f"time_definition: absolute or relative is expected, got '{definition}'")
    given = np.array([0.0, *(point.attribute_number("time") for point in points[1:])])
    times = np.cumsum(given) if definition == "relative" else given
    late = np.flatnonzero(np.diff(times) <= 0.0)
    if len(late):
        raise points[late[0] + 1].wrong(f"time: this point comes {np.diff(times)[late[0]]:g} s after the one before it")
    return np.asarray(times)


def _passed(points: list[Element], times: Array, q: Array, joint: Joint) -> Motion:
    """Waypoints with their derivatives."""
    n, rows = len(joint.dof), []
    for point, time, at in zip(points, times.tolist(), q.tolist(), strict=True):
        rate, second = point.child("q_dot").vector(n), point.child("q_ddot").vector(n)
        (velocity, _), (acceleration, _) = joint.parts(rate), joint.parts(second)
        row: dict[str, Any] = {"time": time, **joint.pose(at)}
        row["orientation"] = row.get("orientation", {"rpy": [0.0, 0.0, 0.0]})
        turn, turned = joint.turning(at, rate, second)
        row |= {"velocity": velocity.tolist(), "acceleration": acceleration.tolist()}
        rows.append(row | {"angular_velocity": turn.tolist(), "angular_acceleration": turned.tolist()})
    first = _begins(rows[0], rows[0]["velocity"], rows[0]["angular_velocity"])
    return Motion("", {"type": Waypoints.kind(), "points": rows}, float(times[-1]), first)


def _sampled(element: Element, points: list[Element], times: Array, q: Array, step: float) -> list[Array]:
    """Times (k, 1), coordinates, rates and second rates, each (k, n)."""
    n = q.shape[1]
    rates = np.zeros_like(q)
    seconds = np.zeros_like(q)
    blend = _blends(element, points)
    if element.name == "cubic_spline_average_velocity_trajectory":
        slopes = np.diff(q, axis=0) / np.diff(times)[:, None]
        rates[1:-1] = 0.5 * (slopes[:-1] + slopes[1:])
        rates[0], rates[-1] = (points[k].child("q_dot").vector(n) for k in (0, -1))
    elif element.name not in ("linear_spline_trajectory", "parabolic_blend_trajectory"):
        rates = np.array([point.child("q_dot").vector(n) for point in points])
        if element.name == QUINTIC:
            seconds = np.array([point.child("q_ddot").vector(n) for point in points])
    parts: list[list[Array]] = [[], [], [], []]
    for k in range(len(points) - 1):
        T = float(times[k + 1] - times[k])
        count = max(1, round(T / step))
        t = np.linspace(0.0, T, count + 1)[(1 if k else 0) :]
        if 2.0 * blend[k + 1] > T:
            raise points[k + 1].wrong(f"blend_time: {blend[k + 1]:g} s twice is longer than the {T:g} s of this move")
        ends = np.stack([q[k], rates[k], seconds[k]]), np.stack([q[k + 1], rates[k + 1], seconds[k + 1]])
        found = BETWEEN[element.name](*ends, t, T, blend[k + 1])
        for part, new in zip(parts, (times[k] + t[:, None], *found), strict=True):
            part.append(new)
    return [np.concatenate(part) for part in parts]


def _straight(a: Array, b: Array, t: Array, T: float, _: float) -> tuple[Array, Array, Array]:
    slope = (b[0] - a[0]) / T
    return a[0] + t[:, None] * slope, np.tile(slope, (len(t), 1)), np.zeros((len(t), len(slope)))


def _polynomial(conditions: int) -> Between:
    """Of so many derivatives at both ends, 2 or 3: the cubic or the quintic."""

    def between(a: Array, b: Array, t: Array, T: float, _: float) -> tuple[Array, Array, Array]:
        order = 2 * conditions
        powers = np.array([[_derivative(p, d, x) for p in range(order)] for x in (0.0, T) for d in range(conditions)])
        c = np.linalg.solve(powers, np.concatenate([a[:conditions], b[:conditions]]))
        rows = [np.array([[_derivative(p, d, x) for p in range(order)] for x in t.tolist()]) @ c for d in range(3)]
        return rows[0], rows[1], rows[2]

    return between


def _derivative(power: int, times: int, x: float) -> float:
    """The derivative of x^power, so many times."""
    factor = 1.0
    for k in range(times):
        factor *= power - k
    return factor * x ** (power - times) if power >= times else 0.0


def _blended(a: Array, b: Array, t: Array, T: float, blend: float) -> tuple[Array, Array, Array]:
    """A straight move that begins and ends with a parabola of `blend` s."""
    if blend <= 0.0:
        return _straight(a, b, t, T, 0.0)
    way = b[0] - a[0]
    top = way / (T - blend)
    x = t[:, None]
    begins, ends = x < blend, x > T - blend
    at = np.where(begins, 0.5 * top / blend * x**2, top * (x - 0.5 * blend))
    at = np.where(ends, way - 0.5 * top / blend * (T - x) ** 2, at)
    rate = np.where(begins, top / blend * x, np.where(ends, top / blend * (T - x), top))
    return a[0] + at, rate, np.where(begins, top / blend, np.where(ends, -top / blend, 0.0))


BETWEEN: dict[str, Between] = {
    "linear_spline_trajectory": _straight,
    "cubic_spline_trajectory": _polynomial(2),
    "cubic_spline_average_velocity_trajectory": _polynomial(2),
    QUINTIC: _polynomial(3),
    "parabolic_blend_trajectory": _blended,
}


def _of_file(element: Element, joint: Joint) -> list[Array]:
    """Of a .traj file: `time_step,STEP`, then rows `t,TIME,p,...,v,...,a,...`; older ones say `q` and no time."""
    name = Path(element.attribute("filename"))
    if name.is_absolute() or ".." in name.parts:  # a stranger's model reads nothing but what came with it
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
            text = f"t,TIME,p,...,v,...,a,... with {n} numbers each is expected, got '{line[:60]}'"
            raise refuse(str(path), number, text) from None
        if len(rows) > MAX_ROWS:
            raise refuse(str(path), number, f"{MAX_ROWS} points at most are taken")
    table = np.array(rows)
    if len(rows) < 2 or not np.isfinite(table).all() or (np.diff(table[:, 0]) <= 0.0).any():
        raise refuse(str(path), 1, "two or more points of finite numbers are expected, at times that rise")
    table[:, 0] -= table[0, 0]
    return [table[:, :1], *(table[:, 1 + k * n : 1 + (k + 1) * n] for k in range(3))]


def _row(words: list[str], n: int) -> list[float]:
    """Time, coordinates, rates and second rates of a row of a .traj file. Raises ValueError, IndexError."""
    width = n + 1
    expected = 2 + 3 * width
    labels = [words[k] for k in range(2, expected, width)]
    if labels[1:] != ["v", "a"] or labels[0] not in ("p", "q"):
        raise ValueError
    return [float(word) for k, word in enumerate(words[1:expected]) if (k - 1) % width or k == 0]


def _tabled(parts: list[Array], joint: Joint, turned: tuple[Array, Array] | None = None) -> Motion:
    """A table of the platform's poses and rates; of attitudes and angular velocities that are given, or the angles'."""
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
    """Where and how fast the platform is at first, so that it is on its way from the first step."""
    first = {"position": pose["position"], "orientation": pose.get("orientation", {"rpy": [0.0, 0.0, 0.0]})}
    return first | {key: v for key, v in (("velocity", velocity), ("angular_velocity", turn)) if any(v)}
