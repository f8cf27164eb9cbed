"""The thread that owns the simulation: what it shows, what it is told, how runs end."""

from __future__ import annotations

import time

import numpy as np
import pytest
from conftest import ROOT
from show_cases import scenario, staged, wait

import cdpr
from cdpr.gui.board import KINDS, Board, encoded
from cdpr.gui.curves import MOST, PIECE, Curves, Mark
from cdpr.gui.drawing import Drawing
from cdpr.gui.show import Clock
from cdpr.plugins import Controller, PluginOptions
from cdpr.scenario import load_scenario
from cdpr.view import State


def test_a_run_from_its_beginning_to_its_end():
    with staged(scenario()) as it:
        status = it.phase("ready")
        assert status["t"] == 0.0
        assert status["duration"] == 0.3
        assert {"backend": "reference", "solver": "qp", "controller": "computed_torque"}.items() <= status.items()
        scene = it.board.latest("scene")
        assert scene["scene"]["time"]["n"] == 1
        assert len(scene["limits"]["tension_min"]) == 8
        still = it.board.latest("frame")
        assert (still["n"], still["tension"]) == (-1, None)
        assert still["p"] == [1.0, 0.3, 1.5]
        it.do("speed", value=None)
        it.do("run")
        status = it.phase("done")
        assert status["status"] == "FINISHED"
        frame = it.board.latest("frame")
        run = cdpr.simulate(scenario())
        assert frame["n"] == len(run.rows) - 1 == 300
        assert np.allclose(frame["tension"], run.tension[-1], atol=1e-3)
        assert it.said() == []
        points = it.points()  # all samples of so short a run
        assert [t for t, _, _ in points] == pytest.approx(run.time)
        assert np.allclose([tension for _, tension, _ in points], run.tension, atol=1e-3)
        assert np.allclose([e for _, _, e in points], np.linalg.norm(run.position_error, axis=1), atol=1e-9)


def test_frames_are_of_one_row():
    """Whatever the thread does meanwhile: each frame is found, whole, among the rows of the run."""
    moving = scenario(trajectory={"type": "quintic", "duration": 0.3, "to": {"position": [1.1, 0.4, 1.6]}})
    run = cdpr.simulate(moving)
    with staged(moving) as it:
        it.phase("ready")
        it.do("run")
        seen = {}
        while it.board.latest("status")["phase"] != "done":
            frame = it.board.latest("frame")
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
    with staged(scenario(**{"simulation.duration": 60.0})) as it:
        it.phase("ready")
        it.do("step", n=7)
        assert it.phase("paused")["t"] == pytest.approx(0.007)
        start = time.monotonic()
        it.do("run")
        wait(it.board, "frame", lambda frame: frame["t"] > 0.25)
        it.do("pause")
        status = it.phase("paused")
        assert 0.2 < status["t"] <= 0.007 + time.monotonic() - start
        it.do("step")
        later = wait(it.board, "status", lambda now: now["t"] > status["t"])
        assert later["t"] == pytest.approx(status["t"] + 0.001)
        for n in (0, 1.5, True, "1", 1e9):
            it.do("step", n=n)
        it.do("speed", value="fast")
        it.do("speed", value=-1)
        told = it.said()
        assert [level for level, _ in told] == ["error"] * 7
        assert "a whole number from 1 to 10000 is expected, got 0" in told[0][1]


def test_a_run_is_seen_from_its_first_moment():
    with staged(scenario(**{"simulation.duration": 60.0})) as it:
        it.phase("ready")
        time.sleep(0.05)
        it.do("run")
        first = wait(it.board, "frame", lambda frame: frame["n"] >= 0)
        assert first["t"] < 0.3  # s; it would be more if it waited as long as when nothing runs


