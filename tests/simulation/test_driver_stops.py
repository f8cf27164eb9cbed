"""Stops requested of a driver: they wait neither for steps of requests nor for late slices."""

from __future__ import annotations

import pytest
from driver_client import Client, ask, nothing, resume

from cdpr.simulation.requests import Request


def test_a_stop_ends_steps_also_behind_other_requests():
    """Requests before it are executed, but no further step."""
    steps, push, more, stop = (
        Request("step", {"n": 50}),
        Request("push", {"force": [9.0, 0.0, 0.0]}),
        Request("step", {"n": 4}),
        Request("stop"),
    )

    def ask_all(driver):
        for request in (push, more, stop):
            driver.requests.put(request, replaceable=False)

    driver = Client([(8, ask_all)], paused=[nothing] * 3 + [resume])
    driver.most = 8
    driver.requests.put(steps, replaceable=False)
    run = driver.run()
    assert [each.answer for each in (steps, push, more, stop)] == [
        "step: interrupted, 34 steps remain",
        "",
        "step: interrupted, 4 steps remain",
        "",
    ]
    times = {event.kind: event.time for event in run.events}
    assert times["wrench"] == times["emergency_stop"] == pytest.approx(0.016)


def test_requests_behind_a_waiting_one_keep_the_order():
    """Only a stop overtakes others: steps, a push and a pause are executed in this order."""
    steps, push, pause = Request("step", {"n": 50}), Request("push", {"force": [9.0, 0.0, 0.0]}), Request("pause")
    driver = Client(paused=[nothing] * 8 + [resume])
    driver.most = 8
    for request in (steps, push, pause):
        driver.requests.put(request, replaceable=False)
    run = driver.run()
    assert [each.answer for each in (steps, push, pause)] == [""] * 3
    assert run.events[0].time == pytest.approx(0.05)


def test_a_stop_does_not_wait_for_slices_that_are_late():
    """Although other requests may take a small share of the time only."""
    pushes = [Request("push", {"force": [1.0, 0.0, 0.0]}) for _ in range(20)]

    def ask_all(driver):
        driver.clock.tick = 1.0  # late, and each request takes long
        for request in (*pushes, Request("stop")):
            driver.requests.put(request, replaceable=False)

    run = Client([(20, ask_all)]).run()
    assert [event.time for event in run.events if event.kind == "emergency_stop"] == [pytest.approx(0.02)]
    assert run.external[20, 0] == 20.0


def test_a_stop_ends_requested_tensions():
    late = Request("tension", {"tension": [310.0] * 8})
    script = [
        (20, ask("tension", tension=[300.0] * 8)),
        (50, ask("stop")),
        (60, lambda driver: driver.requests.put(late)),
        (70, ask("tension", tension=[])),
    ]
    driver = Client(script)
    tension = driver.run().tension
    assert (tension[20:50] == 300.0).all()
    assert (tension[50:] != 300.0).all()
    assert driver.said == [("error", "tension: the robot is stopped")] == [("error", late.answer)]
    assert (tension != 310.0).all()
