"""Conventions of ROS 2 nodes over Zenoh: names, type hashes, tokens, attachments, bytes; with published values."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rosbags.typesys import Stores, get_typestore

from cdpr.log import ros2
from cdpr.log.ros2 import DEFINITIONS, decode, encode, full_name
from cdpr.ui.live import rmw_zenoh
from cdpr.ui.live.parameters import PARAMETER_SERVICES
from cdpr.ui.live.received_messages import KINDS
from cdpr.ui.live.rmw_zenoh import PUBLISHER, SERVICE, SUBSCRIPTION, Node, attachment, dds_name, gid, parse_attachment
from cdpr.ui.live.type_hash import type_hash

JAZZY = get_typestore(Stores.ROS2_JAZZY)
SESSION = "aac3178e146ba6f1fc6e6a4085e77f21"  # of the examples in rmw_zenoh's docs/design.md

# Hashes of services as ROS 2 Jazzy has them: share/<package>/srv/<name>.json, "type_hashes".
SERVICE_HASHES = {
    "std_srvs/srv/Trigger": "eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f",
    "rcl_interfaces/srv/GetParameters": "bf9803d5c74cf989a5de3e0c2e99444599a627c7ff75f97b8c05b01003675cbc",
    "rcl_interfaces/srv/ListParameters": "3e6062bfbb27bfb8730d4cef2558221f51a11646d78e7bb30a1e83afac3aad9d",
    "rcl_interfaces/srv/GetParameterTypes": "da199c878688b3e530bdfe3ca8f74cb9fa0c303101e980a9e8f260e25e1c80ca",
    "rcl_interfaces/srv/SetParameters": "56eed9a67e169f9cb6c1f987bc88f868c14a8fc9f743a263bc734c154015d7e0",
    "rcl_interfaces/srv/SetParametersAtomically": "0e192ef259c07fc3c07a13191d27002222e65e00ccec653ca05e856f79285fcd",
    "rcl_interfaces/srv/DescribeParameters": "845b484d71eb0673dae682f2e3ba3c4851a65a3dcfb97bddd82c5b57e91e4cff",
}
# rosbags takes its 16 chars for another type than ROS 2 does; the hashes of services, below, hold that of ROS 2.
PARTS = [name for name in ros2._PARTS if name != "service_msgs/ServiceEventInfo"]


@pytest.mark.parametrize("kind", [*DEFINITIONS, *PARTS])
def test_hashes_of_messages_are_those_of_another_implementation(kind):
    assert type_hash(kind) == JAZZY.hash_rihs01(full_name(kind))


@pytest.mark.parametrize("kind", SERVICE_HASHES)
def test_hashes_of_services_are_those_that_ros_2_ships(kind):
    assert type_hash(kind) == f"RIHS01_{SERVICE_HASHES[kind]}"


def test_every_service_that_is_offered_has_a_hash_to_compare():
    assert {*PARAMETER_SERVICES, "std_srvs/srv/Trigger"} == set(SERVICE_HASHES) == set(ros2.SERVICES)


@pytest.fixture
def string(monkeypatch):
    monkeypatch.setitem(DEFINITIONS, "std_msgs/String", "string data")
    return "std_msgs/String"


def test_tokens_are_those_of_the_design_document(string):
    listener = Node(2, SESSION, "listener")
    assert listener.token() == f"@ros2_lv/2/{SESSION}/0/0/NN/%/%/listener"
    said = listener.endpoint(10, SUBSCRIPTION, "/chatter", string)
    kind = "std_msgs::msg::dds_::String_"
    hashed = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
    assert said == f"@ros2_lv/2/{SESSION}/0/10/MS/%/%/listener/%chatter/{kind}/{hashed}/::,10:,:,:,,"
    assert listener.key("/chatter", string) == f"2/chatter/{kind}/{hashed}"


def test_tokens_of_services_name_the_services_type():
    token = Node(0, SESSION, "cdpr").endpoint(3, SERVICE, "/cdpr/pause", "std_srvs/srv/Trigger")
    hashed = type_hash("std_srvs/srv/Trigger")
    kind = "std_srvs::srv::dds_::Trigger_"
    assert token == f"@ros2_lv/0/{SESSION}/0/3/SS/%/%/cdpr/%cdpr%pause/{kind}/{hashed}/::,10:,:,:,,"


def test_names_of_nested_topics_keep_their_slashes_in_keys_only():
    node = Node(7, SESSION, "cdpr")
    assert node.key("/cdpr/platform/pose", "geometry_msgs/PoseStamped").startswith(
        "7/cdpr/platform/pose/geometry_msgs::msg::dds_::PoseStamped_/RIHS01_"
    )
    token = node.endpoint(1, PUBLISHER, "/cdpr/platform/pose", "geometry_msgs/PoseStamped")
    assert "/MP/%/%/cdpr/%cdpr%platform%pose/" in token
    assert dds_name("tf2_msgs/TFMessage") == "tf2_msgs::msg::dds_::TFMessage_"


def test_an_attachment_is_33_bytes_little_endian():
    sender = bytes(range(16))
    data = attachment(5, 1_700_000_000_000_000_001, sender)
    assert data == struct.pack("<q", 5) + struct.pack("<q", 1_700_000_000_000_000_001) + b"\x10" + sender
    assert parse_attachment(data) == (5, 1_700_000_000_000_000_001, sender)


@pytest.mark.parametrize(
    "data", [b"", b"\0" * 33, attachment(1, 2, bytes(16))[:-1], attachment(1, 2, bytes(16)) + b"\0"]
)
def test_invalid_attachments_are_reported(data):
    with pytest.raises(ValueError, match="expected an attachment of 33 bytes"):
        parse_attachment(data)


def test_the_identifier_is_xxh3_of_the_token_lowest_byte_first():
    # XXH3's specification gives this one of nothing at all: 99aa06d3014798d86001c324468d497f.
    assert gid("") == bytes.fromhex("99aa06d3014798d86001c324468d497f")[::-1]
    assert gid("a") != gid("b")
    assert len(gid("a")) == rmw_zenoh.GID


numbers = st.floats(allow_nan=False)
pose = st.fixed_dictionaries(
    {
        "position": st.fixed_dictionaries(dict.fromkeys("xyz", numbers)),
        "orientation": st.fixed_dictionaries(dict.fromkeys("xyzw", numbers)),
    }
)
stamped = {"header": {"stamp": {"sec": 3, "nanosec": 999_999_999}, "frame_id": "wörld"}}


def same(message, content):
    """Assert that a message of rosbags holds this content."""
    for name, value in content.items():
        held = getattr(message, name)
        if isinstance(value, dict):
            same(held, value)
        elif isinstance(value, list):
            assert list(held) == value
        else:
            assert held == value


@given(pose)
def test_poses_travel_both_ways(pose):
    content = {**stamped, "pose": pose}
    data, _ = encode("geometry_msgs/PoseStamped", content)
    message = JAZZY.deserialize_cdr(data, "geometry_msgs/msg/PoseStamped")
    same(message, content)
    assert decode("geometry_msgs/PoseStamped", bytes(JAZZY.serialize_cdr(message, message.__msgtype__))) == content


@pytest.mark.slow
@given(
    st.lists(st.text(st.characters(exclude_characters="\0", codec="utf-8"), max_size=5), max_size=4),
    st.lists(numbers, max_size=9),
)
def test_joint_states_travel_both_ways_in_both_orders_of_bytes(names, effort):
    content = {**stamped, "name": names, "position": [], "velocity": [], "effort": effort}
    kind = "sensor_msgs/msg/JointState"
    message = JAZZY.deserialize_cdr(encode("sensor_msgs/JointState", content)[0], kind)
    same(message, content)
    for little in (True, False):
        data = bytes(JAZZY.serialize_cdr(message, kind, little_endian=little))
        assert decode("sensor_msgs/JointState", data) == content


def test_parameters_travel_as_rosbags_writes_them():
    types = JAZZY.types
    value = types["rcl_interfaces/msg/ParameterValue"](
        3, True, -5, 2.5, "text", np.array([1], np.uint8), np.array([True]), np.array([7]), np.array([0.5]), ["a", "b"]
    )
    one = types["rcl_interfaces/msg/Parameter"]("controller.kp", value)
    data = bytes(JAZZY.serialize_cdr(one, one.__msgtype__))
    content = decode("rcl_interfaces/Parameter", data)
    assert content["name"] == "controller.kp"
    assert content["value"]["double_value"] == 2.5
    assert content["value"]["string_array_value"] == ["a", "b"]
    assert encode("rcl_interfaces/Parameter", content)[0] == data


def test_arrays_of_one_size_have_no_count():
    content = {"event_type": 1, "stamp": {"sec": 1, "nanosec": 2}, "client_gid": list(range(16)), "sequence_number": -1}
    kind = "service_msgs/ServiceEventInfo"
    data = encode(kind, content)[0]
    same(JAZZY.deserialize_cdr(data, full_name(kind)), content)
    assert decode(kind, data) == content
    assert len(data) == len(encode(kind, {})[0])


BROKEN = {
    "nothing": b"",
    "no header": b"\0\1",
    "other encoding": b"\0\3\0\0" + bytes(100),
    "cut": encode("sensor_msgs/JointState", {"name": ["a"], "effort": [1.0]})[0][:-1],
    "more than there is": b"\0\1\0\0" + bytes(8) + struct.pack("<I", 1) + b"\0" + bytes(3) + b"\xff\xff\xff\xff",
    "a text without end": b"\0\1\0\0" + bytes(8) + b"\xff\xff\xff\x7f",
    "no UTF-8": b"\0\1\0\0" + bytes(8) + struct.pack("<I", 2) + b"\xff\0" + bytes(40),
}


@pytest.mark.parametrize("name", BROKEN)
def test_broken_bytes_are_reported(name):
    with pytest.raises(ValueError, match=r"expected plain CDR|it ends too early|a string is not UTF-8"):
        decode("sensor_msgs/JointState", BROKEN[name])


@given(st.binary(max_size=80), st.sampled_from([*KINDS.values(), "rcl_interfaces/srv/SetParameters_Request"]))
def test_any_bytes_are_a_message_or_an_error(data, kind):
    try:
        content = decode(kind, b"\0\1\0\0" + data)
    except ValueError:
        return
    assert isinstance(content, dict)


def test_too_many_items_of_a_sequence_are_reported():
    data = bytearray(encode("rcl_interfaces/ParameterDescriptor", {"name": "a"})[0])
    data[-8:-4] = struct.pack("<I", 2)
    with pytest.raises(ValueError, match=r"2 of|too early"):
        decode("rcl_interfaces/ParameterDescriptor", bytes(data) + bytes(100))