def test_what_is_done_is_seen_and_told():
    with staged(scenario(**{"simulation.duration": 0.5})) as it:
        it.phase("ready")
        it.do("step", n=20)
        it.do("push", force=[100, 0, 0])
        it.do("cut", cable=2)
        it.do("step", n=20)
        it.do("jam", cable="cable_3")
        it.do("limits", tension_max=700)
        it.do("set", key="controller.kp", value=30)
        it.do("target", position=[1.0, 0.32, 1.5], rpy=[0, 0, 0.05], duration=0.1)
        it.do("step", n=20)
        assert it.said() == []
        status, frame = it.board.latest("status"), it.board.latest("frame")
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
            "'cable_2' breaks",
            "'cable_3' jams",
            "limits",
            "controller.kp becomes",
            "new target",
        ):
            assert word in text
        (push,) = status["pushes"]
        it.do("release", id=push["id"])
        it.do("step", n=2)
        it.do("stop")
        it.do("step", n=2)
        it.said()
        assert it.board.latest("status")["pushes"] == []
        assert it.board.latest("frame")["force"] == [0.0, 0.0, 0.0]


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
        ("fly", {}, "'fly' is nothing that a window may ask for"),
        ("save_session", {"out": "name.txt"}, "ends in .yaml"),
        ("save_session", {"out": 3}, "the name of a file is expected"),
        ("save_session", {"out": "a\0b.yaml"}, "the name of a file is expected"),
        ("save_session", {"out": "\ud800.yaml"}, "the name of a file is expected"),
        ("save_run", {"out": "a\0b"}, "the name of a folder is expected"),
        ("save_run", {"out": "\ud800"}, "the name of a folder is expected"),
        ("save_run", {"out": 3}, "the name of a folder is expected"),
    ],
)
def test_what_is_refused_is_told_and_nothing_has_happened(shared, do, arguments, says):
    shared.do(do, **arguments)
    ((level, text),) = shared.said()
    assert level == "error"
    assert says in text, text
    assert shared.board.latest("status")["events"] == []
    assert shared.log == []


@pytest.fixture(scope="module")
def shared():
    with staged(scenario()) as it:
        it.phase("ready")
        it.do("step", n=3)
        it.said()
        yield it


def test_a_run_that_ends_badly_leaves_all_usable():
    """No tensions hold the platform at such limits, and the scenario says to stop then."""
    strict = scenario(**{"solver.infeasible": "stop"})
    with staged(strict) as it:
        it.phase("ready")
        it.do("step", n=5)
        it.do("limits", tension_max=60)
        it.do("run")
        status = it.phase("failed")
        assert status["status"] == "INFEASIBLE"
        assert "no tensions within the limits balance the wrench" in status["text"]
        assert it.board.latest("frame")["n"] == 5  # the sample that tells why
        it.do("step")
        it.do("run")
        it.do("push", force=[1, 0, 0])
        assert [level for level, _ in it.said()] == ["error"] * 3
        it.do("reset")
        status = it.phase("ready")
        assert (status["t"], status["events"], status["text"]) == (0.0, [], "")
        it.do("speed", value=None)
        it.do("run")
        assert it.phase("done", "failed")["status"] == "FINISHED"
        it.show.load(scenario(**{"simulation.duration": 0.05}), it.tell)
        assert wait(it.board, "status", lambda now: now["duration"] == 0.05)["phase"] == "ready"


class Raising(Controller):
    """Raises after some samples, or when it is made."""

    class Options(PluginOptions):
        now: bool = False
        quits: bool = False
        most: float = np.inf

    changeable = ("most",)

    def __init__(self, robot, gravity, dt, options):
        super().__init__(robot, gravity, dt, options)
        if options.quits:
            raise KeyboardInterrupt
        if options.now:
            raise ValueError("not today")

    def control(self, time, state, desired, out):
        out[:] = 0.0
        if time > 0.0105:
            raise ZeroDivisionError("by zero")


@pytest.mark.parametrize("now", [False, True])
def test_a_plugin_that_raises_is_a_status(now):
    found, name = scenario().plugins.with_class("controller", Raising)
    bad = scenario().with_changes({"controller": {"type": name, "now": now}}, plugins=found)
    with staged(bad) as it:
        if not now:
            it.phase("ready")
            it.do("run")
        status = it.phase("failed")
        assert ("not today" if now else "t = 0.011 s: a plugin raised ZeroDivisionError: by zero") in status["text"]
        it.show.load(scenario(), it.tell)
        it.phase("ready")
        it.do("step")
        assert [told for told in it.said() if told[1] != status["text"]] == []


def test_an_option_without_a_limit_is_told():
    """JSON has no number for it, and a window whose messages cannot be written would hear no more."""
    found, name = scenario().plugins.with_class("controller", Raising)
    with staged(scenario().with_changes({"controller": {"type": name}}, plugins=found)) as it:
        status = it.phase("ready")
        encoded(status)
        assert status["changeable"] == [{"key": "controller.most", "value": ".inf"}]


def test_a_plugin_that_asks_for_the_end_ends_nothing():
    found, name = scenario().plugins.with_class("controller", Raising)
    bad = scenario().with_changes({"controller": {"type": name, "quits": True}}, plugins=found)
    with staged(bad) as it:
        assert "KeyboardInterrupt" in it.phase("failed")["text"]
        it.show.load(scenario(), it.tell)
        it.phase("ready")
        it.do("step")
        it.said()
        assert it.board.latest("frame")["n"] == 0


