"""Parameter services of a ROS 2 node for a live link: `ros2 param list`, `get`, `describe` and `set`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from cdpr.ui.live.sender import Sender

Content = dict[str, Any]

# rcl_interfaces/msg/ParameterType, and the field of a ParameterValue with the value.
NOT_SET, BOOL, INTEGER, DOUBLE = 0, 1, 2, 3
FIELDS = {BOOL: "bool_value", INTEGER: "integer_value", DOUBLE: "double_value"}


def _kind(link: Sender, name: str) -> int:
    value = link.parameters.get(name)
    return NOT_SET if value is None else BOOL if isinstance(value, bool) else DOUBLE


def _value(link: Sender, name: str) -> Content:
    kind = _kind(link, name)
    return {"type": kind, FIELDS[kind]: link.parameters[name]} if kind else {"type": NOT_SET}


def _describe(link: Sender, request: Content) -> Content:
    return {"descriptors": [{"name": name, "type": _kind(link, name)} for name in request["names"]]}


def _get(link: Sender, request: Content) -> Content:
    return {"values": [_value(link, name) for name in request["names"]]}


def _types(link: Sender, request: Content) -> Content:
    return {"types": [_kind(link, name) for name in request["names"]]}


def _list(link: Sender, request: Content) -> Content:
    """List names that start with one of the prefixes, if any, and have at most `depth` levels below it, if not 0."""
    prefixes, depth = request["prefixes"], request["depth"]
    names, found = [], set()
    for name in link.parameters:
        for prefix in prefixes or [""]:
            rest = name.removeprefix(f"{prefix}.") if prefix else name
            inside = not prefix or name == prefix or name.startswith(f"{prefix}.")
            if inside and (depth == 0 or rest.count(".") < depth):
                names.append(name)
                found.add(name.rpartition(".")[0])
                break
    return {"result": {"names": names, "prefixes": sorted(found - {""})}}


def _given(one: Content) -> tuple[str, Any]:
    """Return the name and the value of a parameter to set; None represents an unsupported type."""
    field = FIELDS.get(one["value"]["type"])
    return one["name"], one["value"][field] if field else None


def _result(reason: str) -> Content:
    return {"successful": not reason, "reason": reason}


def _set(link: Sender, request: Content) -> Content:
    return {"results": [_result(link.set(*_given(one))) for one in request["parameters"]]}


def _set_all(link: Sender, request: Content) -> Content:
    """Set all parameters, or none if one is refused."""
    before: list[tuple[str, Any]] = []
    for name, value in map(_given, request["parameters"]):
        held = link.parameters.get(name)
        reason = link.set(name, value)
        if reason:
            for done in reversed(before):
                link.set(*done)
            return {"result": _result(reason)}
        before.append((name, held))
    return {"result": _result("")}


PARAMETER_SERVICES: dict[str, Callable[[Sender, Content], Content]] = {
    "rcl_interfaces/srv/DescribeParameters": _describe,
    "rcl_interfaces/srv/GetParameters": _get,
    "rcl_interfaces/srv/GetParameterTypes": _types,
    "rcl_interfaces/srv/ListParameters": _list,
    "rcl_interfaces/srv/SetParameters": _set,
    "rcl_interfaces/srv/SetParametersAtomically": _set_all,
}
