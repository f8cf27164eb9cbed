"""Sensors of an exported plant with controller: noise, delays and losses as in a run, and part of its snapshots."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fmu.cases import plant_of, write
from fmu.driver import Driver

import cdpr
from cdpr.base.errors import ScenarioError
from cdpr.simulation.exported import control_of
from cdpr.simulation.needs import omitted

STEP = 0.002
STEPS = 60
NOISE = {"noise": 1e-3, "drift": 1e-3}
SENSORS = [
    {"type": "pose", "name": "mocap", "position": NOISE, "attitude": NOISE, "delay": 2 * STEP, "dropout": 0.3},
    {"type": "twist", "velocity": NOISE, "turn_rate": NOISE, "period": 2 * STEP, "jitter": 2 * STEP},
]
HOLD = {"trajectory": {"type": "hold"}, "simulation.control_step": STEP, "simulation.duration": STEPS * STEP}
ROUND_OFF = 1e-12  # of the state, in which noise of 1e-3 m appears as 1e-6 m


def scenario(**more):
    return cdpr.load_scenario("caroca", overrides={**HOLD, "sensors": SENSORS, **more})


@pytest.mark.parametrize("fmi", [3, pytest.param(2, marks=pytest.mark.slow)])
def test_it_equals_the_loop_also_after_snapshots(fmi, tmp_path):
    loaded = scenario()
    run = cdpr.simulate(loaded)
    assert np.abs(run["mocap_position"] - run.position).max() > 1e-3  # the controller sees noise
    expected = np.concatenate([run.position, run.orientation, run.velocity, run.angular_velocity], axis=1)
    plant = replace(plant_of(loaded), control=control_of(loaded))
    with Driver(write(plant, fmi, tmp_path)) as driver:
        saved, found = {}, [driver.state()]
        for k in range(STEPS):
            if k in (1, 2, 30):
                saved[k] = driver.save()
            driver.step(k * STEP, STEP)
            found.append(driver.state())
        assert np.allclose(found, expected, rtol=0.0, atol=ROUND_OFF)
        for k, snapshot in saved.items():
            driver.restore(snapshot)
            again = []
            for i in range(k, STEPS):
                driver.step(i * STEP, STEP)
                again.append(driver.state())
            assert np.array_equal(again, found[k + 1 :]), k
            driver.free(snapshot)
    other = cdpr.simulate(scenario(**{"simulation.seed": 1}))
    assert np.abs(other.position - run.position).max() > 1e3 * ROUND_OFF  # the seed matters


def test_the_first_measurement_arrives_at_once_at_any_start_time(tmp_path):
    plant = replace(plant_of(scenario()), control=control_of(scenario()))
    ends = []
    for start in (0.0, 5.0):
        with Driver(write(plant, 3, tmp_path), start=start) as driver:
            for k in range(5):
                driver.step(start + k * STEP, STEP)
            ends.append(driver.state())
    assert np.allclose(ends[0], ends[1], rtol=0.0, atol=ROUND_OFF)


def test_recorded_sensors_are_left_out_and_encoders_are_refused():
    loaded = scenario(sensors=[*SENSORS, {"type": "receiver"}])
    left_out = "sensors: only the sensors that the controller uses are exported (receiver)"
    assert {*omitted(loaded, "controller_fmu")} == {*omitted(scenario(), "controller_fmu"), left_out}
    assert control_of(loaded).pipeline.names == control_of(scenario()).pipeline.names
    with pytest.raises(ScenarioError, match="true lengths"):
        control_of(scenario(sensors=[{"type": "encoders"}]))
