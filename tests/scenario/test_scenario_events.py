"""Section `events`: allowed content, and error messages."""

from __future__ import annotations

import pytest
import yaml
from scenario_cases import HOLD, TEXTS, line_of, load, problem, problems, whole

import cdpr
from cdpr.scenario.events import ScenarioEvent, first_sample

pytestmark = pytest.mark.core


def with_events(*events):
    return whole(HOLD + "events:\n" + "".join(f"- {event}\n" for event in events))


def test_every_kind_is_read_and_cables_get_their_names():
    events = load(TEXTS["events"]).events
    assert [event.type for event in events] == [
        "wrench",
        "sine",
        "limits",
        "cable_jam",
        "cable_break",
        "target",
        "target",
        "set",
        "emergency_stop",
    ]
    assert [event.cable for event in events[2:5]] == ["left", "cable_2", "cable_2"]
    assert events[0].force == (100.0, 0.0, 0.0)
    assert events[6].position == (1.0, 0.0, 1.0)
    assert events[7].value == [1, 2, 3, 4, 5, 6.5]
    assert events[8].stopping_time == 0.75


def test_none_by_default():
    assert load().events == ()
    assert load().resolved_yaml().count("events: []") == 1


def test_the_resolved_scenario_holds_them():
    scenario = load(TEXTS["events"])
    again = load(scenario.resolved_yaml())
    assert again == scenario
    assert again.events == scenario.events


@pytest.mark.parametrize(
    ("event", "key", "text"),
    [
        (
            "{time: 1}",
            "events[0].type",
            "required but not given; allowed: wrench, sine, cable_break, cable_jam, limits",
        ),
        ("{type: snap, time: 1}", "events[0].type", "unknown type 'snap': allowed: wrench, sine, cable_break"),
        ("{type: cable_brake, time: 1}", "events[0].type", "did you mean 'cable_break'?"),
        ("{type: cable_break, time: 1}", "events[0].cable", "required but not given: name of the cable, or its number"),
        ("{type: cable_break, cable: left}", "events[0].time", "required but not given: time of the event"),
        ("{type: cable_break, time: -1, cable: left}", "events[0].time", "must be at least 0 (s), got -1"),
        (
            "{type: cable_break, time: 1, cable: lift}",
            "events[0].cable",
            "unknown cable 'lift': did you mean 'left'?",
        ),
        ("{type: cable_break, time: 1, cable: x}", "events[0].cable", "allowed: left, cable_2, cable_3"),
        ("{type: cable_break, time: 1, cable: 0}", "events[0].cable", "cables are numbered from 1 to 3, got 0"),
        ("{type: cable_break, time: 1, cable: 4}", "events[0].cable", "cables are numbered from 1 to 3, got 4"),
        ("{type: cable_break, time: 1, cable: 1.5}", "events[0].cable", "expected a text or a whole number, got 1.5"),
        ("{type: cable_jam, time: 0, cable: left}", "events[0].time", "must be greater than 0 (s), got 0"),
        ("{type: cable_jam, time: 1e-13, cable: left}", "events[0].time", "must be at least control_step"),
        ("{type: wrench, time: 1}", "events[0]", "force (N) or moment (N m) is missing, or both"),
        ("{type: wrench, force: [1, 2]}", "events[0].force", "expected 3 numbers (N), got 2"),
        ("{type: wrench, moment: [0, 0, 1], duration: 0.0005}", "events[0].duration", "must be at least control_step"),
        ("{type: wrench, moment: [0, 0, 1], frequency: 2}", "events[0].frequency", "unknown key 'frequency'"),
        ("{type: sine, moment: [0, 0, 1]}", "events[0].frequency", "required but not given: frequency"),
        ("{type: sine, force: [1, 0, 0], frequency: 500}", "events[0].frequency", "half of the control rate, 500 (Hz)"),
        ("{type: limits, time: 1}", "events[0]", "min or max is missing, or both: the new limits (N)"),
        ("{type: limits, time: 1, min: -1}", "events[0]", "min must be at least 0 (N), got -1: a cable cannot push"),
        ("{type: limits, time: 1, max: 45}", "events[0]", "cable 'cable_2' would have the limits 50 to 45 (N)"),
        ("{type: limits, time: 1, cable: left, max: 0}", "events[0]", "cable 'left' would have the limits 40 to 0 (N)"),
        ("{type: target, time: 1, duration: 1}", "events[0]", "position (m), orientation, or both are required"),
        ("{type: target, time: 1, position: [1, 0, 1]}", "events[0]", "expected either duration (s) or limits"),
        ("{type: target, time: 1, position: [1, 0, 1], duration: 1e-4}", "events[0].duration", "or it is a jump"),
        (
            "{type: target, time: 1, position: [1, 0, 1], limits: {velocity: 1, acceleration: 1}}",
            "events[0].limits.jerk",
            "required but not given",
        ),
        (
            "{type: target, time: 1, position: [1, 0, 1], duration: 1, angular_limits: "
            "{velocity: 1, acceleration: 1, jerk: 1}}",
            "events[0]",
            "angular_limits go with limits",
        ),
        ("{type: set, time: 1, key: controller.kq, value: 1}", "events[0].key", "did you mean 'controller.kp'?"),
        (
            "{type: set, time: 1, key: controller.limit, value: 1}",
            "events[0].key",
            "allowed: controller.kp, controller.kd",
        ),
        ("{type: set, time: 1, key: controller.kp, value: hard}", "events[0].value", "expected a number or 6 numbers"),
        ("{type: set, time: 1, key: controller.kp}", "events[0].value", "required but not given"),
        ("{type: outside, file: nowhere.csv}", "events[0].file", "there is no file 'nowhere.csv'"),
        ("{type: outside, file: /nowhere.csv}", "events[0].file", "expected a file name relative to this file"),
        ("{type: emergency_stop, time: 1, category: 3}", "events[0].category", "must be at most 2, got 3"),
        ("{type: emergency_stop, time: 1, stopping_time: 0}", "events[0].stopping_time", "must be greater than 0 (s)"),
    ],
)
def test_errors_are_reported_at_their_position(event, key, text):
    file = with_events(event)
    line = problem(file)
    assert line.startswith(f"a.yaml:{line_of(file, event)}:")
    assert f" {key}: " in line
    assert text in line


