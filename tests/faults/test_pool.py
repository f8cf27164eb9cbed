"""Worker processes: whatever happens to one, the others' cases are untouched and no process is left."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from conftest import FAULTY, ROOT
from plants import installed

import cdpr
from cdpr.analysis.jobs import forks, pool
from cdpr.analysis.jobs.pool import Case, run_cases
from cdpr.base.errors import Diverged

CAROCA = str(ROOT / "scenarios" / "caroca.yaml")
SHORT = {"simulation.duration": 0.1}
DIVERGING = {"controller.kp": 1e6, "simulation.control_step": 0.01, "robot.tension.max": 1e11}
TIMEOUT = 2.0  # s; a sound case takes a hundredth of that


def case(key, fault="none", **options):
    options = {f"controller.{name}": value for name, value in {"fault": fault, **options}.items()}
    return Case(key, CAROCA, {"controller.type": "faulty", **options, **SHORT})


@pytest.fixture(autouse=True)
def _installed(faulty_plugin):
    pass


def gone(pid):
    """Return True if a process has ended; it may be a zombie of another parent."""
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rpartition(")")[2].split()[0] == "Z"
    except FileNotFoundError:
        return True


@pytest.mark.slow
def test_every_kind_of_end(monkeypatch):
    with pytest.raises(Diverged):  # compiles all kernels that the cases need: not in their time
        cdpr.simulate(CAROCA, overrides=DIVERGING)
    started = []

    class Watched(pool.Worker):
        def __init__(self):
            super().__init__()
            started.append(self._process.pid)

    monkeypatch.setattr(pool, "Worker", Watched)
    cases = [
        case("sound"),
        case("raise", "raise"),
        case("hang", "hang"),
        case("crash", "crash"),
        case("exit", "exit"),
        case("kill", "kill"),
        case("chatter", "chatter"),
        Case("bad", CAROCA, {"controller.kpp": 1.0}),
        Case("diverged", CAROCA, DIVERGING),
        Case("infeasible", CAROCA, {**SHORT, "solver.infeasible": "stop", "robot.platform.mass": 1e4}),
        case("last"),
    ]
    told = []
    outcomes = run_cases(cases, jobs=2, timeout=TIMEOUT, done=told.append)
    assert [outcome.key for outcome in outcomes] == [case.key for case in cases]
    assert sorted(outcome.key for outcome in told) == sorted(case.key for case in cases)
    status = {outcome.key: outcome.status for outcome in outcomes}
    assert status == {
        **dict.fromkeys(("sound", "chatter", "last"), "finished"),
        **dict.fromkeys(("raise", "bad"), "failed"),
        **dict.fromkeys(("crash", "exit", "kill"), "died"),
        "hang": "hung",
        "diverged": "diverged",
        "infeasible": "infeasible",
    }
    said = {outcome.key: outcome.message for outcome in outcomes}
    assert "no law" in said["raise"]
    assert "did you mean 'kp'" in said["bad"]
    assert said["hang"] == "no answer after 2 s"
    assert said["crash"].startswith("the process of this case was ended by SIGSEGV\n")
    assert "the engine says goodbye" in said["crash"]
    assert "in control" in said["crash"]  # where Python was
    assert said["exit"] == "the process of this case ended with exit code 7"
    assert said["kill"] == "the process of this case was ended by SIGKILL"
    assert 2 + 3 <= len(started) <= 2 + 4  # each loss is replaced while cases wait, as they may not when one hung
    assert all(gone(pid) for pid in started)


def test_a_case_is_the_run_of_this_process(tmp_path):
    """To the bit, on every engine, although workers use one thread, and whatever the worker ran before."""
    cases = [
        Case(
            f"{backend}-{kp}",
            CAROCA,
            {"simulation.backend": backend, "controller.kp": kp, **SHORT},
            str(tmp_path / f"{backend}-{kp}"),
        )
        for backend in installed("reference", "mujoco", "bullet", "dart")
        for kp in (100.0, 200.0)
    ]
    for one, outcome in zip(cases, run_cases(cases, jobs=1, timeout=None), strict=True):
        assert outcome.status == "finished", outcome.message
        run = cdpr.simulate(CAROCA, overrides=one.changes)
        np.testing.assert_array_equal(cdpr.load_run(outcome.folder).rows, run.rows)
        mine = run.summary()
        assert {key: value for key, value in outcome.summary.items() if key != "real_time_factor"} == {
            key: value for key, value in mine.items() if key != "real_time_factor"
        }


@pytest.mark.slow
def test_a_text_runs_in_place_of_the_file():
    text = cdpr.load_scenario(CAROCA, overrides=SHORT).resolved_yaml()
    (outcome,) = run_cases([Case("text", CAROCA, text=text)], jobs=4, timeout=None)
    assert outcome.summary["samples"] == 101


@pytest.mark.slow
def test_a_worker_that_dies_idle_costs_no_case(monkeypatch):
    """Its next case has not been in it."""
    look = pool.Worker.poll

    def die_after(self):
        outcome = look(self)
        if outcome is not None and outcome.key == "first":
            os.killpg(self._process.pid, signal.SIGKILL)
            self._process.wait()
        return outcome

    monkeypatch.setattr(pool.Worker, "poll", die_after)
    outcomes = run_cases([case("first"), case("second")], jobs=1, timeout=None)
    assert [outcome.status for outcome in outcomes] == ["finished", "finished"]


@pytest.mark.slow
def test_exceptions_of_the_callback_stop_the_workers():
    def done(outcome):
        raise KeyboardInterrupt

    started = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        run_cases([case("sound"), case("hang", "hang")], jobs=2, timeout=600, done=done)
    assert time.monotonic() - started < 60


@pytest.mark.slow
def test_a_killed_fork_server_is_replaced():
    """Active workers end with the pool; later ones come from another one."""

    def done(outcome):
        if outcome.key == "0":
            server = forks._known[os.getpid()]._process
            server.kill()
            server.wait()

    outcomes = run_cases([case(str(k)) for k in range(4)], jobs=1, timeout=60, done=done)
    assert [outcome.status for outcome in outcomes].count("died") <= 1
    assert outcomes[-1].status == "finished"


@pytest.mark.slow
def test_a_hanging_fork_server_is_replaced():
    run_cases([case("first")], jobs=1, timeout=60)
    server = forks._known[os.getpid()]
    server._socket.settimeout(0.2)
    os.kill(server._process.pid, signal.SIGSTOP)
    (outcome,) = run_cases([case("second")], jobs=1, timeout=60)
    assert outcome.status == "finished"
    assert gone(server._process.pid)


def test_a_folder_that_is_gone_harms_no_case(tmp_path, monkeypatch):
    (tmp_path / "gone").mkdir()
    monkeypatch.chdir(tmp_path / "gone")
    (tmp_path / "gone").rmdir()
    (outcome,) = run_cases([case("sound")], jobs=1, timeout=60)
    assert outcome.status == "finished", outcome.message


def test_workers_inherit_the_current_environment(monkeypatch, tmp_path):
    """Not what was there when the process that they are forked from began."""
    run_cases([case("first")], jobs=1, timeout=60)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "short.yaml").write_text(cdpr.load_scenario(CAROCA, overrides=SHORT).resolved_yaml())
    (outcome,) = run_cases([Case("here", "short.yaml")], jobs=1, timeout=60)
    assert outcome.status == "finished", outcome.message


PARENT = """
import sys
from cdpr.analysis.jobs.pool import Case, Worker, wait
changes = {"controller.type": "faulty", "controller.fault": "hang", "controller.once": sys.argv[2]}
worker = Worker()
worker.begin(Case("hang", sys.argv[1], changes), None)
print(worker._process.pid, flush=True)
while worker.poll() is None:  # it says that it has begun
    wait(worker.sources())
