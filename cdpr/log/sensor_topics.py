"""Standard messages of sensors and of the estimated state, for viewers and for the nodes of other programs.

They repeat what the columns of the log contain, with the stamp of each measurement: its time, not that of its arrival.
Attitudes and axes are those of REP 103; a distance without an obstacle is infinite (REP 117).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from cdpr.log.header import Header
from cdpr.log.topics import STAMPED, WORLD, Group, Topic
from cdpr.model import rotations
from cdpr.model.robot import Array
from cdpr.scene.sensors import principal_point, ray_directions

PREFIX = "/cdpr/sensors/"
ESTIMATE = "/cdpr/estimate/"
UNKNOWN = -1.0  # first value of the covariance of a quantity that an IMU does not provide
_POSE = "geometry_msgs/PoseWithCovarianceStamped"
_TWIST = "geometry_msgs/TwistWithCovarianceStamped"
_PLATFORM = {"header": {"frame_id": "platform"}}
_DIAGONAL = range(0, 36, 7)
_XYZW = [1, 2, 3, 0]  # order of quaternions in ROS

Columns = Callable[[str], Array]  # values (n, w) of a column of the rows


class Message(NamedTuple):
    """Standard message of a sensor.

    Attributes:
        kind: message type.
        value: constant fields.
        fields: fields by path, each with the function that returns its numbers (n, w), as float64.
    """

    kind: str
    value: dict[str, Any]
    fields: Mapping[str, Callable[[Columns], Array]]


def frame_of(name: str) -> str:
    """Return the name of the frame of a sensor."""
    return f"{name}_frame"


def frames(header: Header) -> dict[str, tuple[str, Array, Array]]:
    """Return parent frame, position (3,), m, and quaternion (4,) of the frame of each sensor with a place."""
    if not header.sensors:  # the subject takes long to import
        return {}
    found = {}
    places = {each.name: each for each in header.subject.sensors}
    for sensor in header.sensors:
        drawn = places.get(sensor["name"])
        if drawn is None:
            continue
        attitude = np.array(sensor["attitude"] if "focal" in sensor else [1.0, 0.0, 0.0, 0.0])
        if sensor["type"] == "range":
            attitude = _along(ray_directions(sensor)[0])
        found[frame_of(drawn.name)] = "platform" if drawn.carried else WORLD, drawn.at, attitude
    return found


def _along(x: Array) -> Array:
    """Return the attitude (4,) of axes whose x is a unit vector (3,)."""
    q = np.array([1.0 + x[0], 0.0, -x[2], x[1]])  # along (1 + x . v, x cross v), for the shortest rotation from x to v
    size = float(np.linalg.norm(q))
    return q / size if size > 1e-9 else np.array([0.0, 0.0, 0.0, 1.0])  # backwards


def sensor_groups(header: Header, channel: int) -> list[Group]:
    """Return the topics of standard messages on channels from `channel` on, one group for each sensor."""
    groups: list[Group] = []
    for sensor in header.sensors:
        messages = _messages(sensor, header)
        if messages:
            every = header.log_every * max(1, int(sensor["period"] / header.log_step + 1e-6))
            age = f"{sensor['name']}_age"  # of measurements; cameras have none
            groups.append(_group(messages, header, channel, every, age if age in header.layout.columns else ""))
            channel += len(messages)
    estimate = _estimate(header)
    if estimate:
        groups.append(_group(estimate, header, channel, header.log_every, ""))
    return groups


def _group(messages: Mapping[str, Message], header: Header, channel: int, every: int, age: str) -> Group:
    """Return the group of messages with the stamp of a measurement, whose age is in a column."""
    topics, start, fields = [], 1, []
    columns = header.layout.columns
    sample = partial(_column, np.zeros((1, header.layout.width)), columns)
    for name, message in messages.items():
        places: dict[str, tuple[slice, ...]] = {"header.stamp": (slice(0, 1),)}
        for path, values in message.fields.items():
            width = values(sample).shape[1]
            places[path] = (slice(start, start + width),)
            start += width
            fields.append(values)
        topics.append(Topic(name, message.kind, message.value, places, stamps=()))

    def source(rows: Array) -> Array:
        read = partial(_column, rows, columns)
        late = read(age)[:, 0] if age else 0.0
        return np.column_stack([_stamps(read("time")[:, 0] - late), *(values(read) for values in fields)])

    return Group(tuple(topics), channel, start, every, source)


def _column(rows: Array, columns: Mapping[str, slice], name: str) -> Array:
    return rows[:, columns[name]]


def _stamps(times: Array) -> Array:
    """Return times (n,), s, as stamps (n,): seconds and nanoseconds, in the bytes of one float64."""
    stamps = np.zeros(len(times), [("sec", "<i4"), ("nanosec", "<u4")])
    whole = np.rint(np.maximum(np.nan_to_num(times), 0.0) * 1e9).astype(np.int64)
    stamps["sec"], stamps["nanosec"] = np.divmod(whole, 10**9)
    return stamps.view(np.float64)


def _singles(values: Array) -> Array:
    """Return numbers (n, w) as float32, two in each float64; an odd one is followed by a zero."""
    padded = np.zeros((len(values), values.shape[1] + values.shape[1] % 2), "<f4")
    padded[:, : values.shape[1]] = values
    return padded.view(np.float64)


def _messages(sensor: Mapping[str, Any], header: Header) -> dict[str, Message]:
    """Return the standard messages of a sensor by topic; none if there is no type for it."""
    name = sensor["name"]
    own = {"header": {"frame_id": frame_of(name)}}

    def column(key: str, order: Any = slice(None)) -> Callable[[Columns], Array]:
        return lambda read: read(f"{name}_{key}")[:, order]

    def variance(key: str) -> float:
        return float(sensor[key]["noise"]) ** 2

    joints = {**STAMPED, "name": list(header.cables)}
    zeros = [0.0] * len(header.cables)
    match sensor["type"]:
        case "pose":
            covariance = _covariance(variance("position"), variance("attitude"))
            fields = {
                "pose.pose.position": column("position"),
                "pose.pose.orientation": column("attitude", _XYZW),
            }
            message = Message(_POSE, {**STAMPED, "pose": {"covariance": covariance}}, fields)
        case "twist":
            covariance = _covariance(variance("velocity"), variance("turn_rate"))
            fields = {"twist.twist.linear": column("velocity"), "twist.twist.angular": column("turn_rate")}
            message = Message(_TWIST, {**STAMPED, "twist": {"covariance": covariance}}, fields)
        case "encoders":
            fields = {"position": column("length"), "velocity": column("rate")}
            message = Message("sensor_msgs/JointState", {**joints, "position": zeros, "velocity": zeros}, fields)
        case "tension":
            message = Message("sensor_msgs/JointState", {**joints, "effort": zeros}, {"effort": column("tension")})
        case "imu":
            constant = {
                **own,
                "orientation": {"w": 1.0},
                "orientation_covariance": [UNKNOWN, *[0.0] * 8],
                "angular_velocity_covariance": _diagonal(variance("turn_rate")),
                "linear_acceleration_covariance": _diagonal(variance("force")),
            }
            fields = {"angular_velocity": column("turn_rate"), "linear_acceleration": column("force")}
            message = Message("sensor_msgs/Imu", constant, fields)
        case "receiver":
            message = Message("geometry_msgs/PointStamped", dict(STAMPED), {"point": column("position")})
        case "range":
            message = _range(sensor, own)
        case "scan":
            message = _scan(sensor, own)
        case _ if "focal" in sensor:
            return {f"{PREFIX}{name}/camera_info": _camera_info(sensor, own)}
        case _:
            return {}
    return {PREFIX + name: message}


def _range(sensor: Mapping[str, Any], own: Mapping[str, Any]) -> Message:
    name, reach = sensor["name"], sensor["reach"]

    def limit_and_range(read: Columns) -> Array:
        values = read(f"{name}_distance")
        return _singles(np.column_stack([np.full(len(values), reach), np.where(values >= reach, np.inf, values)]))

    constant = {**own, "radiation_type": 1, "variance": float(sensor["distance"]["noise"]) ** 2}
    return Message("sensor_msgs/Range", constant, {"max_range": limit_and_range})  # `range` follows it


def _scan(sensor: Mapping[str, Any], own: Mapping[str, Any]) -> Message:
    name, reach, count = sensor["name"], sensor["reach"], sensor["rays"]

    def ranges(read: Columns) -> Array:
        values = read(f"{name}_distance")
        return _singles(np.where(values >= reach, np.inf, values))  # an odd number: then the empty `intensities`

    constant = {
        **own,
        "angle_min": sensor["first"],
        "angle_max": sensor["last"],
        "angle_increment": (sensor["last"] - sensor["first"]) / (count - 1),
        "scan_time": sensor["period"],
        "range_max": reach,
        "ranges": [0.0] * count,
    }
    return Message("sensor_msgs/LaserScan", constant, {"ranges": ranges})


def _camera_info(sensor: Mapping[str, Any], own: Mapping[str, Any]) -> Message:
    (fx, fy), (cx, cy), (width, height) = sensor["focal"], principal_point(sensor), sensor["size"]
    constant = {
        **own,
        "height": height,
        "width": width,
        "distortion_model": "plumb_bob",
        "d": [0.0] * 5,
        "k": [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0],
        "r": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        "p": [fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
    }
    return Message("sensor_msgs/CameraInfo", constant, {})


def _covariance(linear: float, angular: float) -> list[float]:
    """Return the diagonal covariance (36) of a pose or twist."""
    values = [0.0] * 36
    for i, k in enumerate(_DIAGONAL):
        values[k] = linear if i < 3 else angular
    return values


def _diagonal(value: float) -> list[float]:
    return [value if i % 4 == 0 else 0.0 for i in range(9)]


def _estimate(header: Header) -> dict[str, Message]:
    """Return the messages of the estimated state; none if the run has no estimator."""
    known = header.layout.fields
    if "estimated_position" not in known:
        return {}
    pose: dict[str, Callable[[Columns], Array]] = {
        "pose.pose.position": lambda read: read("estimated_position"),
        "pose.pose.orientation": lambda read: read("estimated_orientation")[:, _XYZW],
    }
    twist: dict[str, Callable[[Columns], Array]] = {
        "twist.twist.linear": lambda read: read("estimated_velocity"),
        "twist.twist.angular": lambda read: read("estimated_angular_velocity"),
    }
    if "estimate_sigma" in known:
        pose["pose.covariance"] = lambda read: _estimated_covariance(read, 0, turned=True)
        twist["twist.covariance"] = lambda read: _estimated_covariance(read, 6, turned=False)
    both = {"pose": (_POSE, pose), "twist": (_TWIST, twist)}
    return {ESTIMATE + name: Message(kind, dict(STAMPED), fields) for name, (kind, fields) in both.items()}


def _estimated_covariance(read: Columns, first: int, *, turned: bool) -> Array:
    """Return covariances (n, 36) from standard deviations; with `turned`, the angular ones are in platform axes."""
    sigma = read("estimate_sigma")[:, first : first + 6]
    out = np.zeros((len(sigma), 6, 6))
    out[:, range(6), range(6)] = sigma**2
    if turned:
        R = rotations.matrix(read("estimated_orientation"))
        out[:, 3:, 3:] = np.einsum("nij,nj,nkj->nik", R, sigma[:, 3:] ** 2, R)
    return out.reshape(-1, 36)
