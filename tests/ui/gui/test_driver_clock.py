"""The clock of the thread that owns the simulation: how many steps are due."""

from __future__ import annotations

import pytest

from cdpr.ui.gui.driver import Clock


def test_a_clock_that_is_late_does_not_run_after_itself(monkeypatch):
    now = 0.0
    monkeypatch.setattr("cdpr.ui.gui.driver.monotonic", lambda: now)
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
    monkeypatch.setattr("cdpr.ui.gui.driver.monotonic", lambda: now)
    clock = Clock()
    clock.start(0.0, speed)
    while now < 5.5 * period / speed:
        now += period / speed / 100.0
        done += clock.steps(done * period, period)
    assert done == 5
