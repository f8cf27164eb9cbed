"""Requests during a simulation: in order, once, and without harm to the run."""

from __future__ import annotations

import threading
import time
from itertools import pairwise

import pytest
from fake_clock import FakeClock
from live_cases import CAROCA, QUIET, quiet
from live_client import FILE, RUN_TIMEOUT
from live_link import Quiet

import cdpr
from cdpr.base.errors import CdprError, Infeasible
from cdpr.simulation import session
from cdpr.simulation.requests import MAX_PENDING, Request, Requests
from cdpr.ui.live import sender
from cdpr.ui.live.drive import LiveDriver, drive
from cdpr.ui.live.received_messages import TENSION, WRENCH, request_of

FAST = 1e6  # times real time
OFTEN = 0.01  # s, much shorter than driver.WAITS


def loaded(duration, **overrides):
    return cdpr.load_scenario(FILE, overrides={"simulation.duration": duration, **overrides})


def driven(link, duration=0.3, speed=FAST, rate=60.0, look=None, **overrides):
    """Drive to the end, and return the run; `look` is called as progress is."""
    try:
        return drive(loaded(duration, **overrides), link, speed=speed, rate=rate, progress=look)
    finally:
        link.close()


@pytest.mark.slow
def test_endless_requests_do_not_block_the_loop():
    link, looked, over = Quiet(), [], time.monotonic() + 0.7
    link.requests.put(Request("pause"))

    def ask():
        while time.monotonic() < over:
            link.requests.put(Request("pause"))
            time.sleep(OFTEN)
        link.requests.put(Request("pause", {"paused": False}))

    asking = threading.Thread(target=ask)
    asking.start()
    driven(link, 0.05, look=lambda done, total: looked.append(time.monotonic()))
    asking.join(RUN_TIMEOUT)
    assert max(after - before for before, after in pairwise(looked)) < 0.5


@pytest.mark.parametrize("values", [{"speed": 0.001, "rate": 60.0}, {"speed": 1.0, "rate": 0.1}])
def test_it_looks_up_however_slow_it_goes(values):
    looked = []

    def look(done, total):
        looked.append(done)
        if len(looked) == 4:
            raise cdpr.Interrupted

    begun = time.monotonic()
    with pytest.raises(cdpr.Interrupted):
        driven(Quiet(), 20.0, look=look, **values)
    assert time.monotonic() - begun < 5.0


def test_requests_are_executed_soon_at_any_display_rate():
    link, push = Quiet(), Request("wrench", {"force": [1.0, 0.0, 0.0], "moment": [0.0, 0.0, 0.0]})
    run = driven(link, rate=0.1, look=lambda done, total: link.requests.put(push) if 0 < done < 30 else None)
    assert run.events[0].time < 0.05
    assert len(link.told) == 2  # at once, and at the end


@pytest.mark.slow
def test_samples_are_shown_at_the_given_rate():
    for rate, least in ((50.0, 14), (1000.0, 290)):
        link = Quiet()
        driven(link, speed=1.0, rate=rate)
        assert least <= len(set(link.told)) <= 0.3 * rate + 2
        assert link.told[-1] == 300


def test_abandoned_requests_are_never_executed(monkeypatch):
    monkeypatch.setattr(sender, "ANSWERS", OFTEN)
    link = Quiet()
    assert "the request is discarded" in link.call("stop")
    assert driven(link, 0.05).events == ()


def test_a_request_that_an_interrupted_run_took_does_not_block_its_sender(monkeypatch):
    monkeypatch.setattr(sender, "ANSWERS", OFTEN)
    link, request = Quiet(), Request("stop")
    request.take()
    link.close()
    assert link.submit(request) == "the run ended before it answered"


def test_the_newest_unclaimed_message_is_kept():
    waiting, first = Requests(), Request("wrench", {"k": -1})
    waiting.put(first)
    for k in range(100):
        waiting.put(Request("wrench", {"k": k}))
        waiting.put(Request("set", {"key": "a", "k": k}))
        waiting.put(Request("set", {"key": "b", "k": k}))
        if k == 50:
            waiting.put(Request("step"), replaceable=False)  # with what was set before
    found = list(iter(waiting.get, None))
    told = [(one.what, one.values.get("key"), one.values.get("k")) for one in found]
    values = [("wrench", None), ("set", "a"), ("set", "b")]
    assert told == [(*one, 50) for one in values] + [("step", None, None)] + [(*one, 99) for one in values]
    assert first.done.is_set()  # who set it, too, need wait no more
    assert first.answer == "replaced by a later request"


def test_messages_for_other_cables_are_all_kept():
    waiting = Requests()
    for k in range(3):
        for names in (["A"], ["B"], []):
            waiting.put(Request("winch_command", {"names": names, "rate": [k]}))
    found = [(one.values["names"], one.values["rate"]) for one in iter(waiting.get, None)]
    assert found == [(["A"], [2]), (["B"], [2]), ([], [2])]
    for k in range(MAX_PENDING):
        waiting.put(Request("winch_command", {"names": [str(k)]}))
    with pytest.raises(CdprError, match=f"^winch_command: rejected: {MAX_PENDING} requests are pending"):
        waiting.put(Request("winch_command", {"names": ["one more"]}))
    waiting.put(Request("winch_command", {"names": ["7"]}))


