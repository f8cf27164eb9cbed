"""Driver of a live simulation, with a link that sends requests at given samples: no server, thread or clock."""

from __future__ import annotations

import json

import numpy as np
import pytest
from conftest import ROOT
from fake_clock import FakeClock

import cdpr
from cdpr.base.errors import CdprError
from cdpr.log.ros2 import encode
from cdpr.simulation.requests import Request, Requests
from cdpr.ui.live import messages
from cdpr.ui.live.drive import drive
from cdpr.ui.live.received_messages import PAYLOAD, TARGET, WRENCH, request_of

FAST = 1e6  # times real time: never waits
SLICE = 0.01  # s, of the samples at which the link is shown one
REST = [400.0, 401.0, 402.0, 403.0, 404.0, 405.0, 406.0, 407.0]  # N, each another


class Script:
    """Link that sends one request after another, each once a sample is shown, or a later one: (sample, request)."""

    def __init__(self, asked, clock=None):
        self.requests = Requests(clock or FakeClock(tick=1.0))  # so that every slice is shown, though it is fast
        self.asked, self.samples, self.said = list(asked), [], []

    def begin(self, header):
        self.cables = header.cables

    def show(self, row, sample, header):
        self.samples.append(sample)
        self.header = header
        if self.asked and sample >= self.asked[0][0]:
            self.requests.put(self.asked.pop(0)[1])

    def changed(self, parameters):
        pass

    def refused(self, text):
        self.said.append(text)

    def warned(self, text):
        self.said.append(text)


def scenario(duration):
    return cdpr.load_scenario(ROOT / "scenarios" / "caroca.yaml", overrides={"simulation.duration": duration})


def driven(asked, duration=0.1):
    link = Script(asked)
    return drive(scenario(duration), link, speed=FAST, rate=1.0 / SLICE), link


def wrench(*force):
    return Request("wrench", {"force": list(force), "moment": [0.0, 0.0, 0.0]})


