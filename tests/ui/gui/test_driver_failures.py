"""Failures of a run, a plugin or cdpr in the thread that owns the simulation: reported, and all stays usable."""

from __future__ import annotations

import time

import numpy as np
import pytest
from driver_cases import running_driver, scenario, wait

from cdpr.plugins import Controller, PluginOptions
from cdpr.ui.gui.broadcast import encoded


@pytest.mark.slow
def test_a_run_that_ends_badly_leaves_all_usable():
    """No tensions hold the platform at such limits, and the scenario stops in this case."""
    strict = scenario(**{"solver.infeasible": "stop"})
    with running_driver(strict) as it:
        it.phase("ready")
        it.do("step", n=5)
        it.do("limits", tension_max=60)
        it.do("run")
        status = it.phase("failed")
        assert status["status"] == "INFEASIBLE"
        assert "no tensions within the limits balance the wrench" in status["text"]
        assert it.broadcast.latest("frame")["n"] == 5  # the sample with the reason
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
        it.driver.load(scenario(**{"simulation.duration": 0.05}), it.tell)
        assert wait(it.broadcast, "status", lambda now: now["duration"] == 0.05)["phase"] == "ready"


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


@pytest.mark.slow
@pytest.mark.parametrize("now", [False, True])
def test_a_plugin_that_raises_is_a_status(now):
    found, name = scenario().plugins.with_class("controller", Raising)
    bad = scenario().with_changes({"controller": {"type": name, "now": now}}, plugins=found)
    with running_driver(bad) as it:
        if not now:
            it.phase("ready")
            it.do("run")
        status = it.phase("failed")
        assert ("not today" if now else "t = 0.011 s: a plugin raised ZeroDivisionError: by zero") in status["text"]
        it.driver.load(scenario(), it.tell)
        it.phase("ready")
        it.do("step")
        assert [told for told in it.said() if told[1] != status["text"]] == []


def test_an_option_without_a_limit_is_reported():
    """JSON has no number for it, and a window whose messages cannot be written would receive no more."""
    found, name = scenario().plugins.with_class("controller", Raising)
    with running_driver(scenario().with_changes({"controller": {"type": name}}, plugins=found)) as it:
        status = it.phase("ready")
        encoded(status)
        assert status["changeable"] == [{"key": "controller.most", "value": ".inf"}]


@pytest.mark.slow
def test_plugins_cannot_stop_the_process():
    found, name = scenario().plugins.with_class("controller", Raising)
    bad = scenario().with_changes({"controller": {"type": name, "quits": True}}, plugins=found)
    with running_driver(bad) as it:
        assert "KeyboardInterrupt" in it.phase("failed")["text"]
        it.driver.load(scenario(), it.tell)
        it.phase("ready")
        it.do("step")
        it.said()
        assert it.broadcast.latest("frame")["n"] == 0


@pytest.mark.slow
def test_an_internal_error_is_reported_and_the_thread_survives(monkeypatch):
    with running_driver(scenario()) as it:
        it.phase("ready")
        monkeypatch.setattr(it.driver, "request_pause", lambda: {}["nothing"])
        it.do("pause")
        ((level, text),) = it.said()
        assert level == "error"
        assert "internal error: KeyError: 'nothing'; the terminal has more" in text
        assert "Traceback" in it.log[0]
        monkeypatch.undo()
        it.do("step")
        assert it.said() == []
        monkeypatch.setattr(it.driver._session, "step", lambda n: {}["nothing"])
        it.do("run")
        assert "internal error" in it.phase("failed")["text"]
        it.do("reset")
        it.phase("ready")
        it.said()
        del it.log[:]
        monkeypatch.setattr(it.driver._session, "show_frame", lambda: {}["nothing"])
        it.do("run")
        it.phase("failed")
        time.sleep(1.2)  # s, in which two frames are due
        assert len(it.log) <= 2  # of the command, and of frames
        monkeypatch.setattr("cdpr.ui.gui.session.SimulationSession.__init__", lambda *_: {}["nothing"])
        it.do("reset")
        assert it.said()[-1][1].startswith("internal error")
        assert it.phase("failed")["text"].startswith("internal error")
        monkeypatch.undo()
        it.do("reset")
        it.phase("ready")
