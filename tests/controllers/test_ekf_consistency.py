"""Consistency of the Kalman filter: NEES and NIS over many runs of robots in plain numpy."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT
from filtered_robots import consistency
from scipy.stats import chi2

import cdpr
from cdpr.mechanics.properties import home_pose

# Robots, their mean tensions, N, and the densities of the unknown force, N sqrt(s), and moment, N m sqrt(s).
ROBOTS = {
    "off_centre": (800.0, 1.0, 0.3),
    "cogiro_pulleys": (600.0, 1.0, 0.5),
    "caroca_winches": (800.0, 1.0, 0.5),
    "planar": (150.0, 0.2, 0.02),
    "cogiro": (600.0, 1.0, 0.5),
    "seven": (150.0, 0.2, 0.1),
}
# Steps until the velocity is known to a few mm/s. Until then, errors of the Coulomb friction are not normal: NEES is a
# tenth too large.
SETTLED = {"caroca_winches": 60}
CHANCE = 0.95
# Least share of the steps at which the average over the runs is within its band: innovations are independent of each
# other, errors of successive steps are not, so whole stretches of time lie outside.
LEAST_OF_INNOVATIONS, LEAST_OF_ERRORS = 0.88, 0.75
# The average over all steps and runs: some hundred independent values at least, with a deviation of sqrt(2 / n) each.
MEAN_OF_INNOVATIONS, MEAN_OF_ERRORS = 0.02, 0.08


def load(name):
    return cdpr.load_robot(ROOT / "scenarios" / "robots" / f"{name}.yaml")


def share_within(values, size):
    """Share of the steps at which the average of values (steps, runs) is in the band of chi-squared averages."""
    runs = values.shape[1]
    low, high = chi2.ppf([0.5 - 0.5 * CHANCE, 0.5 + 0.5 * CHANCE], size * runs) / runs
    return np.mean((values.mean(axis=1) > low) & (values.mean(axis=1) < high))


def judge(name, runs, steps):
    robot = load(name)
    tension, force, moment = ROBOTS[name]
    pose = np.array(home_pose(robot)[0])
    nees, nis = consistency(robot, pose, tension, runs=runs, steps=steps, force=force, moment=moment)
    nees = nees[SETTLED.get(name, 0) :]
    found = {
        "errors within": share_within(nees, 2 * robot.n),
        "innovations within": share_within(nis, robot.m),
        "errors": nees.mean() / (2 * robot.n),
        "innovations": nis.mean() / robot.m,
    }
    print(name, {key: round(float(value), 4) for key, value in found.items()})
    return found


@pytest.mark.slow
@pytest.mark.parametrize("name", ROBOTS)
def test_errors_and_innovations_are_within_their_bands(name):
    found = judge(name, runs=100, steps=300)
    assert found["innovations within"] >= LEAST_OF_INNOVATIONS
    assert found["errors within"] >= LEAST_OF_ERRORS
    assert found["innovations"] == pytest.approx(1.0, abs=MEAN_OF_INNOVATIONS)
    assert found["errors"] == pytest.approx(1.0, abs=MEAN_OF_ERRORS)


def test_a_short_sample_is_consistent():
    found = judge("off_centre", runs=10, steps=60)
    assert found["innovations"] == pytest.approx(1.0, abs=0.1)  # 4800 values: 0.02 is one standard deviation
    assert found["errors"] == pytest.approx(1.0, abs=0.35)  # 10 runs of correlated errors: 0.13
