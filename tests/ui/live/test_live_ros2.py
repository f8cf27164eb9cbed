"""Running simulation as a ROS 2 node over Zenoh, with a test node: published data, messages and answers."""

from __future__ import annotations

import subprocess
import sys
import time
from functools import partial

import numpy as np
import pytest
from live_client import FILE, ROOT, running

import cdpr
from cdpr.log.reader import load_run

pytest.importorskip("zenoh")
from live_node import TYPES, WAITS, free_port, node, router, serialize

from cdpr.ui.live.ros2 import Ros2

POSE, TARGET, WRENCH, TENSION = "/cdpr/platform/pose", "/cdpr/target_pose", "/cdpr/wrench", "/cdpr/tension"
STAMPED_POSE, STAMPED_WRENCH = "geometry_msgs/msg/PoseStamped", "geometry_msgs/msg/WrenchStamped"
JOINTS, CLOCK, TF = "sensor_msgs/msg/JointState", "rosgraph_msgs/msg/Clock", "tf2_msgs/msg/TFMessage"
M = 8
CAMERA = ROOT / "scenarios" / "camera_robot.yaml"
WINCHES = ROOT / "scenarios" / "winch.yaml"


def made(kind, *values):
    return TYPES.types[kind](*values)


def header(frame="world"):
    return made("std_msgs/msg/Header", made("builtin_interfaces/msg/Time", 0, 0), frame)


def pose(x, y, z, frame="world", w=1.0):
    point, turn = made("geometry_msgs/msg/Point", x, y, z), made("geometry_msgs/msg/Quaternion", 0.0, 0.0, 0.0, w)
    return serialize(STAMPED_POSE, header=header(frame), pose=made("geometry_msgs/msg/Pose", point, turn))


def wrench(x=0.0, frame=""):
    force, torque = made("geometry_msgs/msg/Vector3", x, 0.0, 0.0), made("geometry_msgs/msg/Vector3", 0.0, 0.0, 0.0)
    return serialize(STAMPED_WRENCH, header=header(frame), wrench=made("geometry_msgs/msg/Wrench", force, torque))


def tension(effort, names=()):
    none = np.zeros(0)
    values = {"position": none, "velocity": none, "effort": np.array(effort, float)}
    return serialize(JOINTS, header=header(""), name=list(names), **values)


@pytest.fixture
def port():
    chosen = free_port()
    with router(chosen):
        yield chosen


def seen_of(port, **values):
    return running(partial(Ros2, port=port), held=True, **values)


def test_shown_values_equal_recorded_values(port):
    with seen_of(port, duration=0.5) as (link, found, _), node(port) as seen:
        assert link.met
        seen.subscribe(POSE, STAMPED_POSE)
        seen.subscribe("/tf", TF)
        seen.subscribe("/clock", CLOCK)
        assert seen.trigger("resume") == (True, "")
        seen.more(POSE, 10)
        seen.more("/tf", 1)
    run = found["run"]
    assert run.status == "finished"
    for message, _ in seen.messages[POSE]:
        sample = round(message.header.stamp.sec * 1e3 + message.header.stamp.nanosec / 1e6)
        at = message.pose.position
        assert message.header.frame_id == "world"
        assert [at.x, at.y, at.z] == run.position[sample].tolist()
    for message, _ in seen.messages["/tf"]:
        sample = round(message.transforms[0].header.stamp.nanosec / 1e6)
        moved = message.transforms[0].transform.translation
        assert [moved.x, moved.y, moved.z] == run.position[sample].tolist()


@pytest.mark.slow
def test_messages_carry_who_sent_them_and_are_numbered(port):
    with seen_of(port, duration=0.5) as (_, _, _), node(port) as seen:
        seen.subscribe(POSE, STAMPED_POSE)
        seen.subscribe("/clock", CLOCK)
        seen.trigger("resume")
        seen.more(POSE, 5)
        seen.more("/clock", 5)
    senders = set()
    for topic in (POSE, "/clock"):
        attachments = [data for _, data in seen.messages[topic]]
        first = int.from_bytes(attachments[0][:8], "little")
        numbers = [int.from_bytes(data[:8], "little") for data in attachments]
        assert numbers == list(range(first, first + len(numbers)))
        (sender,) = {data[16:] for data in attachments}
        assert len(sender) == 17
        senders.add(sender)
    assert len(senders) == 2


