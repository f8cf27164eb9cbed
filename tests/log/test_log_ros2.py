"""Our message definitions and bytes against rosbags and mcap_ros2, which were written by others."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from cdpr.log.ros2 import DEFINITIONS, encode, fields, schema_text

STORES = {store: get_typestore(store) for store in (Stores.ROS2_HUMBLE, Stores.ROS2_JAZZY)}
NUMPY = {"bool": np.bool_, "uint8": np.uint8, "int32": np.int32, "uint32": np.uint32}
NUMPY |= {"float32": np.float32, "float64": np.float64}


def ros_name(kind: str) -> str:
    return kind.replace("/", "/msg/")


def kind_of(node: Any) -> str:
    form, detail = node
    if form == Nodetype.BASE:
        return detail[0]
    if form == Nodetype.NAME:
        return detail.replace("/msg/", "/")
    assert form in (Nodetype.SEQUENCE, Nodetype.ARRAY)
    return kind_of(detail[0]) + (f"[{detail[1]}]" if form == Nodetype.ARRAY else "[]")


def element(kind: str) -> str:
    """Return the type of the elements of "T[]" and "T[9]", "" for others."""
    return kind.partition("[")[0] if kind.endswith("]") else ""


@pytest.mark.parametrize("store", STORES)
@pytest.mark.parametrize("kind", DEFINITIONS)
def test_fields_are_those_of_ros(store: Stores, kind: str) -> None:
    if kind == "sensor_msgs/Range" and store == Stores.ROS2_HUMBLE:
        pytest.skip("it has no variance in Humble")
    _, theirs = STORES[store].fielddefs[ros_name(kind)]
    assert list(fields(kind)) == [(kind_of(node), name) for name, node in theirs]


@pytest.mark.parametrize("kind", DEFINITIONS)
def test_schema_text_is_complete(kind: str) -> None:
    parsed = get_types_from_msg(schema_text(kind), ros_name(kind))
    store = STORES[Stores.ROS2_JAZZY]
    assert parsed[ros_name(kind)][1] == store.fielddefs[ros_name(kind)][1]
    for name, (_, definition) in parsed.items():
        assert definition == store.fielddefs[name][1]
    needed = set()
    queue = [kind]
    while queue:
        needed.add(queue.pop())
        for name in list(needed):
            queue += [k for k, _ in fields(name) if k in DEFINITIONS and k not in needed]
            queue += [k[:-2] for k, _ in fields(name) if k[:-2] in DEFINITIONS and k[:-2] not in needed]
    assert set(parsed) == {ros_name(name) for name in needed}


def random_value(kind: str, rng: np.random.Generator) -> Any:
    if part := element(kind):
        size = kind[len(part) + 1 : -1]
        return [random_value(part, rng) for _ in range(int(size) if size else rng.integers(0, 4))]
    if kind == "string":
        return "".join(rng.choice(list("abcäß→ ")) for _ in range(rng.integers(0, 6)))
    if kind in NUMPY:
        return {"bool": bool(rng.integers(2)), "float32": 0.375, "float64": float(rng.standard_normal())}.get(
            kind, int(rng.integers(0, 200))
        )
    return {name: random_value(part, rng) for part, name in fields(kind)}


def as_rosbags(kind: str, value: Any) -> Any:
    if element(kind):
        items = [as_rosbags(element(kind), item) for item in value]
        return np.array(items, NUMPY[element(kind)]) if element(kind) in NUMPY else items
    if kind in DEFINITIONS:
        make = STORES[Stores.ROS2_JAZZY].types[ros_name(kind)]
        return make(**{name: as_rosbags(part, value[name]) for part, name in fields(kind)})
    return value


def plain(kind: str, message: Any) -> Any:
    if element(kind):
        return [plain(element(kind), item) for item in message]
    if kind in DEFINITIONS:
        return {name: plain(part, getattr(message, name)) for part, name in fields(kind)}
    return message


@pytest.mark.parametrize("kind", DEFINITIONS)
@pytest.mark.parametrize("seed", range(12))
@pytest.mark.usual("0-*", "5-*", "11-*")
def test_bytes_are_those_of_rosbags_and_decode_in_mcap_ros2(kind: str, seed: int) -> None:
    value = random_value(kind, np.random.default_rng(seed))
    data, _ = encode(kind, value)
    theirs = STORES[Stores.ROS2_JAZZY].serialize_cdr(as_rosbags(kind, value), ros_name(kind))
    assert data == bytes(theirs)
    schema = Schema(1, schema_text(kind).encode(), "ros2msg", ros_name(kind))
    decode = DecoderFactory().decoder_for("cdr", schema)
    assert decode is not None
    assert plain(kind, decode(data)) == value


def test_positions_point_to_the_numbers() -> None:
    value = {"name": ["a", "bcdef"], "position": [1.5, 2.5], "velocity": [], "effort": [3.5]}
    data, places = encode("sensor_msgs/JointState", value)
    assert np.frombuffer(data, "<f8", 2, places["position"]).tolist() == [1.5, 2.5]
    assert np.frombuffer(data, "<f8", 1, places["effort.0"]).tolist() == [3.5]
    assert places["header.stamp"] == places["header"] == 4
    data, places = encode("visualization_msgs/MarkerArray", {"markers": [{}, {"pose": {"position": {"x": 7.0}}}]})
    assert np.frombuffer(data, "<f8", 1, places["markers.1.pose"]) == [7.0]


def test_left_out_fields_are_zero() -> None:
    assert encode("geometry_msgs/Pose", {})[0] == b"\0\1\0\0" + bytes(56)