def test_a_stop_is_possible_however_much_was_done(monkeypatch):
    monkeypatch.setattr(session, "MAX_EVENTS", 4)
    with quiet() as sim:
        pushes = [sim.push([k, 0, 0]) for k in range(1, 4)]
        with pytest.raises(CdprError, match="holds 4 events at most, of which the last is kept for a stop"):
            sim.push([9, 0, 0])
        sim.step(3)
        sim.release(pushes[0])
        sim.stop()
        with pytest.raises(CdprError, match="stop: a scenario holds 4 events at most, which already exist"):
            sim.stop()


def test_a_repeated_wrench_is_one_event():
    driver = LiveDriver(cdpr.load_scenario(CAROCA, overrides=QUIET), None, Quiet(), 1.0, 60.0)
    for force in (5.0, 5.0, 7.0, 7.0, 0.0, 0.0):
        driver.request_wrench([force, 0.0, 0.0], [0.0, 0.0, 0.0])
        driver.step(3)
    run = driver.simulation.run()
    told = [(event.text[:24], event.time, event.until) for event in run.events if event.kind == "wrench"]
    assert [part[1:] for part in told] == [(0.0, 0.006), (0.006, 0.012)], told
    assert run.external[:, 0].tolist()[:13] == [5.0] * 6 + [7.0] * 6 + [0.0]


def test_a_run_that_ends_in_a_requested_step_has_ended():
    link = Quiet()
    link.requests.put(Request("step", {"n": 200}))
    limits = {"events": [{"type": "limits", "time": 0.05, "max": 60.0}]}
    with pytest.raises(Infeasible) as raised:
        driven(link, **limits, **{"solver.infeasible": "stop"})
    assert raised.value.run.status == "infeasible"


def test_repeated_speed_commands_have_no_effect():
    link = Quiet()
    begun = time.monotonic()
    look = lambda done, total: link.requests.put(Request("speed", {"value": 1.0}))  # noqa: E731
    driven(link, speed=1.0, look=look)
    assert time.monotonic() - begun > 0.25


def test_parameters_keep_their_values():
    scenario = loaded(0.3)
    numbers = scenario.options().numbers()
    link, kp = Quiet(numbers), numbers["controller.kp"]
    link.requests = Requests(FakeClock())
    driver = LiveDriver(scenario, None, link, 20.0, 60.0)
    seen = []

    def look(done, total):
        seen.append(dict(link.parameters))
        if len(seen) == 2:
            link.requests.put(Request("set", {"key": "controller.kp", "value": 2.0 * kp}))
            link.requests.put(Request("step"), replaceable=False)
            link.requests.put(Request("set", {"key": "controller.kp", "value": -1.0}))
        if seen[-1]["paused"]:
            link.requests.put(Request("reset"))
            link.requests.put(Request("speed", {"value": 10}))
            link.requests.put(Request("pause", {"paused": False}))

    driver.run(look)
    link.close()
    told = [(one["paused"], one["speed"], one["controller.kp"]) for one in seen]
    assert told[:2] == [(False, 20.0, kp)] * 2
    paused = told.index((True, 20.0, 2.0 * kp))
    assert told[paused + 1] == told[-1] == (False, 10.0, kp)
    assert len(link.said) == 1
    assert link.said[0].startswith("controller.kp: set: value: must be at least 0")


@pytest.mark.parametrize(("name", "value"), [("speed", 0.0), ("speed", float("nan")), ("rate", 1e9)])
def test_an_impossible_speed_is_reported(name, value):
    with pytest.raises(CdprError, match=f"^{name}: expected a number from .*, got "):
        driven(Quiet(), **{name: value})


def test_rejections_are_short_and_on_one_line():
    link = Quiet()
    link.refused(f"\x1b]0;a\n{'b' * 10**6}")
    assert link.said[0].startswith("\\x1b]0;a\\nbbb")
    assert len(link.said[0]) < 600
    for k in range(1000):
        link.refused(str(k))
    link.close()
    assert len(link.said) == sender.MOST_REPORTED + 1
    assert link.said[-1] == f"{1001 - sender.MOST_REPORTED} more requests were rejected"


@pytest.mark.parametrize("number", [b"1" + b"0" * 400, b"-1e999", b"1" * 5000, b"Infinity"])
def test_numbers_beyond_all_bounds_are_reported(number):
    for topic, text in ((WRENCH, b'{"wrench": {"force": {"x": %s}, "torque": {}}}'), (TENSION, b'{"effort": [%s]}')):
        with pytest.raises(CdprError, match=f"^{topic}: .*: expected a finite number, got -?inf"):
            request_of(topic, "json", text % number)


def test_addresses_are_those_of_urls():
    assert [Quiet(host=host).address for host in ("127.0.0.1", "::1", "[::1]")] == ["127.0.0.1:7", "[::1]:7", "[::1]:7"]


@pytest.mark.parametrize("host", ["", "a b", "x\ny", "256.0.0.1", "127.0.0.1:80", "a" * 300])
def test_an_impossible_host_is_reported(host):
    with pytest.raises(CdprError, match=r"^--live-host: expected the name or number of a machine, .* got '.*"):
        Quiet(host=host)
