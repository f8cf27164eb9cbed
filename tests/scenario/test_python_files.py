"""Sections and files of scenarios built in Python: sections keep their options, and files their places."""

from __future__ import annotations

import numpy as np
import pytest

import cdpr
from cdpr.scenario import examples

pytestmark = pytest.mark.core

FRAME = np.repeat([[-2.0, -1.5, 3.0], [2.0, -1.5, 3.0], [-2.0, 1.5, 3.0], [2.0, 1.5, 3.0]], 2, axis=0)
POINTS = np.array([[3, -2, -1], [-3, 2, 1], [-3, -2, 1], [3, 2, -1], [-3, -2, -1], [3, 2, 1], [3, -2, 1], [-3, 2, -1]])
SHORT = {"duration": 0.02}


def built(**changes):
    return cdpr.Robot.from_points(
        FRAME, 0.1 * POINTS, mass=12.0, home=[0.0, 0.0, 1.2], tension_min=1.0, tension_max=800.0
    ).replace(**changes)


def scenario(**changes):
    return cdpr.Scenario(**{"robot": built(), "simulation": SHORT} | changes)


def message(make):
    with pytest.raises(cdpr.CdprError) as caught:
        make()
    return str(caught.value)


@pytest.mark.parametrize("name", [each.name for each in examples.examples() if each.kind == "scenario"])
def test_a_section_in_its_own_place_changes_nothing(name):
    one = cdpr.load_scenario(name)
    sections = {key: section for key, section in one.sections if section is not None}
    for key, section in sections.items():
        other = one.replace(**{key: section})
        assert (key, other.resolved_yaml()) == (key, one.resolved_yaml())
        assert (other.unused, other.notes) == (one.unused, ())
    assert one.replace(**sections) == one


def test_sections_keep_the_options_of_their_plugins():
    one = scenario(
        controller={"type": "computed_torque", "kp": 77.0},
        solver={"type": "p_norm", "p": 4, "infeasible": "stop"},
        backend_options={"reference": {"scheme": "semi_implicit_euler"}},
    )
    names = ("controller", "solver")
    other = scenario(**{name: getattr(one, name) for name in names}, backend_options=one.sections.backend_options)
    assert other == one
    assert other.controller_options.kp == 77.0
    assert other.solver_options.p == 4
    assert other.replace(controller=scenario().controller).controller_options.kp != 77.0
    assert cdpr.load_scenario({"robot": built(), "simulation": SHORT, "controller": one.controller}).controller == (
        one.controller
    )
    assert one.with_changes({"controller": one.controller}) == one


def test_options_given_with_another_plugin_are_kept():
    one = scenario(controller={"type": "computed_torque", "kp": 77.0})
    other = one.replace(controller={"type": "pid", "kp": 55.0})
    assert other.controller_options.kp == 55.0
    assert not other.unused
