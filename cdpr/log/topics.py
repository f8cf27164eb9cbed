"""Which message holds which columns of a row."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from cdpr.log.layout import Layout
from cdpr.log.run import Header
from cdpr.model.robot import Array

STAMPED: dict[str, Any] = {"header": {"frame_id": "world"}}


@dataclass(frozen=True)
class Topic:
    """One topic: its constant content, and which columns of a source row fill which fields."""

    name: str
    kind: str  # message type, "package/Type"
    value: dict[str, Any]  # constant fields, and sequences of the right length
    columns: dict[str, tuple[slice, ...]] = field(default_factory=dict)  # by path; one after the other
    stamps: tuple[str, ...] = ("header.stamp",)  # paths of the times


@dataclass(frozen=True)
class Group:
    """Topics that are written for the same rows and stand in the same chunks."""

    topics: tuple[Topic, ...]
    channel: int  # of the first topic; the others follow
    width: int  # columns of a source row
    every: int  # samples from one message to the next
    source: Callable[[Array], Array]  # rows (n, row width) -> source rows (n, width), C-contiguous


def run_topics(header: Header) -> Group:
    """Return the topics that together hold every column of every row.

    The time column is not among them: it is k * control_step, k the sequence number of the messages.
    """
    layout = header.layout
    m, c = len(header.cables), layout.columns
    joints = {**STAMPED, "name": header.cables}
    topics = (
        Topic("/clock", "rosgraph_msgs/Clock", {}, stamps=("clock",)),
        Topic(
            "/cdpr/cable_states",
            "sensor_msgs/JointState",
            {**joints, "position": [0.0] * m, "velocity": [0.0] * m, "effort": [0.0] * m},
            {"position": (c["length"],), "velocity": (c["rate"],), "effort": (c.get("cable_tension", c["tension"]),)},
        ),
        # With ideal cables what is commanded is the tension, but where an event broke or jammed one.
        Topic(
            "/cdpr/cable_commands",
            "sensor_msgs/JointState",
            {**joints, "effort": [0.0] * m},
            {"effort": (c["tension"],)},
        ),
        _pose("pose", layout, ""),
        _pose("pose_desired", layout, "desired_"),
        _pair("twist", "Twist", layout.span("velocity", "angular_velocity")),
        _pair("twist_desired", "Twist", layout.span("desired_velocity", "desired_angular_velocity")),
        _pair(
            "acceleration_desired",
            "Accel",
            layout.span("desired_acceleration", "desired_angular_acceleration"),
        ),
        _pair("wrench", "Wrench", c["wrench"]),
        _scalars("solver", layout, ("status", "residual", "margin", "at_limit")),
        _pair("external_wrench", "Wrench", c["external"]),
        _scalars("energy", layout, ("kinetic", "potential", "cable_work", "external_work")),
    )
    return Group(topics, channel=1, width=layout.width, every=header.log_every, source=lambda rows: rows)


def ros_pose(layout: Layout, prefix: str = "") -> tuple[slice, ...]:
    """Columns of position and attitude in the order of ROS: x, y, z; x, y, z, w."""
    w = layout.columns[prefix + "orientation"]
    return layout.columns[prefix + "position"], slice(w.start + 1, w.stop), slice(w.start, w.start + 1)


def _pose(name: str, layout: Layout, prefix: str) -> Topic:
    columns = {"pose": ros_pose(layout, prefix)}
    return Topic(f"/cdpr/platform/{name}", "geometry_msgs/PoseStamped", STAMPED, columns)


def _pair(name: str, kind: str, columns: slice) -> Topic:
    """A message of two vectors that stand side by side in the rows too."""
    return Topic(f"/cdpr/platform/{name}", f"geometry_msgs/{kind}Stamped", STAMPED, {kind.lower(): (columns,)})


def _scalars(name: str, layout: Layout, fields: tuple[str, ...]) -> Topic:
    """Fields of one column each that stand side by side in the rows."""
    size = len(fields)
    value = {"layout": {"dim": [{"label": ", ".join(fields), "size": size, "stride": size}]}, "data": [0.0] * size}
    columns = layout.span(fields[0], fields[-1])
    return Topic(f"/cdpr/{name}", "std_msgs/Float64MultiArray", value, {"data": (columns,)}, stamps=())