@pytest.mark.slow
def test_all_that_the_node_has_is_declared(port):
    with seen_of(port, duration=0.2) as (_, _, _), node(port) as seen:
        seen.trigger("step")
        tokens = seen.tokens()
        seen.trigger("resume")
    (session,) = {token[2] for token in tokens}
    assert all(token[:4] == ["@ros2_lv", "0", session, "0"] and token[6:9] == ["%", "%", "cdpr"] for token in tokens)
    numbers = [token[4] for token in tokens]
    assert len(set(numbers)) == len(numbers)
    held = {}
    for token in tokens:
        held.setdefault(token[5], set()).add(token[9] if len(token) > 9 else "")
        if token[5] in ("MP", "MS"):
            kind = token[10].replace("::dds_::", "::").replace("::", "/").removesuffix("_")
            assert token[11] == TYPES.hash_rihs01(kind)
    assert held["NN"] == {""}
    assert held["MS"] == {"%cdpr%target_pose", "%cdpr%wrench", "%cdpr%tension", "%cdpr%winch_command", "%cdpr%payload"}
    assert {"%clock", "%tf", "%cdpr%platform%pose", "%cdpr%cable_states", "%cdpr%markers"} <= held["MP"]
    triggers = {f"%cdpr%{name}" for name in ("pause", "resume", "step", "reset", "stop")}
    asked = ("describe_parameters", "get_parameters", "get_parameter_types", "list_parameters", "set_parameters")
    assert held["SS"] == triggers | {f"%cdpr%{name}" for name in (*asked, "set_parameters_atomically")}


def test_requests_are_events(port):
    with seen_of(port, duration=1.5) as (_, found, said), node(port) as seen:
        seen.subscribe("/clock", CLOCK)
        seen.trigger("resume")
        seen.publish(TARGET, STAMPED_POSE, pose(0.2, 0.1, 1.3))
        seen.publish(WRENCH, STAMPED_WRENCH, wrench(10.0))
        assert seen.ask("get_parameters", names=["speed"]).values[0].double_value == 1.0
        seen.more("/clock", 10)  # a push that ends with the slice in which it began is none
        seen.publish(WRENCH, STAMPED_WRENCH, wrench())
    texts = [event.text for event in found["run"].events]
    assert said == []
    assert any("[10, 0, 0] N" in text for text in texts), texts
    assert np.abs(found["run"].desired_position[-1] - [0.2, 0.1, 1.3]).max() < 0.5  # 2 s take it there


@pytest.mark.slow
def test_tensions_are_those_of_the_cables_that_are_named(port):
    with seen_of(port, duration=1.5) as (_, found, said), node(port) as seen:
        seen.subscribe("/cdpr/cable_states", JOINTS)
        seen.subscribe("/clock", CLOCK)
        seen.trigger("step")
        seen.more("/cdpr/cable_states", 1)
        names = seen.messages["/cdpr/cable_states"][0][0].name
        wanted = np.arange(400.0, 400.0 + M)
        seen.publish(TENSION, JOINTS, tension(wanted[::-1], names[::-1]))
        seen.trigger("resume")
        seen.more("/clock", 12)
        seen.publish(TENSION, JOINTS, tension([]))
    assert said == []
    given = (found["run"].tension == wanted).all(axis=1)
    assert 50 < given.sum() < 1490
    assert not given[-1]


@pytest.mark.slow
def test_commands_of_winches_have_nan_for_no_value(port):
    with seen_of(port, duration=0.6, file=CAMERA) as (_, found, said), node(port) as seen:
        seen.subscribe("/clock", CLOCK)
        seen.trigger("step")
        order = ["cable_4", "cable_2"]
        values = {"position": [3.3, np.nan], "velocity": [np.nan, 0.02], "effort": []}
        values = {name: np.array(each, float) for name, each in values.items()}
        seen.publish("/cdpr/winch_command", JOINTS, serialize(JOINTS, header=header(""), name=order, **values))
        seen.trigger("resume")
        seen.more("/clock", 12)
    assert said == []
    command = found["run"]["winch_command"]
    given = command[:, 3] == 3.3
    assert 20 < given.sum() < 301
    assert given[-1]
    np.testing.assert_allclose(np.diff(command[given, 1])[:-1], 0.02 * 0.002, rtol=0, atol=1e-12)
    assert np.array_equal(command[given, 0], np.full(given.sum(), command[given, 0][0]))


def heard(said, text):
    deadline = time.monotonic() + WAITS
    while not any(text in each for each in said):
        assert time.monotonic() < deadline, (text, said)
        time.sleep(0.001)


