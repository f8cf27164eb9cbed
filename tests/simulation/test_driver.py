"""Driver of a running simulation with a clock that only its waits advance: no test depends on the time of a machine."""

from __future__ import annotations

from threading import Barrier, Thread

import numpy as np
import pytest
from driver_client import CAROCA, SHORT, Client, ask, nothing, resume, rows
from fake_clock import FakeClock

import cdpr
from cdpr.base.errors import CdprError, Infeasible
from cdpr.simulation import driver as module
from cdpr.simulation.driver import MOST_STEPS, WAITS, Driver
from cdpr.simulation.requests import MAX_PENDING, CommandWarning, Request, Requests


def test_a_run_takes_the_time_of_its_clock():
    for speed in (0.5, 1.0, 20.0):
        driver = Client(speed=speed)
        run = driver.run()
        assert driver.clock.time == pytest.approx(0.1 / speed, abs=1e-6)
        assert run.rows.tobytes() == rows()


def test_a_run_without_a_limit_of_speed_does_not_wait():
    driver = Client(speed=None)
    assert driver.run().status == "finished"
    assert driver.clock.time == 0.0


def test_real_time_runs_are_driven(monkeypatch, tmp_path):
    """The same rows and the same files as of a fast run."""
    clock, seen = FakeClock(), []
    monkeypatch.setattr(module, "Requests", lambda: Requests(clock))
    short = {"simulation.duration": 0.1}
    look = lambda done, total: seen.append((done, total))  # noqa: E731
    run = cdpr.simulate(CAROCA, overrides=short, real_time=True, out=tmp_path / "real", progress=look)
    cdpr.simulate(CAROCA, overrides=short, out=tmp_path / "fast")
    assert clock.time == pytest.approx(0.1, abs=1e-6)
    assert (seen[0], {total for _, total in seen}) == ((0, 101), {101})
    assert run.status == "finished"
    assert sorted(path.name for path in (tmp_path / "real").iterdir()) == ["log.mcap", "run.json", "scenario.yaml"]
    assert (tmp_path / "real" / "log.mcap").read_bytes() == (tmp_path / "fast" / "log.mcap").read_bytes()


def test_an_interrupt_while_waiting_keeps_the_samples():
    driver = Client()

    def interrupted(condition, seconds):
        driver.clock.time += seconds
        if driver.simulation.samples == 5:
            raise KeyboardInterrupt

    driver.clock.wait = interrupted
    with pytest.raises(KeyboardInterrupt) as stop:
        driver.run()
    assert (stop.value.run.status, len(stop.value.run.rows)) == ("interrupted", 5)


# Requests


def test_requests_are_events_of_the_next_step(tmp_path):
    """The saved session repeats the run."""
    script = [
        (10, ask("push", force=[50.0, 0.0, 0.0], duration=0.02)),
        (20, ask("cut", cable=2)),
        (30, ask("set", key="controller.kp", value=40.0)),
        (40, ask("target", position=[1.0, 0.32, 1.5], orientation=[1.0, 0.0, 0.0, 0.0], duration=0.02)),
        (50, ask("wrench", force=[0.0, 5.0, 0.0], moment=[0.0, 0.0, 0.0])),
        (60, ask("limits", tension_max=900.0)),
        (70, ask("tension", tension=[300.0] * 8)),
        (72, ask("tension", tension=[])),
        (80, ask("jam", cable="cable_3")),
        (90, ask("stop")),
    ]
    driver = Client(script)
    run = driver.run()
    assert driver.said == []
    times = {event.kind: event.time for event in run.events}
    assert [times[kind] for kind in ("cable_break", "set", "target", "limits")] == [0.02, 0.03, 0.04, 0.06]
    assert driver.parameters == {"controller.kp": 40.0}
    assert run.tension[70:72].tolist() == [[300.0, 0.0, *[300.0] * 6]] * 2
    driver.simulation.save(tmp_path / "session.yaml")
    assert cdpr.simulate(tmp_path / "session.yaml").rows.tobytes() == run.rows.tobytes() != rows()


def test_requests_of_many_threads_are_executed_once_each():
    driver, threads, ready = Client(), 8, Barrier(9)
    asked = [[Request("push", {"force": [float(k), 1.0, 0.0]}) for k in range(1, 9)] for _ in range(threads)]
    waiting = Request("pause")
    driver.requests.put(waiting)

    def send(mine):
        ready.wait()
        for request in mine:
            driver.requests.put(request, replaceable=False)
            request.done.wait(60.0)

    def finish():
        for each in senders:
            each.join(60.0)
        resume(driver)

    senders = [Thread(target=send, args=(mine,)) for mine in asked]
    finishing = Thread(target=finish)
    for thread in (*senders, finishing):
        thread.start()
    ready.wait()
    run = driver.run()
    finishing.join(60.0)
    assert not finishing.is_alive()
    assert all(request.done.is_set() and request.answer == "" for mine in asked for request in mine)
    assert run.external[0, :2].tolist() == [threads * 36.0, 64.0]
    assert sum(event.kind == "wrench" for event in run.events) == 64


