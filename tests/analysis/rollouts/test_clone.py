"""Cases of a rollout that take over the loop of a finished case: the bits and messages of cases that are built."""

from __future__ import annotations

import numpy as np
import pytest
from batch_cases import assert_same_results
from conftest import ROOT

import cdpr
from cdpr.analysis.rollouts import case
from cdpr.base.columns import FIRST
from cdpr.native.operations import LANES
from cdpr.plugins import Backend, Controller
from cdpr.simulation.renewal import WORK
from cdpr_controllers import ComputedTorqueOptions
from cdpr_controllers.computed_torque import ComputedTorque
from cdpr_solvers.options import QpOptions
from cdpr_solvers.qp import GIVEN, MinimumNorm

SCENARIOS = ROOT / "scenarios"
ALL = tuple(column.name for column in FIRST if column.name != "time")
N = 2 * LANES


def drawn(seed=1):
    """Return values for N cases, of which the last eight have some at, or beyond, what is valid."""
    rng = np.random.default_rng(seed)
    inertia = np.hstack([rng.uniform(0.8, 1.3, (N, 3)), rng.uniform(-0.1, 0.1, (N, 3))])
    values = {
        "robot.platform.mass": rng.uniform(20.0, 40.0, N).tolist(),
        "robot.platform.inertia": inertia.tolist(),
        "robot.platform.center_of_mass": rng.uniform(-0.05, 0.05, (N, 3)).tolist(),
        "controller.kp": rng.uniform(80.0, 200.0, N).tolist(),
        "initial.position[0]": rng.uniform(-0.05, 0.05, N).tolist(),
        "initial.velocity": rng.uniform(-0.1, 0.1, (N, 3)).tolist(),
        "trajectory.duration": rng.uniform(2.0, 3.0, N).tolist(),
    }
    values["robot.platform.mass"][-7] = -1.0
    values["robot.platform.mass"][-8] = 1e12
    values["robot.platform.inertia"][-6] = [1.0, 1.0, 2.00002, 0.0, 0.0, 0.0]  # within the tolerance
    values["robot.platform.inertia"][-5] = [1.0, 1.0, 2.0001, 0.0, 0.0, 0.0]
    values["initial.velocity"][-4] = [1e4, 0.0, 0.0]
    values["robot.platform.mass"][-3] = 1e-300
    values["controller.kp"][-2] = 1e9
    values["initial.position[0]"][-1] = 1e13
    return values


@pytest.fixture
def both(monkeypatch):
    """Return a function for a rollout and one whose cases are all built, and the numbers of loops that were built."""

    def run(name, vary, solver=None, **overrides):
        n, found, built = len(next(iter(vary.values()))), [], []
        build = case.build
        given = {"simulation.ends_early": True, "simulation.duration": 0.02, **overrides}
        for patch in ({}, {"adopt": lambda *_: False}):
            made = []
            with monkeypatch.context() as patched:
                patched.setattr(case, "build", lambda scenario, made=made: made.append(scenario) or build(scenario))
                for attribute, value in patch.items():
                    patched.setattr(case.Case, attribute, value)
                path = SCENARIOS / f"{name}.yaml"
                kept = {"every": 1, "columns": ALL, "threads": 1, "solver": solver}
                found.append(cdpr.rollout(path, n, vary=vary, overrides=given, **kept))
            built.append(len(made))
        return *found, built

    return run


def test_platform_start_motion_and_gains(both):
    one, other, built = both("caroca", drawn())
    assert one.counts["failed"] == 3
    assert one.counts["diverged"] >= 1
    assert built[0] <= LANES + 5
    assert built[1] == N - 3
    assert_same_results(one, other)


@pytest.mark.parametrize("controller", ["static", "pid"])
@pytest.mark.usual("pid")
def test_controllers(controller, both):
    vary = {"robot.platform.mass": np.linspace(24.0, 30.0, N)}
    one, other, built = both("caroca", vary, **{"controller.type": controller})
    assert built == [LANES, N]
    assert_same_results(one, other)


OTHERS = {
    "anchors": ("caroca", {"robot.cables[2].frame[0]": np.linspace(3.5, 3.51, N)}),
    "guide": ("planar", {"robot.platform.mass": np.linspace(4.0, 6.0, N)}),
    "gravity": ("caroca", {"world.gravity[2]": np.linspace(-9.9, -9.7, N)}),
    "belief": ("believed", {"robot.platform.mass": np.linspace(138.0, 141.0, N)}),
    "policy": ("caroca", {"solver.infeasible": ["stop", "best_effort"] * LANES}),
    "solver": ("caroca", {"solver.about": ["zero", "middle"] * (N // 2)}),
    "colour": ("caroca", {"robot.platform.colour": ["#ff0000", "#00ff00"] * (N // 2)}),
}


@pytest.mark.parametrize("name", OTHERS)
@pytest.mark.usual("anchors")
def test_unusable_parts_are_rebuilt(name, both):
    scenario, vary = OTHERS[name]
    one, other, _ = both(scenario, vary)
    assert_same_results(one, other)


class Heavier(ComputedTorque):
    """Reads the mass in its constructor, of which its base does not know."""

    Options = ComputedTorqueOptions

    def __init__(self, robot, gravity, control_step, options):
        super().__init__(robot, gravity, control_step, options)
        self._given["gravity"] *= 1.0 + 0.001 * robot.platform.mass


class Gravity(ComputedTorque):
    """Reads the mass when its operation is bound."""

    Options = ComputedTorqueOptions

    def compiled(self, state, desired, out):
        self._given["gravity"][2] = -9.81 - 0.001 * self.robot.platform.mass
        return super().compiled(state, desired, out)


@pytest.mark.parametrize("controller", [Heavier, Gravity])
def test_a_derived_controller_is_built(controller, monkeypatch):
    """Its own methods may use the platform as they like."""
    masses = np.linspace(24.0, 30.0, 2 * LANES)
    given = {
        "vary": {"robot.platform.mass": masses},
        "controller": controller,
        "every": 1,
        "columns": ALL,
        "threads": 1,
    }
    given["overrides"] = {"simulation.duration": 0.01, "simulation.ends_early": True}
    one = cdpr.rollout(SCENARIOS / "caroca.yaml", len(masses), **given)
    monkeypatch.setattr(case.Case, "adopt", lambda *_: False)
    assert_same_results(one, cdpr.rollout(SCENARIOS / "caroca.yaml", len(masses), **given))


def test_methods_that_may_use_the_platform_exist():
    """A renamed method would no longer be compared, and its overrides would be ignored."""
    assert all(hasattr(Backend, name) or hasattr(Controller, name) for name in WORK)


class Weighing(MinimumNorm):
    """Aims at tensions that depend on the mass, of which nobody knows."""

    Options = QpOptions

    def __init__(self, robot, options):
        super().__init__(robot, options)
        self.parameters["about"] = GIVEN
        self.parameters["reference"] = np.full(robot.m, robot.platform.mass)


class Independent(MinimumNorm):
    """Declares that it does not depend on the platform."""

    Options = QpOptions
    properties = {"platform_independent": True}  # noqa: RUF012


@pytest.mark.parametrize(("solver", "count"), [(Weighing, N), (Independent, LANES)])
def test_only_a_solver_that_declares_it_is_taken_over(solver, count, both):
    vary = {"robot.platform.mass": np.linspace(24.0, 30.0, N)}
    one, other, built = both("caroca", vary, solver=solver)
    assert built == [count, N]
    assert_same_results(one, other)
