"""Infinity norm, improved puncture, weights from stiffness, the ball that proves infeasibility, aliases, options."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner
from conftest import ROOT
from plants import installed
from scipy.optimize import linprog
from test_qp import margin, problem

import cdpr
from cdpr.base.errors import PluginError
from cdpr.mechanics import kinematics
from cdpr.plugins.registry import registry
from cdpr.tension import Status
from cdpr.ui.cli import cli as main

ROBOTS = ROOT / "scenarios" / "robots"
SURE = 1e-3  # N of margin beyond which a linear program with its own tolerances is an oracle


def make(name, robot, **options):
    entry = registry().get("solver", name)
    return entry.make(robot, entry.read_options(options))


def ask(name, robot, W, wrench, low=None, high=None, **options):
    t = np.full(robot.m, np.nan)
    low, high = robot.tension_min if low is None else low, robot.tension_max if high is None else high
    return make(name, robot, **options).solve(W, wrench, low, high, t), t


def problems(count, loads=(50.0, 300.0, 1500.0)):
    for seed in range(count):
        yield problem(seed, 7 + seed % 6, loads[seed % len(loads)])


def feasible(seed, m):
    """A wrench that some tensions between the limits exert; the least ones are at some of them."""
    robot, W, _ = problem(seed, m, 0.0)
    t = np.random.default_rng(seed).uniform(robot.tension_min, robot.tension_max)
    return robot, W, W @ t


def test_infinity_norm_is_least_by_another_library():
    """Also where tensions may be negative; of several optima the least 2-norm is no longer than another's."""
    solved = 0
    for k in range(36):
        robot, W, wrench = feasible(k, 7 + k % 6) if k % 2 else problem(k, 7 + k % 6, 300.0)
        m = robot.m
        low = np.full(m, -40.0) if k % 3 == 0 else np.array(robot.tension_min)
        high = np.array(robot.tension_max)
        if k % 4 == 0:
            high[2] = low[2] = 30.0
        status, t = ask("infinity_norm", robot, W, wrench, low, high)
        bound = np.ones((m, 1))
        other = linprog(
            [*np.zeros(m), 1.0],
            A_ub=np.block([[np.eye(m), -bound], [-np.eye(m), -bound]]),
            b_ub=np.zeros(2 * m),
            A_eq=np.hstack([W, np.zeros((6, 1))]),
            b_eq=wrench,
            bounds=[*zip(low, high, strict=True), (0.0, None)],
        )
        if not other.success:
            assert status != Status.OK or margin(W, wrench, low, high) > -SURE
            continue
        assert status == Status.OK
        solved += 1
        assert np.abs(W @ t - wrench).max() <= 1e-9 * max(1.0, np.abs(wrench).max())
        assert np.all((low <= t) & (t <= high))
        assert np.abs(t).max() == pytest.approx(other.fun, rel=1e-7, abs=1e-7)
        assert np.linalg.norm(t) <= np.linalg.norm(other.x[:m]) * (1.0 + 1e-7)
    assert solved >= 10


def test_improved_puncture_answers_where_the_improved_closed_form_does_and_is_no_longer():
    more = 0
    for robot, W, wrench in problems(60):
        status, t = ask("improved_puncture", robot, W, wrench)
        expected, end = ask("improved_closed_form", robot, W, wrench)
        assert status == expected
        if status == Status.OK:
            assert np.abs(W @ t - wrench).max() <= 1e-9 * max(1.0, np.abs(wrench).max())
            assert np.all((robot.tension_min - 1e-6 <= t) & (t <= robot.tension_max + 1e-6))
            assert np.linalg.norm(t) <= np.linalg.norm(end) + 1e-6
            more += ask("puncture", robot, W, wrench)[0] != Status.OK
    assert more > 0  # which puncture misses


@pytest.mark.parametrize("name", ["closed_form", "puncture", "improved_closed_form", "dykstra", "improved_puncture"])
@pytest.mark.usual("improved_puncture", "dykstra")
def test_the_outer_ball_proves_infeasibility_and_nothing_else(name):
    """Thesis 6.29 with corrected radii: most loads beyond all limits are detected, no feasible one is."""
    told = beyond = 0
    for robot, W, wrench in problems(60, (50.0, 300.0, 1500.0, 8000.0)):
        status, _ = ask(name, robot, W, wrench)
        room = margin(W, wrench, robot.tension_min, robot.tension_max)
        if status == Status.INFEASIBLE:
            assert room < SURE
        told += status == Status.INFEASIBLE
        beyond += room < -SURE
    assert told >= 0.3 * beyond > 3


@pytest.mark.parametrize("m", [6, 8, 12])
def test_corners_of_the_limits_are_never_infeasible(m):
    """The corners lie on the ball itself; with narrow limits its radius is round-off of the tensions."""
    rng = np.random.default_rng(m)
    for width in (1e-9, 1e-6, 1.0, 400.0):
        for _ in range(15):
            robot, W, _ = problem(int(rng.integers(1000)), m, 0.0)
            low = rng.uniform(10.0, 500.0, m)
            high = low + width
            wrench = W @ np.where(rng.random(m) < 0.5, low, high)
            assert ask("closed_form", robot, W, wrench, low, high)[0] != Status.INFEASIBLE


