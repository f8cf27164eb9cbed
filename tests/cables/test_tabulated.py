"""Cables with a measured curve: tensions, lengths, energies, runs and wrong curves."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

import cdpr
from cdpr.base.errors import ScenarioError
from cdpr.cables.tables import SPAN, chain_table
from cdpr.cables.tabulated import CURVE as TABLE
from cdpr.cables.tabulated import TABULATED
from cdpr.mechanics.kinematics import lengths, make_state
from cdpr.mechanics.potential import Potential, rest_lengths
from cdpr.mechanics.stiffness import stiffness
from cdpr.scenario.from_python import _cables

CURVE = [[0.001, 100.0], [0.003, 500.0], [0.006, 1500.0], [0.01, 4000.0]]  # N
KEYS = {"cable.model": "tabulated", "cable.damping": 0.0}


def robot_with(curve):
    return cdpr.load_robot("caroca_winches", overrides={**KEYS, "cable.stiffness_table": curve})


def tension_at(strain, curve=CURVE):
    """Tension [N] by numpy; straight beyond the last point."""
    e, t = np.array([[0.0, 0.0], *curve]).T
    beyond = t[-1] + (strain - e[-1]) * (t[-1] - t[-2]) / (e[-1] - e[-2])
    return np.where(strain > e[-1], beyond, np.interp(strain, e, t))


def test_tensions_lengths_and_energies_are_those_of_the_curve():
    robot = robot_with(CURVE)
    pose = robot.home
    path = lengths(robot, make_state(pose[:3], pose[3:]))
    strain = np.array([-0.002, 0.0005, 0.001, 0.002, 0.0045, 0.008, 0.01, 0.02])
    unwound = path / (1.0 + strain)
    at = Potential(robot, (0.0, 0.0, 0.0), unwound, np.full(8, np.nan))
    energy, _, _ = at.evaluate(pose)
    np.testing.assert_allclose(at.tension, np.maximum(tension_at(strain), 0.0), rtol=1e-11, atol=1e-9)
    taut = strain > 0.0
    found = rest_lengths(robot, pose[None], tension_at(strain)[None])[0]
    np.testing.assert_allclose(found[taut], unwound[taut], rtol=1e-14)
    kinks = [point[0] for point in CURVE]
    expected = [quad(tension_at, 0.0, e, points=kinks, epsabs=1e-10)[0] for e in np.maximum(strain, 0.0)]
    assert energy == pytest.approx(float(np.sum(unwound * expected)), rel=1e-8)


def test_points_on_a_line_are_an_elastic_cable():
    line = [[0.001, 100.0], [0.002, 200.0], [0.005, 500.0]]
    winch = {"robot.winch": {"drum_radius": 0.05, "inertia": 0.01}, "robot.cable.damping": 20.0}
    short = {"simulation.duration": 0.05, **winch}
    elastic, curved = (
        cdpr.simulate("caroca", overrides={**short, **more})
        for more in (
            {"robot.cable.model": "elastic", "robot.cable.axial_stiffness": 1e5},
            {"robot.cable.model": "tabulated", "robot.cable.stiffness_table": line},
        )
    )
    np.testing.assert_allclose(curved.position, elastic.position, atol=1e-11)
    np.testing.assert_allclose(curved.cable_tension, elastic.cable_tension, rtol=1e-7)


def test_the_robot_rests_where_the_curve_carries_it():
    robot = robot_with(CURVE)
    wanted = cdpr.compensated_lengths(robot, robot.home)
    found = cdpr.equilibrium(robot, lengths=wanted.lengths)
    assert found.converged
    np.testing.assert_allclose(found.pose, robot.home, atol=1e-9)
    strain = found.length / wanted.lengths - 1.0
    np.testing.assert_allclose(found.tension, tension_at(strain), rtol=1e-9)


def test_the_largest_slope_limits_the_step():
    assert TABULATED.stiffest(robot_with(CURVE).cables[0]) == pytest.approx(2500.0 / 0.004)


def test_the_stiffness_follows_the_slope_of_the_curve():
    robot = robot_with(CURVE)
    poses, tension = np.tile(robot.home, (3, 1)), np.array([[50.0] * 8, [800.0] * 8, np.linspace(0.0, 5000.0, 8)])
    K, _ = stiffness(robot, poses, tension)
    for pose, t, found in zip(poses, tension, K, strict=True):
        unwound = rest_lengths(robot, pose[None], t[None])[0]
        at = Potential(robot, (0.0, 0.0, -9.81), unwound, np.full(8, np.nan))
        expected = at.evaluate(pose)[2] * np.outer(at.scale, at.scale)
        np.testing.assert_allclose(0.5 * (found + found.T), expected, atol=1e-6 * np.abs(expected).max())
    line = robot_with([[0.001, 100.0], [0.01, 1000.0]])
    elastic = cdpr.load_robot("caroca_winches", overrides={"cable.axial_stiffness": 1e5})
    np.testing.assert_allclose(stiffness(line, poses, tension)[0], stiffness(elastic, poses, tension)[0], atol=1e-6)


def test_the_curve_is_a_table_in_files():
    robot = robot_with(CURVE)
    assert [list(point) for point in TABLE.rows(robot.cables[0].own)] == CURVE
    row = chain_table(robot)[0, SPAN:]
    assert row.tolist() == [0.001, 0.003, 0.006, 0.01, 0.0, 100.0, 500.0, 1500.0, 4000.0, 0.0, 0.0, 0.0]
    assert _cables(robot)["cables"][0]["stiffness_table"] == CURVE


@pytest.mark.parametrize(
    ("curve", "text"),
    [
        ([[0.002, 100.0], [0.001, 200.0]], "expected strains and tensions that rise, but point 2 is"),
        ([[0.001, 100.0], [0.002, 100.0]], "expected strains and tensions that rise, but point 2 is"),
        ([[0.0, 100.0]], "must be greater than 0"),
        ([[0.001 * k, 100.0 * k] for k in range(1, 7)], "expected at most 5 items"),
        (None, "needs the curve of tension over strain"),
    ],
)
def test_wrong_curves_are_errors(curve, text):
    table = {} if curve is None else {"cable.stiffness_table": curve}
    with pytest.raises(ScenarioError, match=text):
        cdpr.load_robot("caroca_winches", overrides={**KEYS, **table})
