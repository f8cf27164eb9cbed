"""The Kalman filter with load cells: held, late and lost measurements, and the damping of cables."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT

import cdpr
from cdpr.base.errors import CdprError

ROBOT = str(ROOT / "scenarios" / "camera_robot.yaml")
# No unknown force acts, so the filter should not expect one.
REST = {
    "trajectory": {"type": "hold"},
    "initial.equilibrium": True,
    "estimator": {"type": "ekf", "force_noise": 1e-3},
    "simulation.duration": 1.0,
}
VALUES = 6  # of the error of a point mass: position and velocity
ENCODERS = {"type": "encoders", "length": {"noise": 5e-4}}
CELLS = {"type": "tension", "tension": {"noise": 1.0}}
FINE = {"type": "tension", "tension": {"noise": 0.01}}
POINTS = {"type": "receiver", "position": {"noise": 1e-3}}

# Sensors, and changes of the robot.
CASES = {
    "damped": ([ENCODERS, CELLS], {}),
    "nearly undamped": ([ENCODERS, CELLS], {"robot.cable.damping": 1e-3}),
    "fine": ([ENCODERS, FINE], {}),
    "held for 20 ms": ([ENCODERS, {**CELLS, "period": 0.02}], {}),
    "held for 100 ms": ([ENCODERS, {**CELLS, "period": 0.1}], {}),
    "lost": ([ENCODERS, {**CELLS, "dropout": 0.5}], {}),
    "late": ([ENCODERS, {**CELLS, "delay": 0.1}], {}),
    "all late": ([{**ENCODERS, "delay": 0.1}, {**CELLS, "delay": 0.1}], {}),
    "held and late": ([ENCODERS, {**CELLS, "period": 0.02, "delay": 0.02}], {}),
    "positions": ([POINTS, {**CELLS, "period": 0.02}], {}),
}
# The average over the runs of their second half: errors of half a second are strongly correlated, and changes of a held
# tension that are only noise make the covariance larger, most of all if no measurement is in time.
LOW, HIGH = 0.75, 1.2
LOWEST = {"all late": 0.35}
INNOVATIONS = 0.1
WIDEST = 3.0  # of the mean over the runs at any step, from the start on


def judge(sensors, changes, runs):
    overrides = {**REST, "sensors": sensors, **changes}
    names = ["nees", "nis", "nis_size", "position", "estimated_position", "estimate_sigma"]
    vary = {"simulation.seed": list(range(runs))}
    found = cdpr.rollout(ROBOT, runs, vary=vary, overrides=overrides, columns=names, every=1, threads=1)
    assert found.counts == {"finished": runs}
    nees = found["nees"].reshape(runs, -1) / VALUES
    late = nees.shape[1] // 2
    error = (found["estimated_position"] - found["position"])[:, late:]
    return {
        "errors": nees[:, late:].mean(),
        "largest": nees.mean(axis=0).max(),
        "innovations": np.nansum(found["nis"][:, late:]) / found["nis_size"][:, late:].sum(),
        "position": np.mean((error / found["estimate_sigma"][:, late:, :3]) ** 2),  # from the true state alone
    }


def check(name, found):
    low = LOWEST.get(name, LOW)
    assert low < found["errors"] < HIGH
    assert low < found["position"] < HIGH
    assert found["largest"] < WIDEST
    assert found["innovations"] == pytest.approx(1.0, abs=INNOVATIONS)


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_errors_agree_with_their_covariance(name):
    found = judge(*CASES[name], runs=96)
    print(name, found)
    check(name, found)


def test_a_short_sample_agrees():
    found = judge(*CASES["held for 20 ms"], runs=8)
    assert 0.5 < found["errors"] < 1.6  # 8 runs of strongly correlated errors
    assert found["innovations"] == pytest.approx(1.0, abs=INNOVATIONS)


@pytest.mark.parametrize(("cells", "most"), [({"period": 0.02}, 1e-3), ({"delay": 0.1}, 1e-3), ({"period": 0.1}, 0.01)])
def test_held_tensions_of_a_moving_platform(cells, most):
    """The platform drops by 143 mm and vibrates: the tensions change while they are held."""
    about = {"sensors": [ENCODERS, {**CELLS, **cells}], "estimator.type": "ekf", "simulation.duration": 1.0}
    found = cdpr.simulate(ROBOT, overrides=about)
    late = found.time > 0.5
    error = (found["estimated_position"] - found.position)[late]
    assert np.sqrt(np.mean(np.sum(error**2, axis=1))) < most
    assert found["nees"][late].mean() / VALUES < 4.0
    assert found["nees"].max() / VALUES < 8.0  # also before the first tension, and just after it


@pytest.mark.parametrize("length", [0.1, 0.7])
def test_load_cells_that_fail_while_the_platform_moves(length):
    """A tenth of a second later, the tensions are unknown, so that the covariance grows."""
    failure = {"type": "sensor_failure", "sensor": "tension", "time": 0.3, "duration": length}
    about = {"sensors": [ENCODERS, CELLS], "estimator.type": "ekf", "simulation.duration": 1.0, "events": [failure]}
    found = cdpr.simulate(ROBOT, overrides=about)
    begun = found.time > 0.05
    assert found["nees"][begun].max() / VALUES < 8.0
    assert found["estimate_sigma"][-1, 2] < (0.005 if length < 0.5 else 1.0)  # m; they are back after 0.1 s


def test_before_the_first_tension_unknown_ones_carry_the_weight():
    """The true platform falls freely from unloaded lines; the filter does not, but expects an unknown wrench."""
    about = {"sensors": [ENCODERS, {**CELLS, "delay": 0.02}], "estimator.type": "ekf", "simulation.duration": 0.1}
    found = cdpr.simulate(ROBOT, overrides=about)
    assert abs(found.velocity[9, 2]) > 0.15
    assert np.abs(found["estimated_velocity"][:10, 2]).max() == 0.0
    assert found["nees"].max() / VALUES < 4.0
    rest = cdpr.simulate(ROBOT, overrides={**REST, **about})
    assert np.abs(rest["estimated_velocity"][:10]).max() < 0.02
    assert rest["nees"].max() / VALUES < 4.0


def test_tensions_held_for_very_long_are_rejected():
    sensors = [ENCODERS, {**CELLS, "period": 3.0}]
    with pytest.raises(
        CdprError, match="'tension': expected period, delay and jitter together of at most 1000 control"
    ):
        cdpr.simulate(ROBOT, overrides={"sensors": sensors, "estimator.type": "ekf"})
