"""First line of the summary after a lost sensor, and shortened lists of events."""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner
from conftest import ROOT

import cdpr
from cdpr.ui.cli import cli
from cdpr.ui.cli.run import INTERVALS, _events
from cdpr.ui.report.pages.run import render
from cdpr.ui.report.text.reservations import reservations

SCENARIO = ROOT / "scenarios" / "noisy_pose.yaml"  # a measurement each 5 ms, 4 ms late
FAILS = {"type": "sensor_failure", "time": 0.1, "sensor": "mocap"}


def lost(until, **event):
    overrides = {"simulation.duration": until, "events": [{**FAILS, **event}]}
    return [text for text in reservations(cdpr.simulate(SCENARIO, overrides=overrides)) if "sensor" in text]


def test_a_sensor_that_failed_for_good_comes_first():
    """Its measurement at 0.1 s is the last: 20 periods and a delay later, at 0.204 s, it counts as lost."""
    assert lost(0.3) == ["sensor 'mocap' took no measurement after 0.1 s"]
    assert lost(0.2) == []
    assert lost(0.3, duration=0.1) == []


def test_random_losses_do_not_count():
    overrides = {"simulation.duration": 0.5, "sensors.0.dropout": 0.5}
    assert not [text for text in reservations(cdpr.simulate(SCENARIO, overrides=overrides)) if "sensor" in text]


def test_summary_and_page_state_it(tmp_path):
    events = json.dumps([FAILS, {"type": "wrench", "time": 0.11, "force": [0, 0, 3e4], "duration": 0.02}])
    words = ["run", str(SCENARIO), "--set", "simulation.duration=0.3", "--set", f"events={events}", "--no-report"]
    done = CliRunner().invoke(cli, [*words, "--out", str(tmp_path / "run")])
    status = done.stdout.splitlines()[1]
    assert "finished, but sensor 'mocap' took no measurement after 0.1 s; " in status, "before infeasible samples"
    assert "sensor &#x27;mocap&#x27; took no measurement after 0.1 s" in render(cdpr.load_run(tmp_path / "run"))


VISUAL = ROOT / "scenarios" / "visual_servo.yaml"
UPWARDS = {"simulation.duration": 0.1, "sensors.0.attitude": [1, 0, 0, 0]}


def test_markers_never_seen():
    run = cdpr.simulate(VISUAL, overrides=UPWARDS)
    assert "sensor 'camera' never saw a marker" in list(reservations(run))


def test_markers_lost_on_the_way():
    """The image of 0.06 s, which shows none, arrives 20 ms later: the samples of 2 ms before 0.08 s have markers."""
    turned = {"type": "sensor_bump", "time": 0.05, "sensor": "camera", "rotation": [3.0, 0, 0]}
    run = cdpr.simulate(VISUAL, overrides={"simulation.duration": 0.1, "events": [turned]})
    text = "sensor 'camera' sees no marker at the end, but saw some at 40 of 51 samples"
    assert text in list(reservations(run))


@pytest.mark.parametrize(("markers", "warned"), [(2, True), (3, False)])
def test_too_few_markers_at_the_start_are_a_warning(markers, warned):
    """The others are far outside of the image."""
    seen = [[0.5, 0.25, 0.2], [-0.5, 0.25, 0.2], [-0.5, -0.25, 0.2]][:markers]
    overrides = {"sensors.0.markers": [*seen, *[[50.0 + k, k * k, 0.2] for k in range(5 - markers)]]}
    scenario = cdpr.load_scenario(VISUAL, overrides=overrides)
    texts = [each.text for each in scenario.warnings if each.path == ("sensors", 0)]
    told = "the camera 'camera' sees 2 of 5 markers at the initial pose, and the controller 'visual_servo' needs 3"
    assert [text.partition(":")[0] for text in texts] == ([told] if warned else [])


@pytest.mark.parametrize(("bias", "warned"), [(0.0, False), (0.02, True)])
def test_estimates_with_errors_beyond_their_covariance(bias, warned):
    overrides = {"simulation.duration": 0.2, "sensors.0.length.bias": bias}
    run = cdpr.simulate(ROOT / "scenarios" / "encoders_only.yaml", overrides=overrides)
    nees = run.summary()["estimate"]["nees"]["mean_per_value"]
    found = [text for text in reservations(run) if "estimate" in text]
    text = f"the estimate's errors are {nees**0.5:.3g} times its standard deviations (NEES {nees:.3g} per value)"
    assert found == ([text] if warned else [])


def test_lists_of_intervals_are_short():
    run = cdpr.simulate("hangprinter", overrides={"simulation.duration": 2.0, "controller.pretension": 0})
    slack = [event for event in run.events if event.kind == "slack"]
    assert len(slack) > INTERVALS
    lines = list(_events(run))
    assert sum(" s: slack: " in line for line in lines) == INTERVALS
    assert f"and {len(slack) - INTERVALS} more intervals of the kind slack: see run.json" in lines
    assert len(lines) == len(run.events) - len(slack) + INTERVALS + 1


@pytest.mark.parametrize(("controller", "sensor"), [("visual_servo", "markers"), ("tension_feedback", "tension")])
def test_loops_with_other_sensors_have_no_poles(controller, sensor):
    sensors = [{"type": "tension"}] if sensor == "tension" else None
    overrides = {"controller": {"type": controller}} | ({"sensors": sensors} if sensors else {})
    name = "visual_servo" if sensors is None else "caroca"
    done = CliRunner().invoke(
        cli,
        [
            "validate",
            name,
            *(word for key, each in overrides.items() for word in ("--set", f"{key}={json.dumps(each)}")),
        ],
    )
    assert f"the controller '{controller}' uses the sensor {sensor}, which is not linearised" in done.stderr
