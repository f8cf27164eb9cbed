"""Eight cases of a rollout side by side: each is what it is alone, to the bit, whatever happens to the others."""

from __future__ import annotations

import numpy as np
import pytest
from batch_cases import assert_same_results
from conftest import ROOT

import cdpr
from cdpr.analysis.rollouts import block, case
from cdpr.base.columns import FIRST
from cdpr.native.operations import LANES

SCENARIOS = ROOT / "scenarios"
ALL = tuple(column.name for column in FIRST if column.name != "time")
MORE = LANES + 2  # cases: a full group, and one that is too small
GAINS = {"controller.kd": {"uniform": [15.0, 30.0]}}
LIMIT = 10_000.0


@pytest.fixture
def both(monkeypatch):
    """Return what makes a rollout with cases side by side and one of cases alone, and how far the former went."""
    far: list[tuple[int, int]] = []
    forward = block.Block._forward

    def spy(self, cases, steps):
        begun = cases[0].count
        left = forward(self, cases, steps)
        far.append((begun, cases[0].count))
        return left

    def run(name, vary, n=MORE, **overrides):
        given = {"simulation.ends_early": True, "simulation.backend": "reference", **overrides}
        made = []
        for least in (block.WORTHWHILE, LIMIT):
            with monkeypatch.context() as patched:
                patched.setattr(block, "WORTHWHILE", least)
                patched.setattr(block.Block, "_forward", spy)
                path = SCENARIOS / f"{name}.yaml"
                made.append(cdpr.rollout(path, n, vary=vary, every=1, columns=ALL, overrides=given, threads=None))
        return *made, far

    return run


ALIKE = {
    "mass": ("caroca", {"robot.platform.mass": {"uniform": [24.0, 30.0]}}),
    "anchors": ("caroca", {"robot.cables[2].frame[0]": {"normal": [3.5, 0.01]}}),
    "motion": ("caroca", {"trajectory.duration": {"uniform": [2.0, 3.0]}}),
    "belief": ("believed", GAINS),
    "off centre": ("off_centre_mass", GAINS),
    "gravity": ("external_wrench", {"world.gravity": np.linspace([0, 0, -9.9], [0, 0, -9.7], MORE)}),
    "limits": ("thesis", GAINS),
}


@pytest.mark.parametrize("name", ALIKE)
@pytest.mark.usual("mass", "belief")
def test_they_go_all_the_way_together(name, both):
    scenario, vary = ALIKE[name]
    one, other, far = both(scenario, vary, **{"simulation.duration": 0.3})
    assert far
    assert far[-1][1] == 300
    assert one.counts == {"finished": MORE}
    assert_same_results(one, other)


@pytest.mark.parametrize("controller", ["static", "pid"])
@pytest.mark.usual("pid")
def test_controllers(controller, both):
    one, other, far = both("caroca", GAINS, **{"simulation.duration": 0.3, "controller.type": controller})
    assert far == [(0, 300)]
    assert_same_results(one, other)


@pytest.mark.parametrize(("name", "solver"), [("caroca", "dykstra"), ("caroca", "centroid"), ("planar", "lp")])
@pytest.mark.usual("caroca-dykstra", "planar-lp")
def test_solvers_without_lanes_are_called_for_each(name, solver, both):
    """On a robot with a guide the solver gets some rows of W, which an act in lanes has selected."""
    one, other, far = both(name, GAINS, **{"simulation.duration": 0.3, "solver.type": solver})
    assert far[-1][1] == 300
    assert_same_results(one, other)


@pytest.mark.parametrize("option", ["about: previous", "change: 5.0"])
@pytest.mark.usual("change*")
def test_a_solver_that_follows_is_not_called_side_by_side(option, both):
    key, value = option.split(": ")
    given = float(value) if value[0].isdigit() else value
    one, other, far = both("caroca", GAINS, **{"simulation.duration": 0.3, f"solver.{key}": given})
    assert far[-1][1] == 300
    assert_same_results(one, other)


@pytest.mark.slow
def test_limits_in_the_way_of_some(both):
    """Heavy platforms are beyond what the cables may do for a part of the way; a policy answers for them."""
    for policy in ("best_effort", "hold_tension"):
        vary = {"robot.platform.mass": np.linspace(25.0, 900.0, MORE), "robot.tension.max": [2000.0] * MORE}
        one, other, _ = both("caroca", vary, **{"simulation.duration": 1.0, "solver.infeasible": policy})
        counts = one.figures["infeasible_steps"]
        assert 0 in counts
        assert counts.max() > 100
        assert_same_results(one, other)


def test_events_at_different_times(both):
    one, other, far = both("cable_break", {"events[0].time": {"uniform": [0.05, 0.25]}}, **{"simulation.duration": 0.4})
    assert len(far) > 1
    assert_same_results(one, other)


@pytest.mark.slow
def test_frequent_events_increase_the_reporting_interval(both):
    one, other, far = both("external_wrench", GAINS, **{"simulation.duration": 2.5})
    assert far[0][1] > 0
    assert len(far) < 15
    assert_same_results(one, other)