def test_pause_step_and_resume():
    seen = []

    def step(n):
        def work(driver):
            seen.append((driver.simulation.samples, driver.paused))
            driver.requests.put(Request("step", {"n": n}))

        return work

    driver = Client([(10, ask("pause"))], paused=[step(3), step(1), resume])
    run = driver.run()
    assert seen == [(10, True), (13, True)]
    assert driver.parameters == {"paused": False}
    assert run.rows.tobytes() == rows()
    assert driver.clock.time == pytest.approx(0.1 - 0.004 + 3 * WAITS, abs=1e-6)  # four steps were made at once


def test_many_steps_are_made_in_portions_and_answered_after_the_last():
    request, later = Request("step", {"n": 50}), Request("push", {"force": [9.0, 0.0, 0.0]})
    seen = []

    def look(driver, n):
        seen.append((driver.simulation.samples, request.done.is_set()))
        if n:
            driver.requests.put(later)  # waits for the steps

    driver = Client([(16, lambda it: look(it, 1)), (24, lambda it: look(it, 0)), (50, lambda it: look(it, 0))])
    driver.most = 8
    driver.while_paused = [nothing] * 7 + [resume]
    driver.requests.put(request, replaceable=False)
    run = driver.run()
    assert seen == [(16, False), (24, False), (50, True)]
    assert (request.answer, later.answer) == ("", "")
    assert run.events[0].time == pytest.approx(0.05)


def test_an_abandoned_request_does_not_end_steps():
    abandoned, steps = Request("pause"), Request("step", {"n": 50})
    abandoned.take()
    driver = Client([(8, lambda driver: driver.requests.put(abandoned, replaceable=False))])
    driver.most, driver.while_paused = 8, [nothing] * 7 + [resume]
    driver.requests.put(steps, replaceable=False)
    driver.run()
    assert steps.answer == ""


@pytest.mark.parametrize("what", ["pause", "reset"])
def test_requests_that_interrupt_end_the_remaining_steps(what):
    request = Request("step", {"n": 50})
    driver = Client([(8, ask(what))], paused=[nothing] * 3 + [resume])
    driver.most = 8
    driver.requests.put(request, replaceable=False)
    assert driver.run().rows.tobytes() == rows()
    assert request.answer == "step: interrupted, 34 steps remain"


def test_a_pause_is_not_caught_up():
    driver = Client([(50, ask("pause"))], paused=[*[nothing] * 4, resume])
    assert driver.run().rows.tobytes() == rows()
    assert driver.clock.time == pytest.approx(0.1 + 5 * WAITS, abs=1e-6)


@pytest.mark.parametrize(("speed", "seconds"), [(2.0, 0.075), (0.1, 0.55), (1.0, 0.1), (None, 0.05)])
def test_changes_of_speed(speed, seconds):
    driver = Client([(50, ask("speed", value=speed))])
    assert driver.run().rows.tobytes() == rows()
    assert driver.parameters == {"speed": speed}
    assert driver.clock.time == pytest.approx(seconds, abs=2e-3)


def test_a_reset_during_a_pause_stays_paused_at_the_start():
    seen = []

    def look(driver):
        seen.append((driver.simulation.samples, driver.paused, driver.pushes))
        resume(driver)

    driver = Client([(20, ask("push", force=[9.0, 0.0, 0.0])), (50, ask("pause"))], paused=[ask("reset"), look])
    run = driver.run()
    assert seen == [(0, True, {})]
    assert driver.parameters["controller.kp"] == driver.simulation.scenario.options().numbers()["controller.kp"]
    assert run.rows.tobytes() == rows()


def test_a_reset_with_a_log_is_refused(tmp_path):
    driver = Driver(cdpr.Simulation(CAROCA, overrides=SHORT, out=tmp_path / "run"), Requests(FakeClock()))
    driver.requests.put(request := Request("reset"))
    assert driver.run().rows.tobytes() == rows()
    assert request.answer.startswith("reset: not possible with a log on disk")


def test_requests_after_the_end_are_refused_at_once():
    driver, late = Client(), Request("stop")
    driver.script = [(100, lambda driver: driver.requests.put(late))]  # before the last step, too late to be executed
    driver.run()
    after = Request("push", {"force": [1.0, 0.0, 0.0]})
    driver.requests.put(after, replaceable=False)
    assert after.done.is_set()
    assert after.answer == "the run is over"
    assert late.done.is_set()


def test_a_closed_queue_answers_all_requests():
    requests, said = Requests(FakeClock()), []

    def reply(level, text):
        requests.put(Request("again"))  # a client may send from its reply
        said.append((level, text))

    requests.put(Request("step", reply=reply), replaceable=False)
    requests.close("over")
    requests.put(Request("step", reply=reply), replaceable=False)
    assert said == [("error", "over")] * 2