def test_a_wrench_takes_the_place_of_the_one_before():
    run, link = driven([(9, wrench(10.0, 0.0, 0.0)), (29, wrench(0.0, 7.0, 0.0)), (59, wrench(0.0, 0.0, 0.0))])
    assert link.said == []
    assert link.samples[:4] == [9, 19, 29, 39]
    felt = [run.external[k, :3].tolist() for k in (5, 20, 45, 80)]
    assert felt == [[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [0.0, 7.0, 0.0], [0.0, 0.0, 0.0]]


def test_samples_have_the_header_after_a_cut():
    _, link = driven([(29, Request("cut", {"cable": "cable_4"}))])
    assert link.said == []
    assert link.header.broken == ((3, 0.03),)


def test_tensions_go_to_the_cables_that_are_named():
    names = [f"cable_{k}" for k in (3, 1, 2, 8, 4, 5, 6, 7)]  # no permutation that is its own inverse
    run, link = driven([(9, Request("tension", {"tension": REST, "names": names}))])
    assert link.said == []
    assert dict(zip(link.cables, run.tension[50].tolist(), strict=True)) == dict(zip(names, REST, strict=True))


@pytest.mark.parametrize(
    ("names", "count"), [(["cable_1"] * 8, 8), ([f"cable_{k}" for k in range(8)], 8), (["cable_1"], 1)]
)
def test_names_that_are_not_the_cables_are_refused(names, count):
    run, link = driven([(9, Request("tension", {"tension": REST[:count], "names": names}))])
    assert len(link.said) == 1
    assert "one for each of cable_1, cable_2" in link.said[0]
    assert np.array_equal(run.rows, cdpr.simulate(scenario(0.1)).rows)


def test_restarts_drop_pending_requests():
    asked = [(9, Request("tension", {"tension": REST})), (19, wrench(10.0, 0.0, 0.0)), (39, Request("reset"))]
    run, link = driven(asked)
    assert link.said == []
    assert sorted(link.samples) != link.samples
    assert np.array_equal(run.rows, cdpr.simulate(scenario(0.1)).rows)


def test_a_wrench_after_a_reset_is_the_first():
    """The one before it ended with the run in which it was."""
    asked = [(9, wrench(10.0, 0.0, 0.0)), (29, Request("reset")), (49, wrench(0.0, 7.0, 0.0))]
    run, link = driven(asked)
    assert link.said == []
    assert run.external[70, :3].tolist() == [0.0, 7.0, 0.0]


def test_a_target_far_away_is_warned_of_once_and_followed():
    def target(x):
        return Request("target", {"position": [x, 0.0, 1.0], "orientation": [1.0, 0.0, 0.0, 0.0], "duration": 0.05})

    run, link = driven([(9, target(90.0)), (19, target(91.0)), (39, target(0.5)), (59, target(92.0))])
    assert len(link.said) == 2
    assert all(text.startswith("target: lies outside the frame: its anchors go from x = ") for text in link.said)
    assert link.said[1].endswith("here x = 92 m")
    assert sum(event.kind == "target" for event in run.events) == 4


def test_external_wrenches_suppress_the_warning_of_distant_targets():
    far = Request("target", {"position": [9.0, 0.0, 1.0], "orientation": [1.0, 0.0, 0.0, 0.0]})
    _, link = driven([(9, wrench(10.0, 0.0, 0.0)), (29, far)])
    assert link.said == []


@pytest.mark.parametrize("speed", [0.5, 1.0, 4.0])
def test_it_goes_so_many_times_as_fast_as_the_clock(speed):
    clock = FakeClock()
    drive(scenario(0.2), Script([], clock), speed=speed, rate=1.0 / SLICE)
    assert clock.time == pytest.approx(0.2 / speed, abs=1.5 * SLICE / speed)


def test_lost_time_is_not_caught_up():
    """After a suspension of the machine the run continues at the requested speed."""
    clock = FakeClock()
    link = Script([], clock)
    show = link.show

    def sleepy(row, sample, header):
        show(row, sample, header)
        if len(link.samples) == 10:
            clock.time += 5.0

    link.show = sleepy
    drive(scenario(0.2), link, speed=1.0, rate=1.0 / SLICE)
    assert clock.time == pytest.approx(5.0 + 0.2, abs=2.5 * SLICE)


class Flood(Requests):
    """Requests without end, each of which takes `takes` (s)."""

    def __init__(self, takes):
        super().__init__(FakeClock())
        self.takes, self.count = takes, 0

    def get(self, timeout=0.0):
        self.clock.time += self.takes
        self.count += 1
        return Request("wrench", {"force": [1.0, 0.0, 0.0], "moment": [0.0, 0.0, 0.0]})


@pytest.mark.slow
@pytest.mark.parametrize("takes", [1e-5, 1e-4, 0.004])
def test_a_flood_takes_a_small_share_of_a_run_that_is_late(takes):
    link, slices, slow = Script([]), 1000, 0.002  # s that a slice takes
    link.requests = flood = Flood(takes)

    def look(done, total):
        flood.clock.time += slow

    drive(scenario(slices * SLICE), link, speed=FAST, rate=1.0 / SLICE, progress=look)
    assert flood.count > 10
    assert flood.clock.time < 1.1 * slices * slow  # `SHARE`, and what the first took


# Displayed values


def test_the_path_is_shown_once_a_second_and_to_the_first_at_once(monkeypatch):
    clock = [0.0]
    monkeypatch.setattr(messages, "monotonic", lambda: clock[0])
    run = cdpr.simulate(scenario(0.01))
    made = messages.Messages(run.header)
    path = [topic.name for topic in made.topics].index("/cdpr/desired_path")
    nobody = [False] * len(made.topics)
    other, all_ = [k == 0 for k in range(len(nobody))], [True] * len(nobody)

    def shown(time, wanted):
        clock[0] = time
        return path in [k for k, _ in made.of(run.rows[3], 3, wanted)]

    assert not shown(0.0, other)
    assert shown(0.1, all_)  # the first
    assert not shown(0.2, all_)
    assert not shown(1.05, all_)
    assert shown(1.11, all_)  # who came meanwhile
    assert not shown(1.2, all_)
    assert not shown(1.3, other)
    assert shown(1.4, all_)  # the first again


# Received messages


def stamped(topic, frame="world", **parts):
    return request_of(topic, "json", json.dumps({"header": {"frame_id": frame}, **parts}).encode())


def test_quaternions_of_messages_have_the_scalar_last():
    turned = {"x": 0.1, "y": 0.3, "z": 0.5, "w": 0.65**0.5}
    request = stamped(TARGET, pose={"position": {"x": 1.0, "y": 2.0, "z": 3.0}, "orientation": turned})
    assert request.values["position"] == [1.0, 2.0, 3.0]
    assert request.values["orientation"] == pytest.approx([0.65**0.5, 0.1, 0.3, 0.5])


def test_messages_are_of_the_world():
    push = {"force": {"x": 1.0, "y": 2.0, "z": 3.0}, "torque": {"x": 4.0, "y": 5.0, "z": 6.0}}
    wanted = {"force": [1.0, 2.0, 3.0], "moment": [4.0, 5.0, 6.0]}
    assert stamped(WRENCH, wrench=push).values == wanted
    assert stamped(WRENCH, "", wrench=push).values == wanted
    with pytest.raises(CdprError, match="expected 'world', or none, got 'platform'"):
        stamped(WRENCH, "platform", wrench=push)


def payload(mass, **more):
    message = {"inertia": {"m": mass, "com": {"z": -0.1}, "ixx": 0.1, "iyy": 0.2, "izz": 0.25, "ixy": 0.01, **more}}
    return request_of(PAYLOAD, "json", json.dumps(message).encode())


def test_a_payload_takes_the_place_of_the_one_before_and_the_session_repeats_it(tmp_path):
    asked = [(9, payload(2.0)), (29, payload(3.0)), (39, payload(3.0)), (59, payload(0.0)), (69, payload(0.0))]
    link = Script(asked)
    run = drive(scenario(0.1), link, out=str(tmp_path / "run"), speed=FAST, rate=1.0 / SLICE)
    assert link.said == []
    found = [(event.mass, event.center, event.inertia) for event in events_of(tmp_path)]
    tensor = (0.1, 0.2, 0.25, 0.01, 0.0, 0.0)
    assert found == [(2.0, (0.0, 0.0, -0.1), tensor), (3.0, (0.0, 0.0, -0.1), tensor)]
    assert [(round(event.time, 6), round(event.until, 6)) for event in run.events] == [(0.01, 0.03), (0.03, 0.06)]
    assert cdpr.simulate(tmp_path / "run" / "session.yaml").rows.tobytes() == run.rows.tobytes()


def events_of(folder):
    return cdpr.load_scenario(folder / "run" / "session.yaml").events


def test_an_impossible_payload_keeps_the_one_before(tmp_path):
    link = Script([(9, payload(2.0)), (29, payload(3.0, izz=5.0))])
    run = drive(scenario(0.1), link, out=str(tmp_path / "run"), speed=FAST, rate=1.0 / SLICE)
    assert "the largest exceeds the sum of the two others" in link.said[0]
    assert [event.mass for event in events_of(tmp_path)] == [2.0]
    assert run.events[0].until is None or run.events[0].until == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("message", "text"),
    [
        ({}, "/cdpr/payload: inertia: required but not given"),
        ({"inertia": {}}, "/cdpr/payload: inertia.m: required but not given: the mass"),
        ({"inertia": {"m": 1.0, "ixx": "1"}}, "/cdpr/payload: inertia.ixx: expected a finite number, got '1'"),
        (
            {"header": {"frame_id": "world"}, "inertia": {"m": 1.0}},
            "/cdpr/payload: header.frame_id: expected 'platform', or none, got 'world'",
        ),
    ],
)
def test_invalid_payloads(message, text):
    with pytest.raises(CdprError, match=text):
        request_of(PAYLOAD, "json", json.dumps(message).encode())


def test_payloads_in_ros_messages():
    inertia = {"m": 2.0, "com": {"x": 0.1, "y": 0.2, "z": 0.3}}
    inertia |= dict(zip(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), np.arange(1.0, 7.0).tolist(), strict=True))
    data, _ = encode("geometry_msgs/InertiaStamped", {"header": {"frame_id": "platform"}, "inertia": inertia})
    values = request_of(PAYLOAD, "cdr", data).values
    assert values == {"mass": 2.0, "center": [0.1, 0.2, 0.3], "inertia": [1.0, 4.0, 6.0, 2.0, 3.0, 5.0]}