@pytest.mark.parametrize(
    ("events", "key", "text"),
    [
        (
            ["{type: cable_break, time: 2, cable: 1}", "{type: cable_break, time: 1, cable: left}"],
            "events[0]",
            "cable 'left' is broken already, since 1 s",
        ),
        (
            ["{type: cable_jam, time: 1, cable: 1}", "{type: cable_jam, time: 2, cable: 1}"],
            "events[1]",
            "cable 'left' is jammed already, since 1 s",
        ),
        (
            ["{type: cable_break, time: 1, cable: 1}", "{type: limits, time: 2, cable: 1, min: 60}"],
            "events[1]",
            "cable 'left' is broken already, since 1 s",
        ),
        (
            ["{type: limits, time: 1, min: 60}", "{type: limits, time: 1, cable: 2, min: 70}"],
            "events[1]",
            "min of cable 'cable_2' becomes 70 N, and 60 N (of all cables) by another event at the same time, 1 s",
        ),
        (
            ["{type: limits, time: 1, cable: 2, max: 700}", "{type: limits, time: 1, cable: cable_2, max: 800}"],
            "events[1]",
            "max of cable 'cable_2' becomes 800 N, and 700 N (of cable 'cable_2') by another event at",
        ),
        (
            ["{type: limits, time: 1, min: 900}", "{type: limits, time: 2, max: 800}"],
            "events[1]",
            "cable 'left' would have the limits 900 to 800 (N)",
        ),
        (
            ["{type: emergency_stop, time: 1}", "{type: emergency_stop, time: 2}"],
            "events[1]",
            "the robot has stopped already at 1 s",
        ),
        (
            ["{type: emergency_stop, time: 1}", "{type: target, time: 2, position: [1, 0, 1], duration: 1}"],
            "events[1]",
            "the robot is stopped at 1 s: it cannot move afterwards",
        ),
    ],
)
def test_events_that_contradict_each_other(events, key, text):
    line = problem(with_events(*events))
    assert f" {key}: " in line
    assert text in line