BAD = {
    "broken": (WRENCH, STAMPED_WRENCH, b"\0\1\0\0\xff", "/cdpr/wrench: it ends too early"),
    "JSON": (WRENCH, STAMPED_WRENCH, b"{}", "/cdpr/wrench: expected plain CDR"),
    "NaN": (WRENCH, STAMPED_WRENCH, wrench(float("nan")), "force.x: expected a finite number"),
    "other frame": (WRENCH, STAMPED_WRENCH, wrench(1.0, "platform"), "header.frame_id: expected 'world', or none"),
    "no turn": (TARGET, STAMPED_POSE, pose(0.0, 0.0, 1.0, w=0.0), "expected a quaternion of norm 1"),
    "far": (TARGET, STAMPED_POSE, pose(1e9, 0.0, 0.0), "target: "),
    "too few": (TENSION, JOINTS, tension([1.0]), "tension: "),
    "other cables": (
        TENSION,
        JOINTS,
        tension([400.0] * M, [f"x{k}" for k in range(M)]),
        "tension: expected one for each of ",
    ),
    "long": (WRENCH, STAMPED_WRENCH, b"\0\1\0\0" + bytes(70000), "it is longer than 65536 bytes"),
}


@pytest.mark.slow
def test_invalid_input_is_reported_without_effect(port):
    with seen_of(port, duration=0.5) as (_, found, said), node(port) as seen:
        seen.trigger("pause")  # when that is answered, all that it has is known
        for topic, kind, data, text in BAD.values():
            seen.publish(topic, kind, data)
            heard(said, text)  # of what comes together the newest is done
        pause = "cdpr/pause/std_srvs::srv::dds_::Trigger_/*"
        with pytest.raises(ValueError, match="expected an attachment of 33 bytes"):
            seen.call(pause, attachment=b"x")
        with pytest.raises(ValueError, match="expected plain CDR"):
            seen.call(pause, b"")
        with pytest.raises(ValueError, match="it is longer than 65536 bytes"):
            seen.ask("get_parameters", names=["a" * 40] * 2000)
        seen.trigger("resume")
    plain = cdpr.simulate(cdpr.load_scenario(FILE, overrides={"simulation.duration": 0.5}))
    assert np.array_equal(found["run"].rows, plain.rows)


@pytest.mark.slow
def test_it_can_be_stepped_and_begun_anew(port):
    with seen_of(port, duration=0.3) as (link, found, said), node(port) as seen:
        seen.subscribe("/clock", CLOCK)
        stood = lambda ms: any(one.clock.nanosec == ms * 10**6 for one, _ in seen.messages["/clock"])  # noqa: E731
        assert seen.trigger("step") == (True, "")
        assert seen.trigger("step") == (True, "")
        seen.until(lambda: stood(1))  # samples begin at 0
        assert seen.trigger("reset") == (True, "")
        seen.messages["/clock"].clear()
        assert seen.trigger("step") == (True, "")
        seen.until(lambda: stood(0))
        assert seen.trigger("resume") == (True, "")
    assert found["run"].status == "finished"
    assert said == []
    assert not link.parameters["paused"]


@pytest.mark.slow
def test_a_log_is_not_begun_anew(port, tmp_path):
    with seen_of(port, duration=0.2, out=str(tmp_path / "run")) as (_, found, _), node(port) as seen:
        done, text = seen.trigger("reset")
        seen.trigger("resume")
    assert not done
    assert "not possible with a log on disk" in text
    assert found["run"].status == "finished"


def parameters(*pairs):
    """rcl_interfaces/msg/Parameter of names and values."""
    kinds = {bool: 1, int: 2, float: 3, str: 4}
    found = []
    for name, value in pairs:
        held = {kinds[type(value)]: value}
        plain = (held.get(1, False), held.get(2, 0), held.get(3, 0.0), held.get(4, ""))
        none = (np.zeros(0, kind) for kind in (np.uint8, bool, np.int64, float))
        value = made("rcl_interfaces/msg/ParameterValue", kinds[type(value)], *plain, *none, [])
        found.append(made("rcl_interfaces/msg/Parameter", name, value))
    return found


