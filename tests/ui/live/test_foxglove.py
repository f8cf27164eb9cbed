"""Running simulation over Foxglove's WebSocket: shown data equals logged data, requests are checked."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import threading
import time
from contextlib import closing, suppress
from functools import partial

import live_client
import numpy as np
import pytest
from command_line import cdpr_here
from live_client import FILE, ROOT, RUN_TIMEOUT, client
from mcap.reader import make_reader
from rosbags.typesys import Stores, get_typestore
from websockets.exceptions import ConnectionClosed

import cdpr
from cdpr.base.errors import CdprError
from cdpr.log.reader import load_run
from cdpr.ui.live import messages
from cdpr.ui.live.received_messages import TARGET, TENSION, WINCH, WRENCH, request_of

foxglove = pytest.importorskip("cdpr.ui.live.foxglove")

POSE = "/cdpr/platform/pose"
LAST = "/cdpr/desired_path"  # of the topics
TYPES = get_typestore(Stores.ROS2_HUMBLE)
UPRIGHT = {"w": 1.0}


def running(*words, **values):
    return live_client.running(partial(foxglove.Foxglove, port=0), *words, **values)


def test_shown_values_equal_recorded_values():
    with running(0.5, held=True) as (link, found, _), client(link) as seen:
        seen.subscribe(POSE, "/tf", "/clock")
        assert seen.call("/cdpr/resume")["success"]
        seen.until(lambda: len([1 for topic, _, _ in seen.messages if topic == POSE]) > 10)
    run = found["run"]
    assert run.status == "finished"
    for topic, stamp, data in seen.messages:
        sample = round(stamp / 1e6)
        if topic == POSE:
            pose = TYPES.deserialize_cdr(data, "geometry_msgs/msg/PoseStamped").pose
            assert [pose.position.x, pose.position.y, pose.position.z] == run.position[sample].tolist()
        elif topic == "/tf":
            moved = TYPES.deserialize_cdr(data, "tf2_msgs/msg/TFMessage").transforms[0].transform.translation
            assert [moved.x, moved.y, moved.z] == run.position[sample].tolist()
    assert {topic for topic, _, _ in seen.messages} == {POSE, "/tf", "/clock"}


@pytest.mark.parametrize("name", ["caroca", "winch", "planar_point_mass"])
def test_messages_are_those_of_the_log(tmp_path, name):
    file, out = FILE.with_name(f"{name}.yaml"), tmp_path / "run"
    with running(0.1, out=str(out), held=True, file=file) as (link, found, _), client(link) as seen:
        seen.until(lambda: LAST in seen.channels.values())
        topics = set(seen.channels.values())
        seen.subscribe(*topics)
        # The first sample and the last; the path does not change, and is sent once.
        for name, topic, stamp in (("step", LAST, 0), ("resume", "/cdpr/markers", 10**8)):
            assert seen.call(f"/cdpr/{name}")["success"]
            seen.until(lambda wanted=(topic, stamp): wanted in {each[:2] for each in seen.messages})
    with (out / "log.mcap").open("rb") as file:
        log = {(channel.topic, one.log_time): one.data for _, channel, one in make_reader(file).iter_messages()}
    both = [(topic, stamp) for topic, stamp, _ in seen.messages if (topic, stamp) in log]  # scenes are logged seldom
    assert {topic for topic, _ in both} == topics
    assert all(log.get((topic, stamp), data) == data for topic, stamp, data in seen.messages)
    assert sum(topic == LAST for topic, _, _ in seen.messages) <= 2  # within a second
    assert found["run"].status == "finished"


def test_all_topics_of_a_log_are_there():
    with running(0.2) as (link, _, _), client(link) as seen:
        seen.until(lambda: "/cdpr/markers" in seen.channels.values())
        seen.until(lambda: "/cdpr/desired_path" in seen.channels.values())
        names = set(seen.channels.values())
    assert {POSE, "/tf", "/clock", "/cdpr/cable_states", "/cdpr/platform/twist"} <= names


def test_requests_are_events():
    pose = {"pose": {"position": {"x": 0.2, "y": 0.1, "z": 1.3}, "orientation": UPRIGHT}, "duration": 0.4}
    push = {"wrench": {"force": {"x": 10.0}, "torque": {"z": 1.0}}}
    with running(1.5, held=True) as (link, found, said), client(link) as seen:
        seen.subscribe("/clock")
        assert seen.call("/cdpr/resume")["success"]
        seen.publish(TARGET, pose)
        seen.publish(WRENCH, push)
        seen.set("controller.kp", 150.0)
        seen.until(lambda: seen.parameters.get("controller.kp") == 150.0)
        seen.more("/clock", 10)  # a push that ends with the slice in which it began is none
        seen.publish(WRENCH, {"wrench": {"force": {}, "torque": {}}})
    run = found["run"]
    texts = [event.text for event in run.events]
    assert said == []
    assert any("[10, 0, 0] N" in text for text in texts), texts
    assert any("controller.kp becomes 150" in text for text in texts)
    assert np.abs(run.position[-1] - [0.2, 0.1, 1.3]).max() < 1e-3


CAMERA = ROOT / "scenarios" / "camera_robot.yaml"
BAD = {
    "expected JSON": (WRENCH, b"{", "/cdpr/wrench: "),
    "a list": (WRENCH, [], "/cdpr/wrench: expected an object"),
    "no wrench": (WRENCH, {}, "/cdpr/wrench: wrench: required but not given: an object"),
    "NaN": (WRENCH, b'{"wrench": {"force": {"x": NaN}, "torque": {}}}', "force.x: expected a finite number"),
    "a text": (
        WRENCH,
        {"wrench": {"force": {"x": "1"}, "torque": {}}},
        "expected a finite number, got '1'",
    ),
    "huge": (WRENCH, {"wrench": {"force": {"x": 1e300}, "torque": {}}}, "wrench: "),
    "no quaternion": (TARGET, {"pose": {"position": {}, "orientation": {}}}, "expected a quaternion of norm 1"),
    "far": (TARGET, {"pose": {"position": {"x": 1e9}, "orientation": UPRIGHT}}, "target: "),
    "at once": (TARGET, {"pose": {"position": {}, "orientation": UPRIGHT}, "duration": 0.0}, "target: "),
    "too few": (TENSION, {"effort": [1.0]}, "tension: "),
    "no list": (WINCH, {"position": 3.0}, "/cdpr/winch_command: position: expected a list of lengths (m), got 3.0"),
    "infinite": (WINCH, b'{"velocity": [1e999]}', "/cdpr/winch_command: velocity: expected a finite number, got inf"),
    "a length": (
        WINCH,
        {"position": [3.0] * 8},
        "winch_command: cable 'cable_1': its winch takes a tension",
    ),
    "long": (WRENCH, b"[" * 70000, "it is longer than 65536 bytes"),
    "deep": (WRENCH, b"[" * 60000, "/cdpr/wrench: "),
    "misspelt": ("/cdpr/wrenhc", {}, "/cdpr/wrenhc: unknown topic; did you mean '/cdpr/wrench'"),
    "no attitude": (TARGET, {"pose": {"position": {}}}, "orientation: required but not given: an object, such as"),
    "elsewhere": ("/cmd_vel", {}, "/cmd_vel: unknown topic"),
}


def test_invalid_input_is_reported_without_effect():
    with running(0.2, held=True) as (link, found, said), client(link) as seen:
        for number, (topic, content, _) in enumerate(BAD.values()):
            seen.publish(topic, content)
            seen.until(lambda number=number: len(seen.statuses) > number)  # of what comes together the newest is done
        seen.publish(WRENCH, b"\0\1", encoding="cdr")
        seen.publish(WRENCH, b"\0\1", encoding="protobuf")
        for name, value in (("speed", -1.0), ("paused", 3), ("controller.kp", -5.0), ("mass", 1.0), ("speed", True)):
            seen.set(name, value)
        seen.until(lambda: len(seen.statuses) >= len(BAD) + 7)
    for topic, _, text in BAD.values():
        assert any(text in each for each in said), (topic, text, said)
    assert "/cdpr/wrench: messages must be JSON or CDR, not 'protobuf'" in said
    assert "/cdpr/wrench: expected plain CDR" in said
    assert "speed: expected a number from 0.001 to 1e+06, got -1.0" in said
    assert "paused: expected true or false, got 3" in said
    assert "controller.kp: set: value: must be at least 0 (1/s^2), got -5.0" in said
    assert any(each.startswith("mass: unknown parameter; allowed: paused, speed, ") for each in said)
    plain = cdpr.simulate(cdpr.load_scenario(FILE, overrides={"simulation.duration": 0.2}))
    assert np.array_equal(found["run"].rows, plain.rows)


@pytest.mark.slow
def test_tensions_from_outside_take_the_place_of_the_solvers():
    m = 8
    with running(1.5, held=True) as (link, found, said), client(link) as seen:
        seen.subscribe("/clock")
        assert seen.call("/cdpr/resume")["success"]
        seen.publish(TENSION, {"effort": [400.0] * m})
        seen.more("/clock", 12)
        seen.publish(TENSION, {"effort": []})
    assert said == []
    given = (found["run"].tension == 400.0).all(axis=1)
    assert 50 < given.sum() < 1490
    assert not given[-1]


def test_winches_move_by_messages_and_the_session_repeats_them(tmp_path):
    """A length at once, a move to a length, and a rate; null is no value."""
    with running(0.6, out=str(tmp_path / "run"), held=True, file=CAMERA) as (link, found, said), client(link) as seen:
        seen.subscribe("/clock")
        assert seen.call("/cdpr/step")["success"]
        message = {"name": ["cable_3", "cable_1"], "position": [None, 3.3], "velocity": [-0.05, 2.0]}
        seen.publish(WINCH, message)
        seen.publish(WRENCH, {"wrench": {"force": {"y": 5.0}, "torque": {}}})
        assert seen.call("/cdpr/resume")["success"]
        seen.more("/clock", 6)
        seen.publish(WINCH, {"name": ["cable_2"], "position": [3.41]})
        seen.more("/clock", 6)
        seen.publish(WINCH, {})
    assert said == []
    run = found["run"]
    command, step = run["winch_command"], 0.002
    moved = np.flatnonzero(np.diff(command[:, 2]))
    first, stop = int(moved[0]) + 1, int(np.flatnonzero(command[:, 1] == 3.41)[-1]) + 1
    np.testing.assert_allclose(np.diff(command[first - 1 : stop, 2]), -0.05 * step, rtol=0, atol=1e-12)
    assert command[stop - 1, 0] == 3.3
    assert np.array_equal(command[first:stop, 3], np.full(stop - first, command[first - 1, 3]))
    plain = cdpr.simulate(CAMERA, overrides={"simulation.duration": 0.6})
    assert np.array_equal(command[stop:], plain["winch_command"][stop:])
    assert any(event.text.startswith("the command was given from outside") for event in run.events)
    assert cdpr.simulate(tmp_path / "run" / "session.yaml").rows.tobytes() == run.rows.tobytes()


def test_it_can_be_held_stepped_and_begun_anew():
    with running(0.5, held=True) as (link, found, said), client(link) as seen:
        assert seen.call("/cdpr/pause") == {"success": True, "message": ""}
        seen.subscribe("/clock")
        stood = lambda ms: any(stamp == ms * 10**6 for _, stamp, _ in seen.messages)  # noqa: E731
        assert seen.call("/cdpr/step")["success"]
        assert seen.call("/cdpr/step")["success"]
        seen.until(lambda: stood(1))
        assert seen.call("/cdpr/reset")["success"]
        seen.messages.clear()
        assert seen.call("/cdpr/step")["success"]
        seen.until(lambda: stood(0))
        assert seen.call("/cdpr/resume")["success"]
        seen.set("speed", 5.0)
    assert found["run"].status == "finished"
    assert said == []


@pytest.mark.slow
def test_late_clients_see_the_state_of_a_paused_run():
    with running(0.2, held=True) as (link, found, _), client(link) as seen:
        assert seen.call("/cdpr/step")["success"]
        assert seen.call("/cdpr/step")["success"]
        seen.subscribe(POSE)
        seen.more(POSE)
        assert seen.messages[-1][1] == 10**6  # nanoseconds, after two steps from 0
        assert seen.call("/cdpr/resume")["success"]
    assert found["run"].status == "finished"


@pytest.mark.slow
def test_a_log_is_not_begun_anew(tmp_path):
    held = running(0.5, out=str(tmp_path / "run"), held=True)
    with held as (link, found, said), client(link) as seen:
        answer = seen.call("/cdpr/reset")
        assert seen.call("/cdpr/resume")["success"]
    assert not answer["success"]
    assert "not possible with a log on disk" in answer["message"]
    assert any("reset: not possible with a log on disk" in text for text in said)
    assert len(cdpr.simulate(cdpr.load_scenario(FILE, overrides={"simulation.duration": 0.5})).rows) == 501
    assert found["run"].status == "finished"


@pytest.mark.slow
def test_a_client_that_reads_nothing_does_not_slow_it():
    with running(1.0) as (link, found, _), client(link) as seen:
        seen.subscribe("/tf", "/cdpr/markers", POSE)
        begun = time.monotonic()  # and receives nothing more
        while "run" not in found and time.monotonic() - begun < 10.0:
            time.sleep(0.02)
        took = time.monotonic() - begun
    assert found["run"].status == "finished"
    assert took < 5.0


def test_setting_a_parameter_before_the_run_does_not_block():
    with closing(foxglove.Foxglove(port=0)) as link, client(link) as one, client(link) as other:
        for _ in range(20):
            one.set("speed", 2.0)  # no simulation has begun: each would wait for an answer
        begun = time.monotonic()
        other.say(op="getParameters", parameterNames=["speed"], id="?")
        other.until(lambda: other.parameters)
        assert time.monotonic() - begun < 1.0
        assert other.parameters == {"speed": 1.0}


@pytest.mark.slow
def test_subscribing_while_parameters_change_causes_no_deadlock():
    words = [sys.executable, str(ROOT / "tests" / "support" / "live_race.py"), "0.5"]
    path = {**os.environ, "PYTHONPATH": str(ROOT / "tests")}
    done = subprocess.run(words, capture_output=True, text=True, check=False, timeout=RUN_TIMEOUT, env=path)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 10


def test_subscribers_receive_all_parameter_changes():
    with running(0.2, held=True) as (link, _, _), client(link) as seen, client(link) as other:
        seen.say(op="subscribeParameterUpdates", parameterNames=["paused", "speed"])
        seen.say(op="getParameters", parameterNames=["speed"], id="?")
        seen.until(lambda: seen.parameters)  # its subscription is processed before the other client's request
        assert other.call("/cdpr/step")["success"]
        seen.until(lambda: seen.parameters.get("paused") is True)
        assert other.call("/cdpr/resume")["success"]
        seen.until(lambda: seen.parameters["paused"] is False)
        assert other.call("/cdpr/pause")["success"]
        seen.until(lambda: seen.parameters["paused"] is True)
        other.set("speed", 3.0)
        seen.until(lambda: seen.parameters.get("speed") == 3.0)
        assert seen.statuses == []


def test_garbled_messages_are_not_logged(caplog):
    with closing(foxglove.Foxglove(port=0)) as link, client(link) as seen:
        seen.socket.send(b"\0")
        seen.say(op="none")
        seen.say(op="getParameters", parameterNames=["speed"], id="?")
        seen.until(lambda: seen.parameters)
    assert caplog.records == []


@pytest.mark.slow
def test_a_client_that_sends_without_end_does_not_keep_it_from_ending():
    over = threading.Event()
    with client(link := foxglove.Foxglove(port=0)) as seen:
        seen.say(op="advertise", channels=[{"id": 1, "topic": WRENCH, "encoding": "json", "schemaName": "any"}])

        def send():
            with suppress(ConnectionClosed):
                while not over.wait(0.0):
                    seen.socket.send(b"\x01\x01\0\0\0{}")

        sending = threading.Thread(target=send)
        sending.start()
        time.sleep(1.0)
        begun = time.monotonic()
        closed = threading.Thread(target=link.close)
        closed.start()
        closed.join(RUN_TIMEOUT)
        over.set()
        sending.join(RUN_TIMEOUT)
        assert not closed.is_alive()
        assert time.monotonic() - begun < 0.5 * RUN_TIMEOUT


def test_without_a_client_nothing_is_encoded(monkeypatch):
    def refuse(*_):
        raise AssertionError("unknown topic")

    monkeypatch.setattr(messages.Messages, "of", refuse)
    with running(0.3) as (_, found, _):
        pass
    assert found["run"].status == "finished"


def test_a_port_that_is_taken_is_reported(tmp_path):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(
            CdprError, match=f"--live-port: cannot listen at 127.0.0.1:{port}: .*; use --live-port 0 for any free port"
        ):
            foxglove.Foxglove(port=port)


def test_no_messages_without_clients(tmp_path):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        words = ("--live", "foxglove", "--live-port", taken.getsockname()[1], "--out", tmp_path / "run")
        done = cdpr_here("run", FILE, *words, code=2)
    assert "--live-port: cannot listen" in done.stderr
    assert not (tmp_path / "run").exists()
    done = cdpr_here("run", FILE, "--live-port", 0, "--out", tmp_path / "run", code=2)
    assert "--live-port requires --live" in done.stderr
    done = cdpr_here("run", FILE, "--live", "foxglove", "--real-time", "--out", tmp_path / "run", code=2)
    assert "--real-time cannot be combined with --live" in done.stderr


@pytest.mark.slow
def test_without_websockets_the_remedy_is_reported(tmp_path):
    code = "import sys; sys.modules['websockets'] = None; from cdpr.ui.cli import main; main()"
    words = ["run", str(FILE), "--live", "foxglove", "--out", str(tmp_path / "run")]
    done = subprocess.run([sys.executable, "-c", code, *words], capture_output=True, text=True, check=False)
    assert done.returncode == 3
    assert "pip install 'cdpr[live]'" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.slow
def test_from_the_command_line(tmp_path):
    words = ["run", str(FILE), "--live", "foxglove", "--live-port", "0", "--live-speed", "10", "--no-report"]
    words += ["--set", "simulation.duration=0.5", "--out", str(tmp_path / "run")]
    done = subprocess.run([sys.executable, "-m", "cdpr", *words], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "live: ws://127.0.0.1:" in done.stderr
    assert len(load_run(tmp_path / "run").rows) == 501


def test_a_request_names_its_topic():
    with pytest.raises(CdprError, match="/x: unknown topic"):
        request_of("/x", "json", b"{}")
