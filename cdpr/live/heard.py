"""What clients publish, as requests: JSON of standard messages, checked before anything is done."""

from __future__ import annotations

import json
import math
from typing import Any

from cdpr.errors import CdprError
from cdpr.live.drive import Request
from cdpr.problems import shown

TARGET, WRENCH, COMMANDS = "/cdpr/target_pose", "/cdpr/wrench", "/cdpr/cable_commands"
MOST = 65536  # bytes of a message


def request_of(topic: str, encoding: str, data: bytes) -> Request:
    """Return what a message asks for. Raises CdprError, naming the topic, where it makes no sense."""
    if topic not in KNOWN:
        raise CdprError(f"{topic}: nobody listens there; {', '.join(KNOWN)} are heard")
    if encoding != "json":
        raise CdprError(f"{topic}: messages in JSON are heard, not in {shown(encoding)}")
    try:
        if len(data) > MOST:
            raise ValueError(f"it is longer than {MOST} bytes")
        message = json.loads(data)
        if not isinstance(message, dict):
            raise ValueError("an object is expected")
        return KNOWN[topic](message)
    except (ValueError, RecursionError) as error:
        raise CdprError(f"{topic}: {error}") from None


def _target(message: dict[str, Any]) -> Request:
    pose = _part(message, "pose")
    x, y, z, w = _numbers(_part(pose, "orientation"), "orientation", "xyzw")
    length = math.hypot(x, y, z, w)
    if abs(length - 1.0) > 1e-3:
        raise ValueError(f"orientation: a quaternion of length 1 is expected, this one has {length:.6g}")
    values: dict[str, Any] = {"position": _numbers(_part(pose, "position"), "position", "xyz")}
    values["orientation"] = [part / length for part in (w, x, y, z)]
    if "duration" in message:
        values["duration"] = _number(message["duration"], "duration")
    return Request("target", values)


def _wrench(message: dict[str, Any]) -> Request:
    wrench = _part(message, "wrench")
    force, torque = (_numbers(_part(wrench, name), name, "xyz") for name in ("force", "torque"))
    return Request("wrench", {"force": force, "moment": torque})


def _commands(message: dict[str, Any]) -> Request:
    effort = message.get("effort")
    if not isinstance(effort, list):
        raise ValueError(f"effort: a list of tensions (N) is expected, got {shown(effort)}")
    return Request("tension", {"tension": [_number(value, "effort") for value in effort]})


KNOWN = {TARGET: _target, WRENCH: _wrench, COMMANDS: _commands}
KINDS = {
    TARGET: "geometry_msgs/PoseStamped",
    WRENCH: "geometry_msgs/WrenchStamped",
    COMMANDS: "sensor_msgs/JointState",
}


def _part(message: dict[str, Any], name: str) -> dict[str, Any]:
    part = message.get(name)
    if not isinstance(part, dict):
        raise ValueError(f"{name}: an object is expected, got {shown(part)}")
    return part


def _numbers(part: dict[str, Any], name: str, axes: str) -> list[float]:
    return [_number(part.get(axis, 0.0), f"{name}.{axis}") for axis in axes]


def _number(value: object, name: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(f"{name}: a finite number is expected, got {shown(value)}")
    return float(value)