def test_a_client_that_dies_leaves_the_run_as_it_was():
    """It waits no longer: its request is abandoned, and executed never."""
    abandoned, replaced, last = (Request("push", {"force": [x, 0.0, 0.0]}) for x in (9.0, 8.0, 7.0))
    driver = Client()
    driver.requests.put(abandoned, replaceable=False)
    assert abandoned.take()
    driver.requests.put(replaced)
    driver.requests.put(last)
    run = driver.run()
    assert run.external[0, :3].tolist() == [7.0, 0.0, 0.0]
    assert replaced.done.is_set()
    assert (replaced.answer, last.answer) == ("replaced by a later request", "")
    assert not abandoned.done.is_set()


def test_refusals_change_nothing():
    bad = [
        (("fly", {}), "'fly' is not an allowed request"),
        (("step", {"n": 0}), f"step: expected a whole number from 1 to {MOST_STEPS}, got 0"),
        (("speed", {"value": 0.0}), "speed: expected a number from 0.001 to 1e+06, got 0.0"),
        (("speed", {"value": True}), "speed: expected a number from 0.001 to 1e+06, got true"),
        (("release", {"id": 7}), "release: that push has ended, or that body is released"),
        (("release", {}), "release: missing a required argument: 'id'"),
        (("release", {"number": 7}), "release: unknown argument 'number'; expected id"),
        (("cut", {"cable": 99}), "cut: cable: cables are numbered from 1 to 8, got 99"),
        (("wrench", {"force": [1.0, 2.0], "moment": [0.0] * 3}), "wrench: force: the shape must be (3,), got (2,)"),
        (("tension", {"tension": [1.0]}), "tension: the shape must be (8,), got (1,)"),
    ]
    asked = [Request(what, values) for (what, values), _ in bad]
    driver = Client([(10, lambda driver: [driver.requests.put(each, replaceable=False) for each in asked])])
    run = driver.run()
    assert [text for _, text in driver.said] == [each.answer for each in asked] == [text for _, text in bad]
    assert run.rows.tobytes() == rows()
    with pytest.raises(CdprError, match=r"^speed: expected a number"):
        Client(speed=float("nan"))


def test_a_request_that_ends_the_run_raises():
    driver = Client([(10, ask("step", n=90))], **{"solver.infeasible": "stop"})
    driver.script.insert(0, (5, ask("limits", tension_max=60.0)))
    with pytest.raises(Infeasible) as stop:
        driver.run()
    assert stop.value.run.status == "infeasible"


def test_pushes_are_released_by_number():
    ended = []
    script = [
        (10, ask("push", force=[1.0, 0.0, 0.0])),
        (20, ask("push", force=[2.0, 0.0, 0.0], duration=0.005)),
        (40, lambda driver: ended.extend(key for key, _ in driver.acting())),
        (50, ask("release", id=1)),
    ]
    driver = Client(script)
    run = driver.run()
    assert driver.said == []
    assert ended == [1]
    assert run.external[[5, 15, 22, 30, 60], 0].tolist() == [0.0, 1.0, 3.0, 1.0, 0.0]


def test_the_first_doubtful_target_causes_a_warning():
    driver = Client()
    far = [driver.request_target([90.0 + k, 0.0, 1.0], [1, 0, 0, 0]) for k in range(2)]
    assert isinstance(far[0], CommandWarning)
    assert far[0].startswith("target: lies outside the frame")
    assert far[1] is None
    driver.simulation.close()


def test_the_queue_is_bounded():
    requests = Requests(FakeClock())
    for _ in range(MAX_PENDING):
        requests.put(Request("step"), replaceable=False)
    with pytest.raises(CdprError, match=f"^step: rejected: {MAX_PENDING} requests are pending"):
        requests.put(Request("step"), replaceable=False)
    requests.put(Request("stop"), replaceable=False)  # one place is kept for it
    with pytest.raises(CdprError, match=r"^stop: rejected"):
        requests.put(Request("stop"), replaceable=False)
    requests.put(Request("pause"))  # of the driver's own thread: replaced, not counted
    assert sum(1 for _ in iter(requests.get, None)) == MAX_PENDING + 2


def test_a_driver_without_a_simulation_refuses():
    driver = Driver(requests=Requests(FakeClock()))
    driver.answer(request := Request("step"))
    assert request.answer == "not simulated: correct the errors and apply, or reset"
    driver.request_speed(3.0)
    simulation = cdpr.Simulation(CAROCA, overrides=SHORT)
    driver.attach(simulation)
    assert np.array_equal(driver.run().rows, cdpr.simulate(CAROCA, overrides=SHORT).rows)
    assert driver.clock.time == pytest.approx(0.1 / 3.0, abs=1e-6)
