"""What a 3D viewer shows of a run: the platform's frame and shape, and the cables, coloured by tension."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from cdpr.cables import read_exits
from cdpr.log.run import Header
from cdpr.log.topics import STAMPED, Group, Topic, ros_pose
from cdpr.model import rotations
from cdpr.model.robot import Array

TRANSFORM_RATE = 60.0  # Hz of simulation time, at most
MARKER_RATE = 30.0
_CUBE, _SPHERE, _CYLINDER, _LINE_LIST = 1, 2, 3, 5  # visualization_msgs/Marker
_AT_ORIGIN = {"orientation": {"w": 1.0}}
_GREY = {"r": 0.55, "g": 0.57, "b": 0.6, "a": 1.0}


def visual_topics(header: Header, channel: int) -> tuple[Group, ...]:
    """Return /tf and /cdpr/markers, on the channels from `channel` on; they follow from the rows."""
    layout = header.layout
    transform = Topic(
        "/tf",
        "tf2_msgs/TFMessage",
        {"transforms": [{**STAMPED, "child_frame_id": "platform"}]},
        {"transforms.0.transform": ros_pose(layout)},
        stamps=("transforms.0.header.stamp",),
    )
    every = _every(TRANSFORM_RATE, header)
    frames = Group((transform,), channel, layout.width, every, np.ascontiguousarray)
    return frames, _markers(header, channel + 1)


def _markers(header: Header, channel: int) -> Group:
    m = len(header.cables)
    cables: dict[str, Any] = {
        **STAMPED,
        "ns": "cables",
        "type": _LINE_LIST,
        "pose": _AT_ORIGIN,
        "scale": {"x": 0.01 * header.characteristic_length},
        "color": _GREY,
        "points": [{}] * (2 * m),
        "colors": [{}] * (2 * m),
    }
    markers: list[dict[str, Any]] = [cables]
    # A source row: 2 m points, 2 m colours (four float32 stand in two float64), pose of the platform.
    points, colours, pose = slice(0, 6 * m), slice(6 * m, 10 * m), slice(10 * m, 10 * m + 7)
    columns: dict[str, tuple[slice, ...]] = {"markers.0.points": (points,), "markers.0.colors": (colours,)}
    if header.shape is not None:
        kind, size, middle = _platform(header.shape)
        platform = {"ns": "platform", "type": kind, "scale": _xyz(size), "color": _colour(header, "platform")}
        if any(middle):  # it stands off the origin in the platform's own frame, which moves
            there = {"pose": {**_AT_ORIGIN, "position": _xyz(middle)}, "frame_locked": True}
            markers.append({"header": {"frame_id": "platform"}, **platform, **there})
        else:
            markers.append({**STAMPED, **platform})
            columns["markers.1.pose"] = (pose,)
    if header.frame:
        frame = {"ns": "frame", "type": _LINE_LIST, "pose": _AT_ORIGIN, "color": _colour(header, "frame")}
        corners = [_xyz(edge[end : end + 3]) for edge in header.frame for end in (0, 3)]
        markers.append({**STAMPED, **frame, "scale": cables["scale"], "points": corners})
    topic = Topic(
        "/cdpr/markers",
        "visualization_msgs/MarkerArray",
        {"markers": markers},
        columns,
        stamps=tuple(f"markers.{i}.header.stamp" for i in range(len(markers))),
    )
    every = _every(MARKER_RATE, header)
    return Group((topic,), channel, pose.stop, every, lambda rows: _marker_rows(header, rows))


def _platform(shape: dict[str, Any]) -> tuple[int, list[float], list[float]]:
    """Marker, extent along the platform's axes and middle of its shape, m."""
    (kind, size), middle = next(iter(shape.items())), [0.0] * 3
    if kind == "mesh":  # the box around it
        lower, upper = size
        middle = [0.5 * (low + high) for low, high in zip(lower, upper, strict=True)]
        return _CUBE, [high - low for low, high in zip(lower, upper, strict=True)], middle
    if kind == "cylinder":
        radius, height = size
        return _CYLINDER, [2.0 * radius, 2.0 * radius, height], middle
    return (_CUBE, size, middle) if kind == "box" else (_SPHERE, [2.0 * size] * 3, middle)


def _xyz(values: Sequence[float]) -> dict[str, float]:
    return dict(zip("xyz", values, strict=True))


def _colour(header: Header, part: str) -> dict[str, float]:
    """The colour of a part, grey unless it is given."""
    if part not in header.colours:
        return _GREY
    parts = bytes.fromhex(header.colours[part].removeprefix("#"))
    return {**{key: value / 255.0 for key, value in zip("rgb", parts, strict=True)}, "a": 1.0}


def _every(rate: float, header: Header) -> int:
    """Samples from one message to the next: whole rows."""
    return header.log_every * max(1, math.ceil(1.0 / (rate * header.log_step) - 1e-9))


def _marker_rows(header: Header, rows: Array) -> Array:
    layout, n, m = header.layout, len(rows), len(header.cables)
    anchors = np.array(header.anchors, dtype=np.float64)
    source = np.empty((n, 10 * m + 7))
    points = source[:, : 6 * m].reshape(n, m, 2, 3)
    colours = source[:, 6 * m : 10 * m].view(np.float32).reshape(n, m, 2, 4)
    np.concatenate([rows[:, run] for run in ros_pose(layout)], axis=1, out=source[:, 10 * m :])
    with np.errstate(all="ignore"):  # a diverged run is drawn too, as far as it goes
        R = rotations.matrix(rows[:, layout.columns["orientation"]].T)  # (3, 3, n)
        points[:, :, 1] = rows[:, None, layout.columns["position"]]
        for j in range(3):  # R @ B_i, without matmul, whose last bit depends on the machine
            points[:, :, 1] += R[:, None, j].T * anchors[:, None, 3 + j]
        points[:, :, 0] = _frame_ends(header, anchors, points[:, :, 1])
        tension = layout.columns.get("cable_tension", layout.columns["tension"])
        colours[:] = _ramp(rows[:, tension], header)[:, :, None]
    return source


def _frame_ends(header: Header, anchors: Array, tips: Array) -> Array:
    """Return where the cables to `tips` (n, m, 3) leave the frame: (m, 3) where that is fixed, else (n, m, 3)."""
    if not header.exits:
        return anchors[:, :3]
    from cdpr.cables.lines import rows
    from cdpr.mechanics.geometry import leaving

    points = np.empty(tips.shape)
    leaving(rows(anchors, read_exits(header.exits)), np.ascontiguousarray(tips), points)
    return points


def _ramp(tension: Array, header: Header) -> Array:
    """Blue at the lowest tension, green halfway, red at the highest, (n, m, 4)."""
    low, high = np.array(header.tension_min), np.array(header.tension_max)
    part = np.clip(np.nan_to_num((tension - low) / (high - low)), 0.0, 1.0)
    colour = [part, 1.0 - np.abs(2.0 * part - 1.0), 1.0 - part, np.ones_like(part)]
    return np.stack(colour, axis=-1)
