"""Mapping of the columns of a row to messages."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from cdpr.base.column import ARRAY, Column
from cdpr.base.columns import COMMANDS, TOPICS, WINCHES
from cdpr.log.header import Header
from cdpr.log.layout import Layout
from cdpr.model.robot import Array

WORLD = "world"  # frame of all data in a log
STAMPED: dict[str, Any] = {"header": {"frame_id": WORLD}}


@dataclass(frozen=True)
class Topic:
    """Topic with its constant content and the columns of a source row that fill its fields."""

    name: str
    kind: str  # message type, "package/Type"
    value: dict[str, Any]  # constant fields, and sequences of the right length
    columns: dict[str, tuple[slice, ...]] = field(default_factory=dict)  # by path, in order
    stamps: tuple[str, ...] = ("header.stamp",)  # paths of the times


CLOCK = Topic("/clock", "rosgraph_msgs/Clock", {}, stamps=("clock",))


@dataclass(frozen=True)
class Group:
    """Topics written for the same rows and in the same chunks."""

    topics: tuple[Topic, ...]
    channel: int  # channel of the first topic; the others follow
    width: int  # columns of a source row
    every: int  # samples per message
    source: Callable[[Array], Array]  # rows (n, row width) -> source rows (n, width), C-contiguous


def run_topics(header: Header, *, repeated: bool = False) -> Group:
    """Return the topics that together hold all columns of all rows, as defined in `cdpr.base.columns`.

    The time has no topic: it is k * control_step, with k the sequence number of the messages. Commands of ideal cables
    have no topic: they equal the efforts of the cable states. With `repeated`, as in logs of format 2, both have one.
    """
    layout = header.layout
    held: dict[str, dict[str, list[Column]]] = {topic: {} for topic in TOPICS}
    for column in layout.fields.values():
        for topic, path in column.topics:
            paths = held.setdefault(topic, {})
            paths[path] = [*paths.get(path, []), column] if _kind(topic) == ARRAY else [column]
    if not repeated:
        del held[CLOCK.name]
        if header.ideal_cables:
            del held[COMMANDS]
    if "position" not in held[WINCHES]:
        del held[WINCHES]
    topics = tuple(_topic(topic, paths, header) for topic, paths in held.items())
    return Group(topics, channel=1, width=layout.width, every=header.log_every, source=lambda rows: rows)


def _kind(topic: str) -> str:
    return TOPICS.get(topic, ARRAY)


def _topic(name: str, held: dict[str, list[Column]], header: Header) -> Topic:
    kind, layout = _kind(name), header.layout
    if name == CLOCK.name:
        return CLOCK
    columns = {path: tuple(run for column in held[path] for run in _runs(column, layout, kind)) for path in held}
    if kind == ARRAY:
        labels = [label for column in held["data"] for label in column.labels(header.cables)]
        size = len(labels)
        dimension = {"label": ", ".join(labels), "size": size, "stride": size}
        return Topic(name, kind, {"layout": {"dim": [dimension]}, "data": [0.0] * size}, columns, stamps=())
    joints: dict[str, Any] = {}
    if kind == "sensor_msgs/JointState":
        joints = {"name": header.cables, **{path: [0.0] * layout.m for path in held}}
    return Topic(name, kind, {**STAMPED, **joints}, columns)


def _runs(column: Column, layout: Layout, kind: str) -> tuple[slice, ...]:
    """Return the columns of a field in the order of the message: ROS orders quaternions as x, y, z, w."""
    place = layout.columns[column.name]
    if kind == ARRAY or not (column.width == 4 and column.frame):
        return (place,)
    return slice(place.start + 1, place.stop), slice(place.start, place.start + 1)


def ros_pose(layout: Layout, which: str = "") -> tuple[slice, ...]:
    """Return the columns of the actual or "desired_" pose in the order of ROS: x, y, z; x, y, z, w."""
    kind, fields = "geometry_msgs/Pose", layout.fields
    return *_runs(fields[f"{which}position"], layout, kind), *_runs(fields[f"{which}orientation"], layout, kind)