"""


@pytest.mark.parametrize("number", [signal.SIGKILL, pytest.param(signal.SIGTERM, marks=pytest.mark.slow)])
def test_workers_end_with_their_parent(number, tmp_path):
    env = {**os.environ, "PYTHONPATH": os.pathsep.join([str(FAULTY), str(ROOT)])}
    parent = subprocess.Popen(
        [sys.executable, "-c", PARENT, CAROCA, tmp_path / "hangs"], stdout=subprocess.PIPE, text=True, env=env
    )
    pid = int(parent.stdout.readline())
    deadline = time.monotonic() + 60
    while not (tmp_path / "hangs").exists():  # in the midst of a case it reads nothing
        assert time.monotonic() < deadline
        time.sleep(0.02)
    assert not gone(pid)
    parent.send_signal(number)
    parent.communicate()
    deadline = time.monotonic() + 60
    while not gone(pid):
        assert time.monotonic() < deadline
        time.sleep(0.02)


def test_a_killed_case_is_not_taken_for_a_finished_one(tmp_path):
    changes = {"controller.type": "faulty", "controller.fault": "kill", "controller.at": 600}
    (outcome,) = run_cases([Case("kill", CAROCA, changes, str(tmp_path / "run"))], jobs=1, timeout=None)
    assert outcome.status == "died"
    assert json.loads((tmp_path / "run" / "run.json").read_text())["status"] == "running"


@pytest.mark.slow
def test_the_working_folder_shadows_nothing(tmp_path, monkeypatch):
    """A user's file may have the name of a module of cdpr."""
    (tmp_path / "numpy.py").write_text("raise SystemExit('not this one')")
    monkeypatch.chdir(tmp_path)
    (outcome,) = run_cases([case("sound")], jobs=1, timeout=None)
    assert outcome.status == "finished", outcome.message
