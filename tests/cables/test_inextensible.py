"""`cable.model: inextensible` in robot files: `rigid` with the inertia of a drum, `ideal` without, to the bit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import cdpr
from cdpr.base.errors import ScenarioError
from cdpr.cables import model_of

SHORT = {"simulation.duration": 0.05}


def rows(name, **changes):
    return cdpr.simulate(cdpr.load_scenario(name, overrides=SHORT | changes)).rows


@pytest.mark.parametrize(("name", "model"), [("caroca", "ideal"), ("winch", "rigid")])
def test_the_same_bits(name, model):
    np.testing.assert_array_equal(
        rows(name, **{"robot.cable.model": "inextensible"}), rows(name, **{"robot.cable.model": model})
    )


def robot(text):
    start = "dof: [x, y, z]\nplatform: {mass: 1}\ntension: {min: 0, max: 9}\n"
    return cdpr.load_robot("robot.yaml", text=start + text)


CABLES = "cables:\n- {frame: [0, 0, 2], platform: [0, 0, 0]MORE}\n- {frame: [1, 0, 2], platform: [0, 0, 0]}\n"
WINCH = "{drum_radius: 0.1, inertia: 0.01}"


@pytest.mark.parametrize(
    ("common", "own", "model", "models"),
    [
        ("cable: {model: inextensible}", "", "ideal", [None, None]),
        (f"cable: {{model: inextensible}}\nwinch: {WINCH}", "", "rigid", [None, None]),
        ("cable: {model: inextensible}\nwinch: {drum_radius: 0.1}", "", "ideal", [None, None]),
        ("cable: {model: inextensible}", f", winch: {WINCH}", "ideal", ["rigid", None]),
        (f"cable: {{model: inextensible}}\nwinch: {WINCH}", ", winch: {drum_radius: 0.1}", "rigid", ["ideal", None]),
        ("cable: {model: ideal}", f", model: inextensible, winch: {WINCH}", "ideal", ["rigid", None]),
    ],
)
def test_the_inertia_of_each_cables_winch_decides(common, own, model, models):
    found = robot(f"{common}\n{CABLES.replace('MORE', own)}")
    assert (found.cable_model, [cable.model for cable in found.cables]) == (model, models)


def test_robots_do_not_know_the_name():
    found = robot(f"cable: {{model: inextensible}}\nwinch: {WINCH}\n{CABLES.replace('MORE', '')}")
    assert model_of(found) == "rigid"
    with pytest.raises(cdpr.CdprError, match="cable_model"):
        replace(found, cable_model="inextensible")


def test_drives_of_length_need_a_cable_that_stretches():
    for winch in ("{type: position}", "{type: velocity, drum_radius: 0.1, inertia: 0.01, velocity_gain: 1}"):
        with pytest.raises(
            ScenarioError, match=r"robot\.yaml:5:\d+: winch\.type: .* needs a cable that stretches"
        ) as told:
            robot(f"cable: {{model: inextensible}}\nwinch: {winch}\n{CABLES.replace('MORE', '')}")
        assert "set cable.model: elastic and cable.axial_stiffness" in str(told.value)


@pytest.mark.parametrize("kind", ["position", "velocity", "stepper"])
def test_drives_of_length_need_a_section_of_the_cable(kind):
    """Without this section, cables are ideal: the drive would have no effect."""
    told = rf"type: {kind} needs a cable that stretches, got cable.model ideal: .* or type: torque"
    with pytest.raises(ScenarioError, match=rf"robot\.yaml:4:\d+: winch\.{told}"):
        robot(f"winch: {{type: {kind}}}\n{CABLES.replace('MORE', '')}")
    with pytest.raises(ScenarioError, match=rf"robot\.yaml:\d+:\d+: cables\[0\]\.winch\.{told}"):
        robot(CABLES.replace("MORE", f", winch: {{type: {kind}}}"))


def test_numbers_of_own_models_are_required_without_a_common_section():
    with pytest.raises(ScenarioError, match=r"cable\.model elastic needs the axial stiffness \(N\) of each cable"):
        robot(f"winch: {WINCH}\n{CABLES.replace('MORE', ', model: elastic')}")


def test_an_inertia_requires_a_radius():
    with pytest.raises(ScenarioError, match=r"drum_radius"):
        robot(f"cable: {{model: inextensible}}\nwinch: {{inertia: 0.1}}\n{CABLES.replace('MORE', '')}")


def test_events_of_ideal_cables():
    event = {"type": "cable_break", "cable": "cable_1", "time": 0.01}
    cdpr.load_scenario("caroca", overrides=SHORT | {"robot.cable.model": "inextensible", "events": [event]})
    with pytest.raises(ScenarioError, match=r"happens to ideal cables only, and robot\.cable\.model is inextensible"):
        cdpr.load_scenario("winch", overrides=SHORT | {"robot.cable.model": "inextensible", "events": [event]})