def test_parameters_are_listed_described_and_read(port):
    with seen_of(port, duration=0.2) as (link, _, _), node(port) as seen:
        listed = seen.ask("list_parameters", prefixes=[], depth=0).result
        assert listed.names == list(link.parameters)
        assert listed.prefixes == ["controller"]
        assert seen.ask("list_parameters", prefixes=["controller"], depth=1).result.names == listed.names[2:]
        assert seen.ask("list_parameters", prefixes=[], depth=1).result.names == ["paused", "speed"]
        assert seen.ask("list_parameters", prefixes=["contr"], depth=0).result.names == []
        wanted = ["controller.kp", "paused", "mass"]
        kp, paused, mass = seen.ask("get_parameters", names=wanted).values
        assert (kp.type, kp.double_value) == (3, link.parameters["controller.kp"])
        assert (paused.type, paused.bool_value, mass.type) == (1, True, 0)  # it is held
        assert list(seen.ask("get_parameter_types", names=wanted).types) == [3, 1, 0]
        described = seen.ask("describe_parameters", names=wanted).descriptors
        assert [(one.name, one.type) for one in described] == [("controller.kp", 3), ("paused", 1), ("mass", 0)]
        seen.trigger("resume")


@pytest.mark.slow
def test_parameters_are_set_and_what_is_wrong_is_refused(port):
    with seen_of(port, duration=0.5) as (_, found, said), node(port) as seen:
        pairs = ("controller.kp", 150.0), ("controller.kd", -1.0), ("mass", 1.0), ("speed", "fast"), ("paused", 1)
        results = seen.ask("set_parameters", parameters=parameters(*pairs)).results
        assert [one.successful for one in results] == [True, False, False, False, False]
        assert "must be at least 0" in results[1].reason
        assert results[2].reason.startswith("mass: unknown parameter; allowed: paused, speed, ")
        assert results[3].reason.startswith("speed: expected a number")
        assert results[4].reason.startswith("paused: expected true or false")
        assert len(said) == 4
        assert seen.ask("get_parameters", names=["controller.kp"]).values[0].double_value == 150.0
        assert seen.ask("set_parameters", parameters=parameters(("paused", False))).results[0].successful
    assert any("controller.kp becomes 150" in event.text for event in found["run"].events)


@pytest.mark.slow
def test_parameters_are_set_all_or_none(port):
    with seen_of(port, duration=0.5) as (link, _, _), node(port) as seen:
        kp = link.parameters["controller.kp"]
        refused = parameters(("controller.kp", 10.0), ("controller.kp", 20.0), ("controller.kd", -1.0))
        answer = seen.ask("set_parameters_atomically", parameters=refused).result
        assert not answer.successful
        assert "must be at least 0" in answer.reason
        assert seen.ask("get_parameters", names=["controller.kp"]).values[0].double_value == kp
        taken = parameters(("controller.kp", 10.0), ("controller.kd", 5.0))
        assert seen.ask("set_parameters_atomically", parameters=taken).result.successful
        assert link.parameters["controller.kd"] == 5.0
        seen.trigger("resume")


@pytest.mark.slow
def test_clients_do_not_receive_their_own_messages(port):
    # Robots with winches show commands, too: on a topic other than that of received tensions.
    with seen_of(port, duration=0.1, file=WINCHES, speed=10.0) as (_, found, said), node(port) as seen:
        seen.subscribe("/cdpr/cable_commands", JOINTS)
        seen.trigger("step")
        seen.more("/cdpr/cable_commands", 1)
        tokens = seen.tokens()
        seen.trigger("resume")
    shown, heard = ({token[9] for token in tokens if token[5] == entity} for entity in ("MP", "MS"))
    assert not shown & heard
    assert said == []
    assert found["run"].events == ()


@pytest.mark.slow
def test_another_domain_is_another_world(port, monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", "42")
    with seen_of(port, duration=0.1) as (link, _, _), node(port, domain=42) as seen, node(port) as other:
        assert "domain 42" in link.where
        assert seen.trigger("resume") == (True, "")
        assert other.tokens() == []


@pytest.mark.slow
def test_from_the_command_line(tmp_path, port):
    words = ["run", str(FILE), "--live", "ros2", "--live-port", str(port), "--live-speed", "10", "--no-report"]
    words += ["--set", "simulation.duration=0.5", "--out", str(tmp_path / "run")]
    done = subprocess.run([sys.executable, "-m", "cdpr", *words], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert f"live: ROS 2 node /cdpr (experimental), domain 0, Zenoh router at 127.0.0.1:{port}\n" in done.stderr
    assert len(load_run(tmp_path / "run").rows) == 501
