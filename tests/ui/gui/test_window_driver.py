"""Thread that owns the simulation: displays, requests, end."""

from __future__ import annotations

import re
import time

import numpy as np
import pytest
from driver_cases import PATIENCE, running_driver, scenario, wait

import cdpr
from cdpr.scene import State
from cdpr.simulation.requests import Request
from cdpr.ui.gui import session


def test_a_run_from_its_beginning_to_its_end():
    with running_driver(scenario()) as it:
        status = it.phase("ready")
        assert status["t"] == 0.0
        assert status["duration"] == 0.3
        assert {"backend": "reference", "solver": "qp", "controller": "computed_torque"}.items() <= status.items()
        scene = it.broadcast.latest("scene")
        assert scene["scene"]["time"]["n"] == 1
        assert len(scene["limits"]["tension_min"]) == 8
        still = it.broadcast.latest("frame")
        assert (still["n"], still["tension"]) == (-1, None)
        assert still["p"] == [1.0, 0.3, 1.5]
        it.do("speed", value=None)
        it.do("run")
        status = it.phase("done")
        assert status["status"] == "FINISHED"
        frame = it.broadcast.latest("frame")
        run = cdpr.simulate(scenario())
        assert frame["n"] == len(run.rows) - 1 == 300
        assert np.allclose(frame["tension"], run.tension[-1], atol=1e-3)
        assert it.said() == []
        points = it.points()  # all samples of so short a run
        assert [t for t, _, _ in points] == pytest.approx(run.time)
        assert np.allclose([tension for _, tension, _ in points], run.tension, atol=1e-3)
        assert np.allclose([e for _, _, e in points], np.linalg.norm(run.position_error, axis=1), atol=1e-9)


def test_frames_are_of_one_row():
    """For any activity of the thread, each frame is found complete among the rows of the run."""
    moving = scenario(trajectory={"type": "quintic", "duration": 0.3, "to": {"position": [1.1, 0.4, 1.6]}})
    run = cdpr.simulate(moving)
    with running_driver(moving) as it:
        it.phase("ready")
        it.do("run")
        seen = {}
        while it.broadcast.latest("status")["phase"] != "done":
            frame = it.broadcast.latest("frame")
            seen[frame["n"]] = frame
            time.sleep(0.002)
    assert len(seen) > 5
    for n, frame in seen.items():
        if n >= 0:
            assert np.allclose(frame["p"], run.position[n], atol=1e-6)
            assert np.allclose(frame["q"], run.orientation[n], atol=1e-6)
            assert np.allclose(frame["dp"], run.desired_position[n], atol=1e-6)
            assert np.allclose(frame["tension"], run.tension[n], atol=1e-3)
            assert frame["t"] == pytest.approx(run.time[n])


def test_real_time_pause_and_steps():
    with running_driver(scenario(**{"simulation.duration": 60.0})) as it:
        it.phase("ready")
        it.do("step", n=7)
        assert it.phase("paused")["t"] == pytest.approx(0.007)
        start = time.monotonic()
        it.do("run")
        wait(it.broadcast, "frame", lambda frame: frame["t"] > 0.25)
        it.do("pause")
        status = it.phase("paused")
        assert 0.2 < status["t"] <= 0.007 + time.monotonic() - start
        it.do("step")
        later = wait(it.broadcast, "status", lambda now: now["t"] > status["t"])
        assert later["t"] == pytest.approx(status["t"] + 0.001)
        for n in (0, 1.5, True, "1", 1e9):
            it.do("step", n=n)
        it.do("speed", value="fast")
        it.do("speed", value=-1)
        told = it.said()
        assert [level for level, _ in told] == ["error"] * 7
        assert "expected a whole number from 1 to 10000, got 0" in told[0][1]


def test_a_run_is_seen_from_its_first_moment():
    with running_driver(scenario(**{"simulation.duration": 60.0})) as it:
        it.phase("ready")
        time.sleep(0.05)
        it.do("run")
        first = wait(it.broadcast, "frame", lambda frame: frame["n"] >= 0)
        assert first["t"] < 0.3  # s; it would be more if it waited as long as when nothing runs


def test_actions_are_shown_and_reported():
    with running_driver(scenario(**{"simulation.duration": 0.5})) as it:
        it.phase("ready")
        it.do("step", n=20)
        it.do("push", force=[100, 0, 0])
        it.do("attach", mass=2.5, center=[0, 0, -0.1], known=True)
        it.do("cut", cable=2)
        it.do("step", n=20)
        it.do("jam", cable="cable_3")
        it.do("limits", tension_max=700)
        it.do("set", key="controller.kp", value=30)
        it.do("target", position=[1.0, 0.32, 1.5], rpy=[0, 0, 0.05], duration=0.1)
        it.do("step", n=20)
        assert it.said() == []
        status, frame = it.broadcast.latest("status"), it.broadcast.latest("frame")
        assert [cable["name"] for cable in status["cables"] if cable["broken"]] == ["cable_2"]
        assert [cable["name"] for cable in status["cables"] if cable["jammed"]] == ["cable_3"]
        assert frame["state"][1] == State.BROKEN
        assert frame["force"] == [100.0, 0.0, 0.0]
        assert {"key": "controller.kp", "value": 30.0} in [
            {**one, "value": np.ravel(one["value"])[0]} for one in status["changeable"]
        ]
        text = " ".join(event["text"] for event in status["events"])
        for word in (
            "external force",
            "payload of 2.5 kg",
            "'cable_2' breaks",
            "'cable_3' jams",
            "limits",
            "controller.kp becomes",
            "new target",
        ):
            assert word in text
        push, body = status["pushes"]
        assert (push["text"], body["text"]) == ("[100, 0, 0] N", "2.5 kg")
        it.do("release", id=push["id"])
        it.do("release", id=body["id"])
        it.do("step", n=2)
        it.do("stop")
        it.do("step", n=2)
        it.said()
        assert it.broadcast.latest("status")["pushes"] == []
        assert it.broadcast.latest("frame")["force"] == [0.0, 0.0, 0.0]


