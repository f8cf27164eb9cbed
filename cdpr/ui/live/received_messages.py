"""Conversion of received standard messages in JSON or CDR to checked requests."""

from __future__ import annotations

import json
import math
from typing import Any

from cdpr.base.errors import CdprError
from cdpr.base.nearest import did_you_mean
from cdpr.base.problems import shown
from cdpr.log.ros2 import decode
from cdpr.log.topics import WORLD
from cdpr.simulation.requests import Request

TARGET, WRENCH, TENSION, WINCH = "/cdpr/target_pose", "/cdpr/wrench", "/cdpr/tension", "/cdpr/winch_command"
PAYLOAD = "/cdpr/payload"
PLATFORM = "platform"  # frame of a payload
MOST = 65536  # maximum size of a message, bytes


def request_of(topic: str, encoding: str, data: bytes) -> Request:
    """Return the request in a message.

    Raises:
        CdprError: if the topic is unknown or the message is invalid; the text names the topic.
    """
    if topic not in KNOWN:
        raise CdprError(unknown_topic(topic))
    if encoding not in ("json", "cdr"):
        raise CdprError(f"{topic}: messages must be JSON or CDR, not {shown(encoding)}")
    try:
        message = _json(bounded(data)) if encoding == "json" else decode(KINDS[topic], bounded(data))
        if not isinstance(message, dict):
            raise ValueError("expected an object")
        return KNOWN[topic](message)
    except (ValueError, RecursionError) as error:
        raise CdprError(f"{topic}: {error}") from None


def unknown_topic(topic: str) -> str:
    """Return the message for an unknown topic."""
    return f"{topic or shown(topic)}: unknown topic; {did_you_mean(topic, KNOWN)}topics are {', '.join(KNOWN)}"


def _json(data: bytes) -> object:
    try:
        return json.loads(data, parse_int=float)  # huge integers would raise Python's error on its digit limit
    except ValueError as error:
        raise ValueError(f"expected JSON: {error}") from None


def bounded(data: bytes) -> bytes:
    """Return the data.

    Raises:
        ValueError: if it is too long, since decoding it would delay the run.
    """
    if len(data) > MOST:
        raise ValueError(f"it is longer than {MOST} bytes")
    return data


def _target(message: dict[str, Any]) -> Request:
    _in_frame(message, WORLD)
    pose = _part(message, "pose")
    x, y, z, w = _numbers(_part(pose, "orientation"), "orientation", "xyzw")
    length = math.hypot(x, y, z, w)
    if abs(length - 1.0) > 1e-3:
        raise ValueError(f"orientation: expected a quaternion of norm 1, got norm {length:.6g}")
    values: dict[str, Any] = {"position": _numbers(_part(pose, "position"), "position", "xyz")}
    values["orientation"] = [part / length for part in (w, x, y, z)]
    if "duration" in message:
        values["duration"] = _number(message["duration"], "duration")
    return Request("target", values)


def _wrench(message: dict[str, Any]) -> Request:
    _in_frame(message, WORLD)
    wrench = _part(message, "wrench")
    force, torque = (_numbers(_part(wrench, name), name, "xyz") for name in ("force", "torque"))
    return Request("wrench", {"force": force, "moment": torque})


def _payload(message: dict[str, Any]) -> Request:
    """Return the request of a payload; with the mass 0, of none."""
    _in_frame(message, PLATFORM)
    part = _part(message, "inertia")
    if "m" not in part:
        raise ValueError("inertia.m: required but not given: the mass (kg), or 0 to release the payload")
    mass, center = _number(part["m"], "inertia.m"), _numbers(_part({"com": {}, **part}, "com"), "com", "xyz")
    entries = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    return Request(
        "payload",
        {
            "mass": mass,
            "center": center,
            "inertia": [_number(part.get(entry, 0.0), f"inertia.{entry}") for entry in entries],
        },
    )


def _tension(message: dict[str, Any]) -> Request:
    effort = _list(message, "effort", "tensions (N)")
    if "effort" not in message:
        raise ValueError("effort: required but not given: a list of tensions (N)")
    return Request("tension", {"tension": [_number(value, "effort") for value in effort], "names": _names(message)})


def _winch(message: dict[str, Any]) -> Request:
    """Return the request of lengths, rates and tensions; NaN, or null in JSON, is no value."""
    values = {
        quantity: [_optional(value, name) for value in _list(message, name, what)]
        for quantity, name, what in (
            ("length", "position", "lengths (m)"),
            ("rate", "velocity", "rates (m/s)"),
            ("tension", "effort", "tensions (N)"),
        )
    }
    return Request("winch_command", {"names": _names(message), **values})


KNOWN = {TARGET: _target, WRENCH: _wrench, TENSION: _tension, WINCH: _winch, PAYLOAD: _payload}
KINDS = {
    TARGET: "geometry_msgs/PoseStamped",
    WRENCH: "geometry_msgs/WrenchStamped",
    TENSION: "sensor_msgs/JointState",
    WINCH: "sensor_msgs/JointState",
    PAYLOAD: "geometry_msgs/InertiaStamped",
}


def _in_frame(message: dict[str, Any], expected: str) -> None:
    """Raise ValueError if a stamped message refers to another frame than the expected one."""
    header = message.get("header")
    frame = header.get("frame_id", "") if isinstance(header, dict) else ""
    if frame not in ("", expected):
        raise ValueError(f"header.frame_id: expected {expected!r}, or none, got {shown(frame)}")


def _part(message: dict[str, Any], name: str) -> dict[str, Any]:
    if name not in message:
        such = ', such as {"x": 0, "y": 0, "z": 0, "w": 1} for upright' if name == "orientation" else ""
        raise ValueError(f"{name}: required but not given: an object{such}")
    part = message[name]
    if not isinstance(part, dict):
        raise ValueError(f"{name}: expected an object, got {shown(part)}")
    return part


def _list(message: dict[str, Any], name: str, what: str) -> list[Any]:
    values = message.get(name, [])
    if not isinstance(values, list):
        raise ValueError(f"{name}: expected a list of {what}, got {shown(values)}")
    return values


def _names(message: dict[str, Any]) -> list[str]:
    names = message.get("name", [])
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise ValueError(f"name: expected a list of names of cables, got {shown(names)}")
    return names


def _optional(value: object, name: str) -> float | None:
    missing = value is None or (isinstance(value, float) and math.isnan(value))
    return None if missing else _number(value, name)


def _numbers(part: dict[str, Any], name: str, axes: str) -> list[float]:
    return [_number(part.get(axis, 0.0), f"{name}.{axis}") for axis in axes]


def _number(value: object, name: str) -> float:
    known = isinstance(value, int | float) and not isinstance(value, bool)
    try:
        number = float(value) if known else math.nan  # type: ignore[arg-type]
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise ValueError(f"{name}: expected a finite number, got {shown(value)}")
    return number
