"""Pacing of a simulation: how many slices are due by a clock."""

from __future__ import annotations

import pytest
from fake_clock import FakeClock

from cdpr.simulation.clock import LATE, Pacing, next_portion

STEP = 0.001


def pacing(speed=1.0, slice=STEP, time=0.0):
    made = Pacing(FakeClock(), speed)
    made.slice = slice
    made.start(time)
    return made, made._clock


def test_slices_are_due_at_their_time():
    made, clock = pacing(time=1.0)
    assert made.when(1.0) == pytest.approx(STEP)
    assert made.slices(1.0) == 0
    clock.time = 0.0105
    assert made.slices(1.0) == 10
    assert made.slices(1.01) == 0


def test_short_delays_are_caught_up_and_long_ones_are_not():
    made, clock = pacing()
    clock.time = 0.9 * LATE
    assert made.slices(0.0) == 450
    clock.time = 10.0  # the machine slept
    assert made.slices(0.45) == 1
    clock.time = 10.001
    assert made.slices(0.451) == 1


@pytest.mark.parametrize(("speed", "slice"), [(1.0, 2.0), (0.1, 0.1), (0.001, 0.001), (1000.0, 0.1)])
def test_slices_that_take_long_by_the_clock_are_waited_for(speed, slice):
    made, clock = pacing(speed, slice)
    done = 0
    while clock.time < 5.5 * slice / speed:
        clock.time += slice / speed / 100.0
        done += made.slices(done * slice)
    assert done == 5


def test_repeated_changes_of_speed_do_not_delay():
    made, clock = pacing(1.0, slice=1.0)
    for speed in [1.0, 3.0] * 50:
        made.change(speed, 0.0)
        clock.time += 0.01
    assert made.slices(0.0) == 2  # s: half of the time at each speed
    assert made.when(2.0) == pytest.approx(clock.time + 1.0 / 3.0)


@pytest.mark.parametrize(
    ("steps", "seconds", "size"), [(4, 0.4, 8), (40, 0.4, 64), (4, 0.5, 4), (4, 1.0, 4), (4, 1.1, 2), (1, 9.0, 1)]
)
def test_the_size_of_portions_stays_within_a_band_of_durations(steps, seconds, size):
    assert next_portion(steps, seconds, limit=1.0, most=64) == size


def test_no_limit_of_speed_is_always_due():
    made, clock = pacing(None)
    assert made.slices(0.0) is None
    assert made.when(5.0) < clock.time
    assert made.factor(0.0) is None
    clock.time = 1.0
    assert made.factor(0.5) == 0.5
    made.change(1.0, 3.0)  # continues from the present time
    assert made.slices(3.0) == 0
    clock.time = 1.1
    assert made.slices(3.0) == 100


def test_the_real_time_factor_is_that_of_the_last_second():
    made, clock = pacing(2.0)
    assert made.factor(0.0) == 2.0
    clock.time = 0.9
    assert made.factor(0.1) == 2.0
    clock.time = 1.25
    assert made.factor(0.5) == 0.4
    clock.time = 2.25
    assert made.factor(1.75) == 1.25