def test_some_end_early_and_the_others_continue(both):
    n = 9
    vary = {
        "controller.kp": [100.0, 200.0, 300.0, 80.0, 90.0, 1e6, 100.0, 100.0, 120.0],
        "robot.platform.mass": [25.0, 25.0, 1e4, -1.0, 26.0, 25.0, 27.0, 28.0, 29.0],
        "robot.tension.max": [2000.0] * 5 + [1e11] + [2000.0] * 3,
        "simulation.physics_step": [0.01] * n,
        "solver.infeasible": ["best_effort"] * 2 + ["stop"] * 2 + ["hold_tension", "best_effort"] + ["stop"] * 3,
    }
    one, other, far = both("caroca", vary, n, **{"simulation.duration": 2.0, "simulation.control_step": 0.01})
    assert one.counts == {"finished": 6, "infeasible": 1, "failed": 1, "diverged": 1}
    assert far[-1][1] == 200
    assert_same_results(one, other)
    for i in (2, 5):
        own = {key: values[i] for key, values in one.values.items()}
        with pytest.raises(cdpr.SimulationStopped) as stop:
            cdpr.simulate(
                SCENARIOS / "caroca.yaml",
                overrides={**own, "simulation.duration": 2.0, "simulation.control_step": 0.01},
            )
        assert one.messages[i] == str(stop.value)


DIFFERENT = {
    "controllers": {"controller.type": ["static", "pid"] * (MORE // 2)},
    "options of the solver": {"solver.about": ["zero", "middle"] * (MORE // 2)},
    "cables": {"robot.tension.max": [900.0, 2000.0] * (MORE // 2), "solver.about": ["zero"] * (MORE - 1) + ["middle"]},
}


@pytest.mark.parametrize("name", DIFFERENT)
@pytest.mark.usual("controllers")
def test_cases_that_are_made_differently_go_alone(name, both):
    one, other, _ = both("caroca", DIFFERENT[name], **{"simulation.duration": 0.2})
    assert_same_results(one, other)


ALONE = {"cogiro_pulleys": GAINS, "winch": GAINS, "planar": GAINS}


@pytest.mark.parametrize("name", ALONE)
@pytest.mark.usual("planar", "winch")
def test_parts_without_lanes_are_done_for_each_case(name, both):
    one, other, far = both(name, ALONE[name], **{"simulation.duration": 0.2})
    assert far == [(0, 200)]
    assert_same_results(one, other)


BROKEN = [{"type": "cable_break", "cable": "cable_1", "time": 0.05}]


@pytest.mark.parametrize("events", [[[], BROKEN] * 2, [BROKEN, []] * 2])
def test_cases_with_other_events_go_alone(events, both):
    one, other, _ = both("caroca", {"events": events}, 4, **{"simulation.duration": 0.1})
    assert one.counts == {"finished": 4}
    assert_same_results(one, other)


def test_exits_of_different_kinds_do_not_share_lanes(both):
    robot = cdpr.load_robot(SCENARIOS / "robots" / "cogiro_pulleys.yaml")
    pulley = {"type": "pulley", "radius": 0.1, "axis": [0.0, 0.0, 1.0]}

    def cables(*over_pulleys):
        rows = [{"frame": row[:3], "platform": row[3:]} for row in robot.anchors.tolist()]
        return [{**row, "exit": pulley} if i in over_pulleys else row for i, row in enumerate(rows)]

    vary = {"robot.cables": [cables(1), cables(0, 1), cables(0, 1), cables(1)]}
    without = {"robot.cable": {}, "simulation.duration": 0.1}
    one, other, _ = both("cogiro_pulleys", vary, 4, **without)
    assert one.counts == {"finished": 4}
    assert_same_results(one, other)


@pytest.mark.parametrize("controller", ["computed_torque", "pid"])
def test_a_loop_serves_cases_that_differ_in_options_that_may_change(controller, monkeypatch):
    """Values that a plugin does not accept, and cases that diverge, do not change the others."""
    made, build = [], case.build
    monkeypatch.setattr(case, "build", lambda scenario: made.append(scenario) or build(scenario))
    gains = [100.0 + i for i in range(3 * LANES)]
    gains[12], gains[14] = 1e6, -1.0
    overrides = {
        "controller.type": controller,
        "robot.tension.max": 1e11,
        "simulation.control_step": 0.01,
        "simulation.physics_step": 0.01,
        "simulation.duration": 0.3,
        "simulation.ends_early": True,
    }
    given = {"vary": {"controller.kp": gains, "controller.kd": [20.0] * len(gains)}, "overrides": overrides}
    given |= {"every": 1, "columns": ALL, "threads": 1}
    one = cdpr.rollout(SCENARIOS / "caroca.yaml", len(gains), **given)
    assert len(made) <= LANES + 4
    assert one.counts == {"finished": 22, "failed": 1, "diverged": 1}
    assert "controller.kp" in one.messages[14]
    monkeypatch.setattr(case.Case, "adopt", lambda *_: False)
    assert_same_results(one, cdpr.rollout(SCENARIOS / "caroca.yaml", len(gains), **given))
    assert len(made) >= LANES + 20
