"""3D display of a run: the platform's frame and shape, cables coloured by tension, and the clock.

The run's range of tensions is unknown while a log is written. Colours therefore use a logarithmic scale over the range
expected from the platform's weight, `cdpr.scene.pictures.weight_range`, from dark blue to yellow. Slack cables are
grey, cables at a limit magenta, and broken ones invisible.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from cdpr.log.header import Header
from cdpr.log.sensor_topics import frames as sensor_frames
from cdpr.log.sensor_topics import sensor_groups
from cdpr.log.topics import CLOCK, STAMPED, Group, Topic, ros_pose
from cdpr.model.robot import Array
from cdpr.scene import Pictures, State, colours, pictures
from cdpr.scene.pictures import weight_range

TRANSFORM_RATE = 60.0  # Hz of simulation time, maximum; also of the clock, as players otherwise use 40
MARKER_RATE = 30.0
PATH_RATE = 1.0  # constant; repeated only for later subscribers
PATH = "/cdpr/desired_path"
SAGGING_PIECES = 8  # lines that show a sagging cable: within 1/64 of its sag, with little data
_CUBE, _SPHERE, _CYLINDER, _LINE_STRIP, _LINE_LIST = 1, 2, 3, 4, 5  # visualization_msgs/Marker
_AT_ORIGIN = {"orientation": {"w": 1.0}}
MARKED = {
    State.SLACK: colours.SLACK.dark,
    State.LOWEST: colours.LIMIT.dark,
    State.HIGHEST: colours.LIMIT.dark,
}
_GREY = {"r": 0.55, "g": 0.57, "b": 0.6, "a": 1.0}


def visual_topics(header: Header, channel: int, *, clock: bool = True) -> tuple[Group, ...]:
    """Return /tf, /cdpr/markers, the planned path and the standard messages of sensors, on channels from `channel` on.

    They depend only on the rows and the header. Headers of earlier versions have no path, and their markers no desired
    pose. With `clock`, /clock accompanies /tf; ROS plays logs by it. Logs of format 2 have it among their rows.
    """
    layout = header.layout
    tools = [
        {
            "header": {"frame_id": "platform"},
            "child_frame_id": name,
            "transform": {"translation": _xyz(point), "rotation": {"w": 1.0}},
        }
        for name, point in header.tools.items()
    ]
    tools += [
        {
            "header": {"frame_id": parent},
            "child_frame_id": name,
            "transform": {
                "translation": _xyz(at.tolist()),
                "rotation": dict(zip("wxyz", turned.tolist(), strict=True)),
            },
        }
        for name, (parent, at, turned) in sensor_frames(header).items()
    ]
    transform = Topic(
        "/tf",
        "tf2_msgs/TFMessage",
        {"transforms": [{**STAMPED, "child_frame_id": "platform"}, *tools]},
        {"transforms.0.transform": ros_pose(layout)},
        stamps=tuple(f"transforms.{i}.header.stamp" for i in range(1 + len(tools))),
    )
    every = _every(TRANSFORM_RATE, header)
    topics = (CLOCK, transform) if clock else (transform,)
    frames = Group(topics, channel, layout.width, every, np.ascontiguousarray)
    channel += len(topics)
    groups = [frames, _markers(header, channel)]
    if len(header.path) >= 2:
        groups.append(_path(header, channel + 1))
    return (*groups, *sensor_groups(header, groups[-1].channel + 1))


def _markers(header: Header, channel: int) -> Group:
    m, pieces = len(header.cables), _pieces(header)
    cables: dict[str, Any] = {
        **STAMPED,
        "ns": "cables",
        "type": _LINE_LIST,
        "pose": _AT_ORIGIN,
        "scale": {"x": 0.01 * header.characteristic_length},
        "color": _GREY,
        "points": [{}] * (2 * pieces * m),
        "colors": [{}] * (2 * pieces * m),
    }
    markers: list[dict[str, Any]] = [cables]
    # A source row, of cables with k pieces: 2 k m points, 2 k m colours (four float32 in two float64), pose of the
    # platform, desired pose.
    k = pieces * m
    points, colour, pose = slice(0, 6 * k), slice(6 * k, 10 * k), slice(10 * k, 10 * k + 7)
    desired = slice(pose.stop, pose.stop + 7)
    columns: dict[str, tuple[slice, ...]] = {"markers.0.points": (points,), "markers.0.colors": (colour,)}
    if header.shape is not None:
        kind, size, middle = _platform(header.shape)
        platform = {"ns": "platform", "type": kind, "scale": _xyz(size), "color": _colour(header, "platform")}
        if any(middle):  # off the origin of the platform's frame, which moves
            there = {"pose": {**_AT_ORIGIN, "position": _xyz(middle)}, "frame_locked": True}
            markers.append({"header": {"frame_id": "platform"}, **platform, **there})
        else:
            markers.append({**STAMPED, **platform})
            columns["markers.1.pose"] = (pose,)
    if header.frame:
        frame = {"ns": "frame", "type": _LINE_LIST, "pose": _AT_ORIGIN, "color": _colour(header, "frame")}
        corners = [_xyz(edge[end : end + 3]) for edge in header.frame for end in (0, 3)]
        markers.append({**STAMPED, **frame, "scale": cables["scale"], "points": corners})
    if header.path and header.shape is not None and not any(middle):
        ghost = {**platform, "ns": "desired", "color": {**_parts(colours.DESIRED.dark), "a": 0.3}}
        columns[f"markers.{len(markers)}.pose"] = (desired,)
        markers.append({**STAMPED, **ghost})
    topic = Topic(
        "/cdpr/markers",
        "visualization_msgs/MarkerArray",
        {"markers": markers},
        columns,
        stamps=tuple(f"markers.{i}.header.stamp" for i in range(len(markers))),
    )
    every = _every(MARKER_RATE, header)
    return Group((topic,), channel, desired.stop, every, lambda rows: _marker_rows(header, rows))


def _platform(shape: dict[str, Any]) -> tuple[int, list[float], list[float]]:
    """Return marker type, extent along the platform's axes and centre of its shape, m."""
    (kind, size), middle = next(iter(shape.items())), [0.0] * 3
    if kind == "mesh":  # bounding box
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
    """Return the colour of a part; grey by default."""
    if part not in header.colours:
        return _GREY
    return {**_parts(header.colours[part]), "a": 1.0}


