"""Standard messages of sensors and of the estimated state, for viewers and for the nodes of other programs.

They repeat what the columns of the log contain, with the stamp of each measurement: its time, not that of its arrival.
Attitudes and axes are those of REP 103.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from cdpr.log.header import Header
from cdpr.log.topics import WORLD, Group, Topic
from cdpr.model import rotations
from cdpr.model.robot import Array

if TYPE_CHECKING:
    from cdpr.sensing.message import Columns, Message

PREFIX = "/cdpr/sensors/"
ESTIMATE = "/cdpr/estimate/"
_POSE = "geometry_msgs/PoseWithCovarianceStamped"
_TWIST = "geometry_msgs/TwistWithCovarianceStamped"


def frame_of(name: str) -> str:
    """Return the name of the frame of a sensor."""
    return f"{name}_frame"


def frames(header: Header) -> dict[str, tuple[str, Array, Array]]:
    """Return parent frame, position (3,), m, and quaternion (4,) of the frame of each sensor with a place."""
    if not header.sensors:  # the subject takes long to import
        return {}
    return {
        frame_of(each.name): ("platform" if each.carried else WORLD, each.at, each.attitude)
        for each in header.subject.sensors
    }


def sensor_groups(header: Header, channel: int) -> list[Group]:
    """Return the topics of standard messages on channels from `channel` on, one group for each sensor."""
    groups: list[Group] = []
    for sensor in header.sensor_objects:
        message, name = sensor.message(header.cables), sensor.title
        if message is not None:
            every = header.log_every * max(1, int(sensor.period / header.log_step + 1e-6))
            age = f"{name}_age" if sensor.quantities else ""  # cameras measure nothing
            topics = {f"{PREFIX}{name}{message.topic}": message}
            groups.append(_group(topics, header, channel, every, name, age))
            channel += 1
    estimate = _estimate(header)
    if estimate:
        groups.append(_group(estimate, header, channel, header.log_every))
    return groups


def _group(
    messages: Mapping[str, Message], header: Header, channel: int, every: int, name: str = "", age: str = ""
) -> Group:
    """Return the group of messages of a sensor or of the estimate, with the stamp of a measurement of this age."""
    topics, start, fields = [], 1, []
    columns, prefix = header.layout.columns, name and f"{name}_"

    def reader(rows: Array) -> Columns:
        return lambda key: rows[:, columns[prefix + key]]

    sample = reader(np.zeros((1, header.layout.width)))
    for topic, message in messages.items():
        places: dict[str, tuple[slice, ...]] = {"header.stamp": (slice(0, 1),)}
        for path, values in message.fields.items():
            width = values(sample).shape[1]
            places[path] = (slice(start, start + width),)
            start += width
            fields.append(values)
        stamped = {"header": {"frame_id": frame_of(name) if message.framed else WORLD}}
        topics.append(Topic(topic, message.kind, {**stamped, **message.constant}, places, stamps=()))

    def source(rows: Array) -> Array:
        late = rows[:, columns[age]][:, 0] if age else 0.0
        return np.column_stack([_stamps(rows[:, 0] - late), *(values(reader(rows)) for values in fields)])

    return Group(tuple(topics), channel, start, every, source)


def _stamps(times: Array) -> Array:
    """Return times (n,), s, as stamps (n,): seconds and nanoseconds, in the bytes of one float64."""
    stamps = np.zeros(len(times), [("sec", "<i4"), ("nanosec", "<u4")])
    whole = np.rint(np.maximum(np.nan_to_num(times), 0.0) * 1e9).astype(np.int64)
    stamps["sec"], stamps["nanosec"] = np.divmod(whole, 10**9)
    return stamps.view(np.float64)


def _estimate(header: Header) -> dict[str, Message]:
    """Return the messages of the estimated state; none if the run has no estimator."""
    known = header.layout.fields
    if "estimated_position" not in known:
        return {}
    from cdpr.sensing.message import XYZW, Message, quantity  # takes long

    pose: dict[str, Callable[[Columns], Array]] = {
        "pose.pose.position": quantity("estimated_position"),
        "pose.pose.orientation": quantity("estimated_orientation", XYZW),
    }
    twist: dict[str, Callable[[Columns], Array]] = {
        "twist.twist.linear": quantity("estimated_velocity"),
        "twist.twist.angular": quantity("estimated_angular_velocity"),
    }
    if "estimate_sigma" in known:
        pose["pose.covariance"] = lambda read: _estimated_covariance(read, 0, turned=True)
        twist["twist.covariance"] = lambda read: _estimated_covariance(read, 6, turned=False)
    both = {"pose": (_POSE, pose), "twist": (_TWIST, twist)}
    return {ESTIMATE + name: Message(kind, fields, {}) for name, (kind, fields) in both.items()}


def _estimated_covariance(read: Columns, first: int, *, turned: bool) -> Array:
    """Return covariances (n, 36) from standard deviations; with `turned`, the angular ones are in platform axes."""
    sigma = read("estimate_sigma")[:, first : first + 6]
    out = np.zeros((len(sigma), 6, 6))
    out[:, range(6), range(6)] = sigma**2
    if turned:
        R = rotations.matrix(read("estimated_orientation"))
        out[:, 3:, 3:] = np.einsum("nij,nj,nkj->nik", R, sigma[:, 3:] ** 2, R)
    return out.reshape(-1, 36)