def test_a_fault_of_ours_is_told_and_the_thread_lives(monkeypatch):
    with staged(scenario()) as it:
        it.phase("ready")
        monkeypatch.setattr(it.show, "_pause", lambda: {}["nothing"])
        it.do("pause")
        ((level, text),) = it.said()
        assert level == "error"
        assert "internal error: KeyError: 'nothing'; the terminal has more" in text
        assert "Traceback" in it.log[0]
        monkeypatch.undo()
        it.do("step")
        assert it.said() == []
        monkeypatch.setattr(it.show._stage, "step", lambda n: {}["nothing"])
        it.do("run")
        assert "internal error" in it.phase("failed")["text"]
        it.do("reset")
        it.phase("ready")
        it.said()
        del it.log[:]
        monkeypatch.setattr(it.show._stage, "show_frame", lambda: {}["nothing"])
        it.do("run")
        it.phase("failed")
        time.sleep(1.2)  # s, in which two frames are due
        assert len(it.log) <= 2  # of the command, and of frames
        monkeypatch.setattr("cdpr.gui.stage.Stage.__init__", lambda *_: {}["nothing"])
        it.do("reset")
        assert it.said()[-1][1].startswith("internal error")
        assert it.phase("failed")["text"].startswith("internal error")
        monkeypatch.undo()
        it.do("reset")
        it.phase("ready")


def test_what_windows_ask_for_waits_in_no_endless_line():
    with staged(scenario()) as it:
        it.phase("ready")
        it.show._jobs.put(lambda: time.sleep(0.2))
        for _ in range(300):
            it.do("step")
        told = it.said()
        assert 90 < len(told) < 110
        assert "is left out" in told[0][1]
        it.do("step")
        assert it.said() == []


def test_it_closes_whatever_it_does():
    with staged(scenario(**{"simulation.duration": 600.0})) as it:
        it.phase("ready")
        it.do("speed", value=None)
        it.do("run")
        it.phase("running")
    assert not it.show._thread.is_alive()
    with staged(scenario()) as it:
        known = it.phase("ready").keys()
        it.show.nothing()
        assert it.phase("failed").keys() == known
        it.do("run")
        assert "nothing is simulated" in it.said()[0][1]
    with staged():
        pass
    with staged(scenario()):
        pass  # while it builds


@pytest.fixture
def no_report(monkeypatch):
    """Drawing a report takes a second."""
    monkeypatch.setattr("cdpr.report.pages.run.write_report", lambda run, path: path.touch())


def test_runs_too_long_for_the_memory_go_to_a_folder_that_is_gone_in_the_end(tmp_path, monkeypatch, no_report):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    long = scenario(**{"simulation.duration": 120.0})
    with staged(long) as it:
        it.phase("ready")
        assert len(list(tmp_path.glob("cdpr-gui-*/log.mcap"))) == 1
        it.do("step", n=5000)
        it.do("save_run", out=str(tmp_path / "run"))
        it.do("step", n=100)
        it.do("reset")
        it.do("step", n=10)
        end = time.monotonic() + 30
        while not (tmp_path / "run" / "report.html").exists() and time.monotonic() < end:
            time.sleep(0.05)
        assert [level for level, _ in it.said() if level == "error"] == []
    assert list(tmp_path.glob("cdpr-gui-*")) == []
    saved = cdpr.load_run(tmp_path / "run")
    same = cdpr.simulate(scenario(**{"simulation.duration": 5.0}))
    assert saved.rows[:].tobytes() == same.rows[:5000].tobytes()


def test_a_run_is_saved_as_it_would_have_logged(tmp_path):
    with staged(scenario()) as it:
        it.phase("ready")
        it.do("step", n=50)
        it.do("save_run", out=str(tmp_path / "half"))
        it.do("speed", value=None)
        it.do("run")
        it.phase("done")
        it.do("save_run", out=str(tmp_path / "whole"))
        it.do("save_run", out=str(tmp_path / "whole"))
        end = time.monotonic() + 30
        while len(it.told) < 3 and time.monotonic() < end:
            time.sleep(0.02)
        assert sorted(level for level, _ in it.said()) == ["error", "info", "info"]
    cdpr.simulate(scenario(), out=tmp_path / "logged")
    assert (tmp_path / "whole" / "log.mcap").read_bytes() == (tmp_path / "logged" / "log.mcap").read_bytes()
    assert (tmp_path / "whole" / "report.html").stat().st_size > 50_000
    half, whole = cdpr.load_run(tmp_path / "half"), cdpr.load_run(tmp_path / "whole")
    assert (half.status, whole.status) == ("ended", "finished")
    assert half.rows.tobytes() == whole.rows[:50].tobytes()
    assert half.summary()["samples"] == 50
    assert not (tmp_path / "whole" / "session.yaml").exists()


