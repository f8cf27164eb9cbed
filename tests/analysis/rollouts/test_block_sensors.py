"""Sensors and estimators of cases side by side: each lane has the bits of a run alone."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT
from kernel_cases import assert_same_bits, run, run_lanes
from scipy.spatial.transform import Rotation

import cdpr
from cdpr.analysis.rollouts import block, ways
from cdpr.analysis.rollouts.case import layout_of
from cdpr.native.bind import bind
from cdpr.native.operations import LANES
from cdpr.plugins import SensorModel
from cdpr.sensing import Encoders, Pose
from cdpr_controllers.estimators import EkfOptions
from cdpr_controllers.estimators.ekf import Ekf

CASES = LANES + 2  # a full group, and one that is too small
SEEDS = {"simulation.seed": list(range(CASES))}
KALMAN = {"estimator.type": "ekf"}
NOISE = {"noise": 1e-4}
ALL_ERRORS = {"noise": 1e-4, "bias": 1e-4, "drift": 1e-4, "gain": 1.0001, "resolution": 1e-5}
ENCODERS = {"type": "encoders", "length": NOISE}
POSE = {"type": "pose", "position": NOISE, "attitude": NOISE}
LATE = [
    {"type": "pose", "period": 0.004, "delay": 0.006, "jitter": 0.003, "position": ALL_ERRORS, "attitude": NOISE},
    {"type": "encoders", "period": 0.002, "delay": 0.003, "jitter": 0.004, "dropout": 0.4, "length": ALL_ERRORS},
    {"type": "twist", "dropout": 0.5, "velocity": NOISE, "turn_rate": ALL_ERRORS},
]
CEILING = {"position": [0, 0, 4], "attitude": [0, 1, 0, 0], "markers": [[0.3, 0.2, 0.2], [-0.3, 0.1, 0.1]]}
OTHERS = [
    {"type": "imu", "point": [0.1, 0.0, 0.2], "turn_rate": NOISE},
    {"type": "receiver", "antenna": [0.1, 0.2, 0.3], "period": 0.003, "position": NOISE},
    {"type": "markers", **CEILING, "pixel": {"noise": 0.5}, "dropout": 0.2},
]
LOADS = [{**ENCODERS, "delay": 0.002, "jitter": 0.004}, {"type": "tension", "tension": {"noise": 1.0}, "dropout": 0.3}]
HELD = [ENCODERS, {"type": "tension", "tension": {"noise": 1.0}, "period": 0.01, "delay": 0.006, "dropout": 0.3}]
WINCHES = {"robot": str(ROOT / "scenarios" / "robots" / "caroca_winches.yaml")}

# Name of a scenario, its changes, and the values that vary.
SEEN = {
    "pose": ("caroca", {"sensors": [POSE, {"type": "twist", "velocity": NOISE}]}, SEEDS),
    "encoders": ("caroca", {"sensors": [ENCODERS], **KALMAN}, SEEDS),
    "late": ("caroca", {"sensors": LATE, **KALMAN}, SEEDS),
    "others": ("caroca", {"sensors": OTHERS, **KALMAN}, SEEDS),
    "winches": ("winch", {"sensors": [ENCODERS], **KALMAN, **WINCHES}, SEEDS),
    "guided": ("planar", {"sensors": [POSE], **KALMAN}, SEEDS),
    "pulleys": ("cogiro_pulleys", {"sensors": [ENCODERS], **KALMAN}, SEEDS),
    "load cells": ("camera_robot", {"sensors": LOADS, **KALMAN}, SEEDS),
    "held tensions": ("camera_robot", {"sensors": HELD, **KALMAN}, SEEDS),
    "models": (
        "encoders_only",
        {},
        {
            **SEEDS,
            "sensors.0.length.noise": np.linspace(0.0, 1e-3, CASES),
            "robot.platform.mass": np.linspace(25.0, 29.0, CASES),
            "estimator.position_error": np.linspace(0.0, 0.1, CASES),
        },
    ),
    "other times": (
        "encoders_only",
        {},
        {**SEEDS, "sensors.0.period": [0.0, 0.002] * (CASES // 2), "sensors.0.dropout": np.linspace(0.0, 0.5, CASES)},
    ),
}


@pytest.fixture
def used(monkeypatch):
    """Return the ways of the operations of blocks, by the names of parts."""
    found: dict[str, set[int]] = {}
    way = block._way

    def spy(operation, bound, each):
        answer = way(operation, bound, each)
        found.setdefault(operation.name, set()).add(answer)
        return answer

    monkeypatch.setattr(block, "_way", spy)
    return found


def rollout(scenario, changes, vary, duration=0.08):
    path = ROOT / "scenarios" / f"{scenario}.yaml"
    overrides = {"simulation.duration": duration, **changes}
    layout = layout_of(cdpr.load_scenario(path, overrides=overrides))
    names = [name for name in layout.fields if name != "time"]
    found = cdpr.rollout(path, CASES, vary=vary, overrides=overrides, columns=names, every=1, threads=1)

    def alone(i):
        return cdpr.simulate(path, overrides={**overrides, **{key: values[i] for key, values in vary.items()}})

    return found, alone, names


@pytest.mark.parametrize("name", SEEN)
@pytest.mark.usual("encoders", "late")
def test_lanes_have_the_bits_of_single_runs(name, used):
    found, alone, names = rollout(*SEEN[name])
    assert found.counts == {"finished": CASES}
    assert used["sensors"] or name == "other times"
    for i in range(CASES):
        single = alone(i)
        for each in names:
            assert_same_bits(
                found[each][i].reshape(len(single.time), -1), np.asarray(single[each]).reshape(len(single.time), -1)
            )


@pytest.mark.parametrize("name", ["pose", "encoders", "late", "winches"])
def test_pose_encoders_and_filter_run_in_lanes(name, used):
    scenario, changes, vary = SEEN[name]
    rollout(scenario, changes, vary, 0.005)
    for part in ("sensors", "estimator") if name != "pose" else ("sensors",):
        assert used[part] - {ways.IN_LANES} == (set() if name != "winches" else {ways.ALONE} & used[part])


def test_a_lane_that_diverges_does_not_disturb_the_others(used):
    gains = [100.0] * CASES
    gains[4] = 1e9
    vary = {**SEEDS, "controller.kp": gains, "robot.tension.max": [1e11] * CASES}
    found, alone, names = rollout("encoders_only", {"simulation.physics_step": 0.001}, vary)
    assert found.counts == {"finished": CASES - 1, "diverged": 1}
    assert used["estimator"] == {ways.IN_LANES}
    with pytest.raises(cdpr.SimulationStopped) as stop:
        alone(4)
    assert found.messages[4] == str(stop.value)
    for i in (0, 3, 5):
        single = alone(i)
        assert all(np.array_equal(found[each][i], single[each], equal_nan=True) for each in names)


def streams(random, count):
    """States of random streams (count, 6)."""
    return np.floor(random.uniform(1.0, 4e9, (count, 6)))


COUNT = 40 * LANES


@pytest.mark.parametrize("every", [1, 3])
@pytest.mark.parametrize("late", [0, 2])
def test_lanes_measure_at_steps_of_their_own(every, late):
    """Each lane has its own step, errors, and measurements on their way."""
    random, n, slots = np.random.default_rng(every + late), 10, 2 * late + 3
    steps = np.floor(random.uniform(0.0, 30.0, COUNT))
    sent = np.where(random.random(COUNT) < 0.2, 0.0, 20.0 + np.floor(random.uniform(0.0, slots, COUNT)))
    received = np.maximum(sent - np.floor(random.uniform(0.0, slots, COUNT)), 0.0)
    time = np.where(random.random(COUNT) < 0.2, 0.0, 1e-3 * (1.0 + steps))[:, None]
    truth = random.normal(size=(COUNT, n))
    truth[:, 3:7] = Rotation.random(COUNT, rng=0).as_quat()
    shape = COUNT, 9, 5
    errors = np.where(random.random(shape) < 0.5, random.uniform(0.001, 0.1, shape), [1.0, 0.0, 0.0, 0.0, 0.0])
    pending = random.normal(size=(COUNT, slots, n + 2))
    pending[:, :, 0] = np.floor(steps[:, None] + random.uniform(-3.0, 4.0, (COUNT, slots)))
    before = {
        "stream": streams(random, COUNT),
        "walk": random.normal(size=(COUNT, 9)),
        "previous": random.normal(size=(COUNT, 3)),
        "pending": pending,
        "held": random.normal(size=(COUNT, n + 2)),
        "count": np.stack([steps, sent, received, random.choice([0.0, 0.0, 1.0], COUNT)], axis=1),
    }
    outputs = {name: array.shape[1:] for name, array in before.items()} | {"measured": (n,), "age": (1,)}
    inputs = {"truth": truth, "errors": errors, "time": time}
    values = {"step": 1e-3, "dropout": 0.3, "limit": 1.0, "every": every, "delay": late, "jitter": late, "attitude": 3}
    one, _ = run("measure", inputs, outputs, before, **values)
    lanes, _ = run_lanes("measure", inputs, outputs, before, **values)
    for name in outputs:
        assert_same_bits(lanes[name], one[name])


def test_lanes_judge_estimates_with_and_without_variance():
    random = np.random.default_rng(0)
    roots = random.normal(size=(COUNT, 12, 12)) * np.where(random.random((COUNT, 12, 1)) < 0.2, 0.0, 1.0)
    covariance = roots @ np.swapaxes(roots, 1, 2)
    covariance[::7, 3] = covariance[::7, 2]  # singular
    covariance[::7, :, 3] = covariance[::7, :, 2]
    covariance[::11, 5, 5] = np.nan
    state, estimate = (
        np.hstack(
            [random.normal(size=(COUNT, 3)), Rotation.random(COUNT, rng=i).as_quat(), random.normal(size=(COUNT, 6))]
        )
        for i in range(2)
    )
    inputs, outputs = {"state": state, "estimate": estimate, "covariance": covariance}, {"sigma": (12,), "nees": (1,)}
    one, _ = run("judge_estimate", inputs, outputs)
    lanes, _ = run_lanes("judge_estimate", inputs, outputs)
    assert 0.1 < np.isfinite(one["nees"]).mean() < 0.99
    for name in outputs:
        assert_same_bits(lanes[name], one[name])


STEPS, STEP = 40, 1e-3
WRITTEN = ("history", "count", "state", "covariance", "innovation")


def test_lanes_filter_at_steps_of_their_own():
    """Lanes start anew at different times, get late and no measurements, and one is not finite."""
    random, robot = np.random.default_rng(0), cdpr.load_robot(ROOT / "scenarios" / "robots" / "caroca.yaml")
    sensors = [Encoders(delay=0.003, jitter=0.002), Pose(delay=0.004)]
    filters = []
    for _ in range(LANES):
        models = [
            SensorModel(each, np.zeros(n), np.zeros(1), np.zeros(1)) for each, n in zip(sensors, (16, 7), strict=True)
        ]
        given = {**Ekf(robot, np.array([0.0, 0.0, -9.81]), STEP, models, EkfOptions())._given, "state": np.zeros(13)}
        filters.append({name: np.array(each) if isinstance(each, np.ndarray) else each for name, each in given.items()})
    for lane, own in enumerate(filters):
        own["start"][:] = [*robot.home[:3], 1.0, *np.zeros(9)]
        own["deviation"][:] *= np.linspace(0.5, 2.0, LANES)[lane]
    together = {
        name: np.stack([own[name] for own in filters], axis=-1) if each.dtype == float else each
        for name, each in filters[0].items()
        if isinstance(each, np.ndarray)
    }
    numbers = {name: each for name, each in filters[0].items() if not isinstance(each, np.ndarray)}
    alone, lanes = [bind("kalman_filter", **own) for own in filters], bind("kalman_filter_lanes", **together, **numbers)
    lengths = cdpr.mechanics.kinematics.lengths(robot, filters[0]["start"])
    for k in range(STEPS):
        for lane, own in enumerate(filters):
            step = k % 17 if lane == 3 else k - lane if k >= lane else k  # some start again
            own["time"][0] = STEP * step
            own["command"][:] = 1000.0 + 100.0 * random.normal(size=8)
            own["values"][:8] = lengths + 1e-3 * random.normal(size=8)
            own["values"][16:] = own["start"][:7]
            own["arrivals"][:, 0] = random.random(2) < [0.8, 0.3]
            own["arrivals"][:, 1] = STEP * random.integers(0, 7, 2)
            if k == 30 and lane in (2, 5):
                own["command"][:] = np.inf if lane == 2 else np.nan
            for name in ("time", "command", "values", "arrivals"):
                together[name][..., lane] = own[name]
        assert [call() for call in alone] == [0] * LANES
        assert lanes() == 0
        for lane, own in enumerate(filters):
            for name in WRITTEN:
                assert_same_bits(together[name][..., lane], own[name])
    assert [bool(np.isfinite(own["state"]).all()) for own in filters] == [lane != 2 for lane in range(LANES)]