RAISED = "{type: limits, time: 1, max: 3000}"


@pytest.mark.parametrize("order", [1, -1])
def test_limits_that_change_at_one_time_change_together(order):
    """Their order in the file has no effect: 2500 N is below the largest, once that is 3000 N."""
    rise = ["{type: limits, time: 1, min: 2500}", "{type: wrench, time: 1, force: [0, 0, 1]}", RAISED]
    assert len(load(with_events(*rise[::order])).events) == 3
    wrong = problems(with_events(*[each.replace("3000", "2400") for each in rise][::order]))
    assert len(wrong) == 1
    assert "would have the limits 2500 to 2400 (N)" in wrong[0]


def test_limits_of_different_cables_may_change_at_one_time():
    events = ["{type: limits, time: 1, cable: 1, max: 800}", "{type: limits, time: 1, cable: 2, max: 700}"]
    assert len(load(with_events(*events, "{type: limits, time: 1, cable: 1, min: 60}")).events) == 3


def test_events_of_one_sample_are_reported_in_the_order_in_which_they_act():
    """The later of both holds, whichever is written first."""
    late, early = "{type: limits, time: 0.02, max: 340}", "{type: limits, time: 0.0199999, max: 338}"
    changes = {"simulation.duration": 0.03, "events": [yaml.safe_load(late), yaml.safe_load(early)]}
    run = cdpr.simulate("caroca", overrides=changes)
    assert run.tension[25].max() == 340.0
    assert [event.text[-5:] for event in run.events if event.kind == "limits"] == ["338 N", "340 N"]


def test_a_jammed_cable_may_break_and_loads_may_overlap():
    load(
        with_events(
            "{type: cable_jam, time: 1, cable: 1}",
            "{type: cable_break, time: 2, cable: 1}",
            "{type: limits, time: 2.5, min: 60}",
            "{type: wrench, force: [1, 0, 0]}",
            "{type: wrench, force: [1, 0, 0]}",
        )
    )


def test_all_mistakes_are_reported_together():
    assert len(problems(with_events("{type: snap}", "{type: cable_break, time: 1, cable: 9}", "{type: limits}"))) == 3


def test_events_after_the_end_are_reported_as_unused():
    text = with_events("{type: wrench, time: 4, force: [1, 0, 0]}", "{type: wrench, time: 4.5, force: [1, 0, 0]}")
    assert "events[1]" in load(text).unused
    assert "events[0]" not in load(text).unused


def test_overrides_reach_single_events():
    scenario = load(TEXTS["events"], "events[3].cable=3", "events[0].force=[7, 0, 0]")
    assert scenario.events[3].cable == "cable_3"
    assert scenario.events[0].force == (7.0, 0.0, 0.0)
    line = problem(TEXTS["events"], "events[4].cable=9")
    assert line == "--set events[4].cable=9: events[4].cable: cables are numbered from 1 to 3, got 9"


@pytest.mark.parametrize(
    ("time", "sample"), [(0.0, 0), (1.0, 1000), (0.3, 300), (1e-9, 1), (0.0005, 1), (1.0001, 1001), (1e5, 10**8)]
)
def test_a_time_acts_at_the_first_sample_at_or_after_it(time, sample):
    assert first_sample(time, 0.001) == sample


def test_events_require_a_summary():
    class Silent(ScenarioEvent):
        type: str = "silent"

    with pytest.raises(TypeError, match="abstract"):
        Silent.model_validate_json('{"time": 1.0}')