@pytest.mark.parametrize("backend", ["reference", pytest.param("mujoco", marks=pytest.mark.slow)])
def test_a_session_repeats_to_the_bit(backend, tmp_path, no_report):
    """What a person does while it runs in real time, at whatever samples that falls."""
    pytest.importorskip({"reference": "numpy"}.get(backend, backend))
    live = scenario(**{"simulation.backend": backend})
    with staged(live) as it:
        it.phase("ready")
        it.do("run")
        wait(it.board, "frame", lambda frame: frame["t"] > 0.03)
        it.do("push", force=[100, 0, 20], duration=0.05)
        it.do("target", position=[1.0, 0.32, 1.5], duration=0.1)
        wait(it.board, "frame", lambda frame: frame["t"] > 0.1)
        it.do("set", key="controller.kp", value=30)
        it.do("cut", cable=2)
        it.phase("done")
        it.do("save_session", out=str(tmp_path / "session.yaml"))
        it.do("save_run", out=str(tmp_path / "run"))
        end = time.monotonic() + 30
        while len(it.told) < 2 and time.monotonic() < end:
            time.sleep(0.02)
        assert [level for level, _ in it.said()] == ["info", "info"]
    rows = cdpr.load_run(tmp_path / "run").rows.tobytes()
    assert cdpr.simulate(tmp_path / "session.yaml").rows.tobytes() == rows
    assert cdpr.simulate(tmp_path / "run" / "session.yaml").rows.tobytes() == rows


def test_a_saved_session_takes_the_place_of_nothing_but_itself(tmp_path):
    mine, session = tmp_path / "mine.yaml", tmp_path / "session.yaml"
    mine.write_text("# hours of work\n")
    (tmp_path / "given_outside.csv").write_text("t\n")
    with staged(scenario()) as it:
        it.phase("ready")
        it.do("step", n=2)
        for out in (mine, tmp_path / "given.yaml", session):
            it.do("save_session", out=str(out))
        it.do("step", n=3)
        it.do("save_session", out=str(session))
        told = it.said()
        it.do("reset")
        it.do("step")
        it.do("save_session", out=str(session))
        assert "is there already" in it.said()[-1][1]
    assert [level for level, _ in told] == ["error", "error", "info", "info"]
    assert "mine.yaml' is there already: it is not written over" in told[0][1]
    assert "given_outside.csv' is there already" in told[1][1]
    assert mine.read_text() == "# hours of work\n"
    assert not (tmp_path / "given.yaml").exists()
    assert load_scenario(session).simulation.steps == 4


def test_what_happened_last_is_told_however_much_did():
    with staged(scenario()) as it:
        it.phase("ready")
        it.do("step", n=2)
        for k in range(203):
            it.do("limits", tension_max=1000 + k)
            it.do("step")
            it.said()
        events = it.board.latest("status")["events"]
        assert "become max 1202 N" in events[-1]["text"]
        assert len(events) == 201
        assert events[0] == {"t": 0.002, "text": "3 earlier events"}


def test_cables_that_leave_from_pulleys_show_where():
    winch = load_scenario(ROOT / "scenarios" / "cogiro_pulleys.yaml")
    with staged(winch) as it:
        it.phase("ready")
        it.do("step", n=2)
        it.said()
        frame = it.board.latest("frame")
        assert len(frame["exits"]) == 3 * len(frame["tension"])
        assert all(len(point) == 3 for line in frame["outlines"] for point in line)


# The board: bounded whatever windows do.


def test_a_slow_window_gets_the_newest_alone():
    board = Board()
    board.curves.begin({"tension": (1, 3)}, 10)
    reader = board.join()
    texts = iter(reader)
    for n in range(1000):
        board.put({"kind": "frame", "n": n})
        board.put({"kind": "message", "n": n})
    board.put({"kind": "hello"})
    first = [next(texts) for _ in range(2)]
    assert first == [encoded({"kind": "hello"}), encoded({"kind": "frame", "n": 999})]
    board.curves.add(np.ones((3, 2)))
    with board.changed:
        board.curves.show()
    rest = [next(texts) for _ in range(51)]  # an empty `samples`, and the last of the messages
    assert '"samples"' in rest[0]
    assert rest[-1] == encoded({"kind": "message", "n": 999})
    assert '"t":[1.0,1.0,1.0]' in next(texts)
    late = iter(board.join())
    assert next(late) == encoded({"kind": "hello"})
    board.leave(reader)
    assert list(texts) == []