def test_weights_from_stiffness_are_compliances_at_home():
    robot = cdpr.load_robot(ROBOTS / "caroca_winches.yaml")
    stiff = [cable.axial_stiffness for cable in robot.cables]
    lengths = kinematics.lengths(robot, kinematics.make_state(robot.home[:3], robot.home[3:]))
    pose, weights = robot.home, (lengths / stiff).tolist()
    from cdpr.analysis.distribution import distribute

    by_name = distribute(robot, pose, options={"weights": "stiffness"}).tension
    assert by_name == pytest.approx(distribute(robot, pose, options={"weights": weights}).tension, rel=1e-9)
    energy = lambda t: float((t**2) @ (lengths / stiff))  # noqa: E731
    assert energy(by_name) <= energy(distribute(robot, pose).tension)
    with pytest.raises(PluginError, match="axial_stiffness"):
        make("qp", cdpr.load_robot(ROBOTS / "caroca.yaml"), weights="stiffness")


def test_other_names_of_the_field():
    found = registry()
    for alias, name in {
        "barycentre": "centroid",
        "turn-around": "centroid",
        "1-norm": "lp",
        "2-norm": "qp",
        "infinity-norm": "infinity_norm",
    }.items():
        assert found.get("solver", alias).info.name == name
        assert alias not in found.names("solver")
    text = CliRunner().invoke(main, ["solvers"]).output
    assert "centroid: also barycentre" in text
    one = json.loads(CliRunner().invoke(main, ["solvers", "barycentre", "--json"]).output)
    assert one["aliases"]["turn-around"].startswith("Gouttefarde")
    scenario = str(ROBOTS.parent / "caroca.yaml")
    answer = CliRunner().invoke(main, ["validate", scenario, "--set", "solver.type=barycentre"])
    assert answer.exit_code == 0, answer.output


@pytest.mark.parametrize("name", ["osqp", "daqp", "piqp", "clarabel", "highs"])
def test_options_of_the_libraries_reach_them_and_are_checked(name):
    robot, W, wrench = feasible(3, 12)
    assert ask(name, robot, W, wrench)[0] == Status.OK
    assert ask(name, robot, W, wrench, iterations=1)[0] == Status.NOT_FOUND
    for wrong in ({"iterations": 0}, {"tolerance": 0.0}, {"tolerance": 0.1}, {"nwsr": 3}):
        with pytest.raises(PluginError, match="its options are tolerance, iterations"):
            make(name, robot, **wrong)
    if name in ("osqp", "clarabel"):
        assert ask(name, robot, W, wrench, time=1e-9)[0] == Status.NOT_FOUND


def test_a_coarser_tolerance_is_coarser():
    """Of OSQP without its polish and of Clarabel: farther from the optimum."""
    robot, W, wrench = feasible(3, 12)
    optimum = ask("qp", robot, W, wrench)[1]
    fine, coarse = (ask("clarabel", robot, W, wrench, tolerance=x)[1] for x in (1e-13, 1e-7))
    assert np.abs(fine - optimum).max() < np.abs(coarse - optimum).max()


def test_options_in_the_benchmark():
    """Options go only to the named solver; errors are reported before the measurement."""
    from cdpr.analysis.bench import run

    robot = cdpr.load_robot(ROBOTS / "twelve.yaml")
    figures = run([robot], ["clarabel", "daqp"], 12, options={"clarabel": {"iterations": 1}})
    coverage = {row["solver"]: row["coverage"] for row in figures["robots"][0]["results"]}
    assert coverage == {"clarabel": 0.0, "daqp": 1.0}
    command = ["bench", "solvers", str(ROBOTS / "twelve.yaml"), "--solvers", "daqp", "--set"]
    for change, text in {
        "daqp.nwsr=3": "nwsr",
        "osqp.time=1": "not among the selected solvers",
        "daqp": "SOLVER.KEY=VALUE",
    }.items():
        answer = CliRunner().invoke(main, [*command, change])
        assert answer.exit_code != 0
        assert text in answer.output + str(answer.exception)


@pytest.mark.parametrize("engine", installed("mujoco", "bullet", "dart"))
@pytest.mark.usual("mujoco")
def test_legs_have_mass_and_damping_on_request(engine):
    """Both change the motion, their defaults do not; on massless cables both are refused."""
    if registry().get("backend", engine).missing:
        pytest.skip("not installed")

    def moved(**options):
        run = cdpr.simulate(
            ROBOTS.parent / "caroca.yaml",
            backend=engine,
            overrides={
                "simulation.duration": 0.05,
                "initial.velocity": [0.5, 0.2, 0.1],
                **{f"backend_options.{engine}.{key}": value for key, value in {"cables": "ups", **options}.items()},
            },
        )
        return run.position

    plain, same = moved(), moved(leg_mass=1e-3)
    assert np.array_equal(plain, same)
    assert not np.array_equal(plain, moved(leg_mass=0.1))
    for key in ("slide_damping", "hinge_damping"):
        assert not np.array_equal(plain, moved(**{key: 0.01}))
    with pytest.raises(cdpr.CdprError, match="only rigid legs"):
        moved(cables="ideal", leg_mass=0.1)