def _parts(colour: str) -> dict[str, float]:
    return dict(zip("rgb", colours.parts(colour), strict=True))


def _path(header: Header, channel: int) -> Group:
    """Return the desired path as a constant line."""
    line = {
        **STAMPED,
        "ns": "desired path",
        "type": _LINE_STRIP,
        "pose": _AT_ORIGIN,
        "scale": {"x": 0.006 * header.characteristic_length},
        "color": {**_parts(colours.DESIRED.dark), "a": 1.0},
        "points": [{}] * len(header.path),
    }
    points = np.array(header.path).ravel()
    columns: dict[str, tuple[slice, ...]] = {"markers.0.points": (slice(0, len(points)),)}
    stamps = ("markers.0.header.stamp",)
    topic = Topic(PATH, "visualization_msgs/MarkerArray", {"markers": [line]}, columns, stamps)
    every = _every(PATH_RATE, header)
    return Group((topic,), channel, len(points), every, lambda rows: np.tile(points, (len(rows), 1)))


def _every(rate: float, header: Header) -> int:
    """Return the number of samples per message, a multiple of a row's."""
    return header.log_every * max(1, math.ceil(1.0 / (rate * header.log_step) - 1e-9))


def _marker_rows(header: Header, rows: Array) -> Array:
    layout, n, m, pieces = header.layout, len(rows), len(header.cables), _pieces(header)
    fields = layout.columns
    command = rows[:, fields["tension"]]
    shown = pictures(
        header.subject,
        rows[:, fields["time"]][:, 0],
        rows[:, fields["position"]],
        rows[:, fields["orientation"]],
        tension=rows[:, fields["cable_tension"]] if "cable_tension" in fields else command,
        command=command,
        unwound=rows[:, fields["unstretched_length"]] if header.spans else None,
    )
    k = pieces * m
    source = np.empty((n, 10 * k + 14))
    points = source[:, : 6 * k].reshape(n, m, pieces, 2, 3)
    colour = source[:, 6 * k : 10 * k].view(np.float32).reshape(n, m, 2 * pieces, 4)
    poses = (*ros_pose(layout), *ros_pose(layout, "desired_"))
    np.concatenate([rows[:, run] for run in poses], axis=1, out=source[:, 10 * k :])
    lines = shown.cable_lines(pieces + 1)
    points[:, :, :, 0], points[:, :, :, 1] = lines[:, :, :-1], lines[:, :, 1:]
    colour[:] = _cable_colours(header, shown)[:, :, None]
    return source


def _pieces(header: Header) -> int:
    """Return the number of lines that show a cable."""
    return SAGGING_PIECES if header.spans else 1


def _cable_colours(header: Header, shown: Pictures) -> Array:
    """Return the colours (n, m, 4) of cables by tension, over a range that is known before the run."""
    assert shown.tension is not None
    assert shown.state is not None
    low, high = weight_range(header.subject, header.mass * float(np.linalg.norm(header.gravity)))
    with np.errstate(all="ignore"):  # diverged runs are drawn, too
        share = np.log(shown.tension / low) / np.log(high / low)
    rgba = np.ones((*share.shape, 4))
    rgba[..., :3] = colours.tension_colours(share)
    for state, colour in MARKED.items():
        rgba[shown.state == state] = (*colours.parts(colour), 1.0)
    rgba[shown.state == State.BROKEN, 3] = 0.0
    return rgba