def test_no_message_holds_what_json_has_not():
    assert set(KINDS) == {"hello", "form", "scene", "status", "frame"}
    with pytest.raises(ValueError, match="not JSON compliant"):
        encoded({"kind": "frame", "t": float("nan")})


# Curves.


@pytest.mark.parametrize("samples", [10, MOST, 100_001])
def test_curves_are_bounded_and_keep_their_extremes(samples):
    rng = np.random.default_rng(3)
    rows = np.column_stack([np.arange(samples) * 1e-3, rng.normal(size=(samples, 3))])
    rows[samples // 3, 2], rows[samples // 2, 1] = 1e6, -1e6
    curves = Curves()
    curves.begin({"tension": (2, 3), "position_error": (1, 9)}, samples)
    for part in np.array_split(rows, 13):
        curves.add(part)
        curves.show()
    curves.end()
    curves.show()
    mark, sent = curves.start(), []
    while True:
        messages, mark = curves.since(mark)
        if not messages:
            break
        (message,) = messages
        assert len(message["t"]) <= PIECE
        assert message["reset"] == (message["from"] == 0)
        sent += zip(message["t"], message["tension"], strict=True)
    assert len(sent) <= MOST + 2
    values = np.array([value for _, value in sent])
    assert values[:, 1].max() == 1e6
    assert values[:, 0].min() == -1e6
    times = np.array([t for t, _ in sent])
    assert (np.diff(times) > 0).all()
    at = times[values[:, 1].argmax()]
    assert abs(at - rows[samples // 3, 0]) <= 2e-3 * max(1, 2 * samples // MOST)
    if samples <= MOST:
        assert len(sent) == samples


def test_curves_hold_what_is_no_number_as_nothing():
    curves = Curves()
    curves.begin({"tension": (2, 3), "position_error": (1, 9)}, 10)
    curves.add(np.array([[0.0, np.nan, 1.0, np.inf]]))
    curves.show()
    ((message,), mark) = curves.since(Mark(-1, 0))
    assert message["tension"] == [[None, 1.0]]
    assert message["position_error"] == [None]
    encoded(message)
    curves.begin({"tension": (2, 3)}, 10)
    ((message,), _) = curves.since(mark)
    assert message["reset"]
    assert message["t"] == []


# The clock.


def test_a_clock_that_is_late_does_not_run_after_itself(monkeypatch):
    now = 0.0
    monkeypatch.setattr("cdpr.gui.show.monotonic", lambda: now)
    clock = Clock()
    clock.start(1.0, 1.0)
    assert clock.steps(1.0, 0.001) == 0
    now = 0.0105
    assert clock.steps(1.0, 0.001) == 10
    now = 10.0  # the machine slept
    steps = clock.steps(1.0, 0.001)
    assert 0 < steps <= 1000 / 30
    clock.took(steps, 0.001)
    time_now = 1.0 + 0.001 * steps
    now = 10.001
    assert clock.steps(time_now, 0.001) <= 500  # half a second, not ten of them
    clock.start(0.0, None)
    assert clock.steps(0.0, 0.001) >= 1
    assert clock.factor(now + 1.0, 0.5) == 0.5


@pytest.mark.parametrize(("speed", "period"), [(1.0, 2.0), (0.1, 0.1), (0.001, 0.001)])
def test_a_step_that_takes_long_by_the_clock_is_waited_for(speed, period, monkeypatch):
    now, done = 0.0, 0
    monkeypatch.setattr("cdpr.gui.show.monotonic", lambda: now)
    clock = Clock()
    clock.start(0.0, speed)
    while now < 5.5 * period / speed:
        now += period / speed / 100.0
        done += clock.steps(done * period, period)
    assert done == 5


def test_the_scene_tells_how_the_base_is_turned():
    """So that a point which is dragged in the world is written as the file has it."""
    turned = {"robot.frame": {"position": [1.0, 0.0, 0.0], "orientation": {"rpy_deg": [20.0, 0.0, 90.0]}}}
    plain, moved = (cdpr.load_scenario("caroca", overrides=changes) for changes in ({}, turned))
    scene = Drawing(moved).scene(moved.initial.state(), moved.desired.sample(0.0))
    base = np.reshape(scene["base"], (3, 3))
    np.testing.assert_allclose(
        plain.robot.anchors[:, :3] @ base.T + [1.0, 0.0, 0.0], np.array(scene["scene"]["anchors"])[:, :3], atol=1e-12
    )
