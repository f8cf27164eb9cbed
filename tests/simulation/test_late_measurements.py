"""Periods and delays of measurements in the linearised loop, against simulated motions."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import cdpr
from cdpr.simulation.linearised import linearise
from cdpr.simulation.linearised_scenario import NotLinearisedError
from cdpr.simulation.loop_problems import loop_problems
from cdpr.simulation.poles import LASTS, STABLE, UNSTABLE, bandwidths, poles, sampling, verdict

STEP = 0.001
SMALL = 1e-5  # m/s, rad/s: speed at the start; products of such motions are below the tolerance
LINEAR = 1e-4  # of a motion: the loop is linear up to this
GAIN = 1.02  # of the measured position; a bias keeps the pose of rest
TIMES = ("delay", 0), ("period", 1)  # and their least numbers of control steps
POSE = {"type": "pose", "delay": 0.003, "period": 0.002}
TWIST = {"type": "twist", "delay": 0.005, "period": 0.003, "velocity": {"gain": 0.9}}


def scenario(name="caroca", sensors=(POSE, TWIST), **more):
    given = {"trajectory": {"type": "hold"}, "simulation.duration": 0.3, "events": [], **more}
    return cdpr.load_scenario(name, overrides={**given, "sensors": list(sensors)})


def coordinates(run, pose, rows):
    """Return position, rotation vector and their rates of a run in the free directions, relative to a pose."""
    turned = Rotation.from_quat(run.orientation, scalar_first=True)
    turned = turned * Rotation.from_quat(pose[3:], scalar_first=True).inv()
    full = np.hstack([run.position - pose[:3], turned.as_rotvec(), run.velocity, run.angular_velocity])
    return full[:, [*rows, *(6 + row for row in rows)]]


@pytest.mark.parametrize("name", ["caroca", "planar", pytest.param("cogiro", marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    "sensors",
    [
        (POSE, TWIST),
        ({"type": "pose", "delay": 0.004}, {"type": "twist"}),
        ({"type": "pose", "delay": 0.017, "period": 0.005}, {"type": "twist", "delay": 0.001, "period": 0.01}),
    ],
)
def test_simulated_motions_follow_the_linearised_loop(name, sensors):
    pose = scenario(name).initial.state()[:7]
    errors = {"gain": GAIN, "bias": ((1.0 - GAIN) * pose[:3]).tolist()}
    loaded = scenario(name, [{**sensors[0], "position": errors}, sensors[1]])
    robot, loop = loaded.robot, linearise(loaded, pose)
    kept = 2 * robot.n
    at_rest = loop.rest[:kept]
    free = np.isin(range(6), robot.rows)
    speed = SMALL * np.where(free, [1.0, -0.5, 0.7, 0.4, -0.8, 0.6], 0.0)
    start = {"initial.velocity": speed[:3].tolist(), "initial.angular_velocity": speed[3:].tolist()}
    run = cdpr.simulate(loaded.with_changes(start))
    x = (coordinates(run, pose, robot.rows) - at_rest) / loop.scale[:kept]
    span = round(loop.period / STEP)
    delay, every = ([max(least, round(each.get(key, 0.0) / STEP)) for each in sensors] for key, least in TIMES)
    assert span == np.lcm(*every)
    # all measurements in use are later than the first one, which arrives at once
    first = span * (1 + max(d + n for d, n in zip(delay, every, strict=True)) // span)
    state = x[first]
    for part, d, n in zip((slice(0, robot.n), slice(robot.n, kept)), delay, every, strict=True):
        for back in range(n, d + n, n):  # used later: not older than the delay and a period
            state = np.append(state, x[first - back, part])
    assert len(state) == len(loop.scale)
    size = np.abs(x).max(axis=0)
    for k in range(first, len(x) - 1, span):
        assert (np.abs(state[:kept] - x[k]) < LINEAR * size.max()).all(), k
        state = loop.A @ state


@pytest.mark.slow
def test_a_delay_makes_the_loop_unstable_as_in_a_run():
    verdicts = {}
    for delay in (0.0, 0.01, 0.04):
        sensors = tuple({"type": kind, "delay": delay, "period": 0.002} for kind in ("pose", "twist"))
        fast = {"controller.kp": 900.0, "controller.kd": 60.0, "simulation.duration": 1.0}
        loaded = scenario(sensors=sensors, **fast, **{"initial.velocity": [SMALL, 0.0, 0.0]})
        verdicts[delay] = verdict(linearise(loaded, loaded.initial.state()[:7]))
        motion = np.abs(cdpr.simulate(loaded).velocity[:, 0])
        assert (motion[-200:].max() > motion[:200].max()) == (verdicts[delay] == UNSTABLE)
    assert (verdicts[0.0], verdicts[0.04]) == (STABLE, UNSTABLE)


def test_bandwidth_with_many_measurements_on_their_way():
    """States that only wait are eliminated from the response."""
    late = [{"type": kind, "delay": 0.06, "period": 0.005} for kind in ("pose", "twist")]
    loaded = scenario(sensors=late)
    loop = linearise(loaded, loaded.initial.state()[:7], response=True)
    frequency = bandwidths(loop)[0]
    z = np.exp(2j * np.pi * frequency * loop.period)
    whole = np.linalg.solve(z * np.eye(len(loop.A)) - loop.A, loop.B.astype(complex))
    at_rest = np.linalg.solve(np.eye(len(loop.A)) - loop.A, loop.B)
    assert abs(whole[0, 0]) == pytest.approx(abs(at_rest[0, 0]) / np.sqrt(2.0), rel=1e-4)  # the grid starts at 1e-3


def test_exact_sensors_change_no_pole_and_random_errors_are_noted():
    loaded = scenario(sensors=())
    pose = loaded.initial.state()[:7]
    noisy = ({"type": "pose", "position": {"noise": 1e-3}}, {"type": "twist", "dropout": 0.1}, {"type": "receiver"})
    plain, sensed = linearise(loaded, pose), linearise(scenario(sensors=noisy), pose)
    assert np.allclose([each.value for each in poles(plain)], [each.value for each in poles(sensed)], rtol=1e-6)
    assert sensed.notes[-1] == "noise, drift, jitter and losses of the measurements are ignored: pose, twist"


@pytest.mark.parametrize(
    ("sensors", "text"),
    [
        (({"type": "encoders"},), "rates that encoders measure"),
        (({"type": "pose", "position": {"resolution": 1e-3}}, {"type": "twist"}), "resolution of the sensor 'pose'"),
        (({"type": "pose", "period": 0.011}, {"type": "twist", "period": 0.013}), "repeat after 143 control steps"),
        (({"type": "pose", "delay": 1.0}, {"type": "twist"}), "up to 1000 measurements"),
    ],
)
def test_other_loops_are_refused(sensors, text):
    with pytest.raises(NotLinearisedError, match=text):
        linearise(scenario(sensors=sensors), scenario().initial.state()[:7])


LATE = {"type": "pose", "delay": 0.02, "period": 0.005}, {"type": "twist", "delay": 0.02, "period": 0.005}


def test_memory_of_measurements_is_no_vibration_of_the_loop():
    """Held measurements have modes at half of their rate, which the control step does not have to resolve."""
    loaded = scenario(sensors=LATE)
    loop = linearise(loaded, loaded.initial.state()[:7])
    fast = [pole for pole in poles(loop) if abs(pole.z) > LASTS]
    assert max(pole.value.imag for pole in fast) * loop.period > 1.0
    assert sampling(loop, loaded, fast) == []


def test_unknown_poles_are_no_error_of_validation():
    loaded = scenario(sensors=[{"type": "pose", "delay": 1.0}, {"type": "twist"}])
    assert loop_problems(loaded)[0].startswith("not computed: up to 1000 measurements")