def test_the_latest_events_are_always_shown(monkeypatch):
    assert session.MOST == 200
    monkeypatch.setattr(session, "MOST", 20)  # as of 200, in a tenth of the time
    with running_driver(scenario()) as it:
        it.phase("ready")
        it.do("step", n=2)
        for k in range(23):
            it.do("limits", tension_max=1000 + k)
            it.do("step")
            it.said()
        events = it.broadcast.latest("status")["events"]
        assert "become max 1022 N" in events[-1]["text"]
        assert len(events) == 21
        assert events[0] == {"t": 0.002, "text": "3 earlier events"}


@pytest.fixture(scope="module")
def shared():
    with running_driver(scenario()) as it:
        it.phase("ready")
        it.do("step", n=3)
        it.said()
        yield it


@pytest.mark.parametrize(
    ("do", "arguments", "says"),
    [
        ("cut", {"cable": 99}, "cable"),
        ("cut", {}, "missing a required argument: 'cable'"),
        ("cut", {"cabel": 1}, "did you mean 'cable'?"),
        ("push", {"force": [1, 2]}, "force"),
        ("push", {"force": "up"}, "force"),
        ("push", {"force": [1, 2, float("inf")]}, "force"),
        ("release", {"id": 7}, "that push has ended"),
        ("release", {"id": [7]}, "that push has ended"),
        ("limits", {"tension_min": 900, "tension_max": 100}, "min must not exceed max"),
        ("target", {"position": [0, 0]}, "position"),
        ("set", {"key": "solver.nothing", "value": 1}, "cannot change during a run"),
        ("set", {"key": 3, "value": 1}, "key"),
        ("fly", {}, "'fly' is not an allowed request"),
        ("tension", {"tension": []}, "'tension' is not an allowed request"),
        ("winch_command", {}, "'winch_command' is not an allowed request"),
        ("jog", {"cable": 1, "rate": 0.1}, "jog: cable 'cable_1': its winch takes a tension (N), got rate"),
        ("hold", {}, "hold: all winches of this robot take tensions, and hold no length"),
        ("save_session", {"out": "name.txt"}, "ends in .yaml"),
        ("save_session", {"out": 3}, "expected the name of a file"),
        ("save_session", {"out": "a\0b.yaml"}, "expected the name of a file"),
        ("save_session", {"out": "\ud800.yaml"}, "expected the name of a file"),
        ("save_run", {"out": "a\0b"}, "expected the name of a folder"),
        ("save_run", {"out": "\ud800"}, "expected the name of a folder"),
        ("save_run", {"out": 3}, "expected the name of a folder"),
    ],
)
def test_rejections_have_no_side_effects(shared, do, arguments, says):
    shared.do(do, **arguments)
    ((level, text),) = shared.said()
    assert level == "error"
    assert says in text, text
    assert shared.broadcast.latest("status")["events"] == []
    assert shared.log == []


def test_a_target_outside_the_frame_is_reported_and_reached():
    with running_driver(scenario()) as it:
        it.phase("ready")
        it.do("step", n=2)
        it.do("target", position=[1.0, 0.32, 9.0])
        it.do("step", n=2)
        ((level, text),) = it.said()
        assert level == "warning"
        assert text.startswith("target: lies outside the frame: its anchors go from z = 3.5 to 3.5 m, and here z = 9 m")
        assert "new target" in it.broadcast.latest("status")["events"][-1]["text"]


@pytest.mark.slow
def test_the_request_queue_of_windows_is_bounded():
    with running_driver(scenario()) as it:
        it.phase("ready")
        it.driver.requests.put(Request("sleep", action=lambda: time.sleep(0.2)))
        for _ in range(300):
            it.do("step")
        told = it.said()
        assert 90 < len(told) < 110
        assert "requests are pending" in told[0][1]
        it.do("step")
        assert it.said() == []


def test_commands_after_the_close_are_answered():
    with running_driver() as it:
        it.driver.requests.put(Request("close", action=it.driver._leave))
        it.do("save_run")  # behind `close`, or after it
    it.do("run")
    assert it.told == [("error", "the window is closed")] * 2


def test_a_close_ends_steps():
    with running_driver(scenario(**{"simulation.duration": 60.0})) as it:
        it.phase("ready")
        it.do("step", n=10_000)
        it.do("push", force=[1.0, 0.0, 0.0])
    ((level, text),) = it.told
    assert level == "error"
    assert re.fullmatch(r"step: interrupted, \d+ steps remain", text)


def test_saving_needs_a_simulation():
    with running_driver() as it:
        it.do("save_run")
        it.do("save_session", out="name.yaml")
        assert it.said() == [("error", "not simulated: correct the errors and apply, or reset")] * 2


@pytest.mark.slow
def test_it_closes_whatever_it_does():
    with running_driver(scenario(**{"simulation.duration": 600.0})) as it:
        it.phase("ready")
        it.do("speed", value=None)
        it.do("run")
        it.phase("running")
    it.driver._thread.join(PATIENCE)  # what it does just now may be to compile, on a busy machine
    assert not it.driver._thread.is_alive()
    with running_driver(scenario()) as it:
        known = it.phase("ready").keys()
        it.driver.nothing()
        assert it.phase("failed").keys() == known
        it.do("run")
        assert "not simulated: correct the errors" in it.said()[0][1]
    with running_driver():
        pass
    with running_driver(scenario()):
        pass  # while it builds
