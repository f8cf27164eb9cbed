"""A changed scenario is what its file would load to with these changes, or is refused in the same words."""

from __future__ import annotations

import pytest
from conftest import ROOT
from hypothesis import given
from hypothesis import strategies as st

from cdpr.base.errors import CdprError
from cdpr.scenario import load_scenario

FILE = ROOT / "scenarios" / "external_wrench.yaml"
CHANGES = [
    {"name": "other"},
    {"name": ""},
    {"robot.platform.mass": 25.0},
    {"robot.platform.mass": -1.0},
    {"robot.cables[2].frame[0]": "far"},
    {"world.gravity": [0.0, 0.0, -1.6]},
    {"world.gravity": [0.0, 0.0]},
    {"simulation.duration": 0.5, "simulation.ends_early": True},
    {"simulation.control_step": 0.0},
    {"simulation.sed": 3},
    {"initial.position[0]": 0.01},
    {"initial.position": [1e9, 0.0, 0.0]},
    {"controlled": ["z", "x", "y"]},
    {"controlled": ["w"]},
    {"controller.kp": 130.0},
    {"controller.kp": -1},
    {"controller.type": "none_such"},
    {"solver.infeasible": "stop"},
    {"solver.infeasible": "go on"},
    {"limits": "stop"},
    {"limits": 3},
    {"events": []},
    {"events": [{"type": "hold_tension", "cable": 1, "start": 0.1, "tension": -5}]},
    {"log": {"step": 0.01}},
    {"log": {"step": 0.0101}},
    {"backend_options": {"reference": {"scheme": "semi_implicit_euler"}}},
    {"backend_options": {"reference": {"scheme": "none"}}},
    {"believed.platform.mass": 31.0},
    {"nothing": 1},
]


def told(change):
    """The scenario as YAML and its warnings, or why there is none."""
    try:
        found = change()
    except CdprError as error:
        return str(error)
    return found.resolved_yaml(), found.sections, list(map(str, found.warnings)), found.unused


@pytest.fixture(scope="module")
def base():
    loaded = load_scenario(FILE)
    loaded.planned  # noqa: B018 - shared if equal
    return loaded


@pytest.mark.parametrize("changes", CHANGES, ids=lambda changes: " ".join(f"{k}={v}" for k, v in changes.items()))
def test_each_section(base, changes):
    assert told(lambda: base.with_changes(changes)) == told(lambda: load_scenario(FILE, overrides=changes))


@given(chosen=st.lists(st.sampled_from(CHANGES), min_size=1, max_size=4))
def test_one_change_after_another(base, chosen):
    once, here = {}, base
    try:
        for changes in chosen:
            here = here.with_changes(changes)
            once |= changes
    except CdprError:
        return
    whole = load_scenario(FILE, overrides=once)
    assert (here.resolved_yaml(), here.robot.anchors.tolist()) == (whole.resolved_yaml(), whole.robot.anchors.tolist())
    assert (here.desired.segments == whole.desired.segments).all()
