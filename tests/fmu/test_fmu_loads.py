"""Bodies on the platform of an exported FMU: as in a run, at their times, and part of its snapshots."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fmu.cases import FMI, plant_of, write
from fmu.driver import Driver, FMICallException

import cdpr
from cdpr.simulation.exported import control_of, loads_of

STEP = 0.002
TURNED = [0.5, 0.6, 0.7, 0.1, 0.05, -0.02]
TAKEN = {"type": "payload", "time": 0.1, "duration": 0.2, "mass": 30.0, "center": [0.1, -0.05, -0.3], "inertia": TURNED}
SECOND = {"type": "payload", "time": 0.2, "mass": 8.0, "center": [-0.2, 0.1, 0.0], "known": True}
DESIRED = (
    ("desired_position", 3),
    ("desired_quaternion", 4),
    ("desired_velocity", 3),
    ("desired_angular_velocity", 3),
    ("desired_acceleration", 3),
    ("desired_angular_acceleration", 3),
)
GIVEN = {"events": [TAKEN, SECOND], "simulation.duration": 0.4, "simulation.control_step": STEP}


def scenario(name="caroca", **more):
    return cdpr.load_scenario(name, overrides={**GIVEN, **more})


def put(driver, desired):
    first = 0
    for name, size in DESIRED:
        driver.set(name, desired[first : first + size])
        first += size


@pytest.mark.slow  # a controller with several loads is a library of its own
@FMI
def test_with_its_controller_it_equals_the_loop(fmi, tmp_path):
    """Also after each restore of a snapshot, before and after a change, to the bit."""
    loaded = scenario(**{"controller.type": "pid", "controller.kp": 100, "controller.kd": 20, "controller.ki": 50})
    run = cdpr.simulate(loaded)
    plant = replace(plant_of(loaded), control=control_of(loaded), loads=loads_of(loaded))
    desired = np.array([loaded.desired.sample(t) for t in run.time])
    expected = np.concatenate([run.position, run.orientation, run.velocity, run.angular_velocity], axis=1)
    with Driver(write(plant, fmi, tmp_path)) as driver:
        saved, found = {}, [driver.state()]

        def go(k):
            put(driver, desired[k])
            driver.step(k * STEP, STEP)
            return driver.state()

        for k in range(200):
            if k in (49, 50, 51, 120, 150):
                saved[k] = driver.save()
            found.append(go(k))
        assert np.allclose(found, expected, rtol=0.0, atol=1e-12)
        for k, snapshot in saved.items():
            driver.restore(snapshot)
            assert np.array_equal([go(i) for i in range(k, 200)], found[k + 1 :]), k
            driver.free(snapshot)


@pytest.mark.parametrize("name", ["caroca", "planar", "spherical"])
@pytest.mark.usual("caroca")
def test_a_step_of_the_host_is_divided_at_the_times(name, tmp_path):
    """Steps of 0.4 s and of a physics step end in one state; without a body they end in another."""
    event = {**TAKEN, "mass": 0.5} if name != "caroca" else TAKEN
    loaded = scenario(name, events=[event])
    plant = replace(plant_of(loaded), loads=loads_of(loaded))
    ends = []
    for case, steps in ((plant, 1), (plant, 400), (plant_of(loaded), 400)):
        with Driver(write(case, 3, tmp_path)) as driver:
            driver.set("cable_tension", np.full(loaded.robot.m, 50.0))
            for k in range(steps):
                driver.step(k * 0.4 / steps, 0.4 / steps)
            ends.append(driver.state())
    assert np.allclose(ends[0], ends[1], rtol=0.0, atol=1e-10)
    assert np.abs(ends[0] - ends[2]).max() > 1e-4


def test_masses_are_parameters_and_derivatives_are_refused(tmp_path):
    loaded = scenario()
    plant = replace(plant_of(loaded), loads=loads_of(loaded))
    with Driver(write(plant, 3, tmp_path)) as driver:
        assert driver.get("load_mass").tolist() == [30.0, 8.0]
        assert driver.get("load_start") == pytest.approx([0.1, 0.2])
        driver.set("load_mass", [0.0, 0.0])
        driver.set("load_inertia", np.zeros(18))
        driver.step(0.0, 0.3)
        light = driver.state()
        with pytest.raises(FMICallException):
            driver.fmu.getDirectionalDerivative(driver.references["acceleration"], driver.references["mass"], [1.0])
        inertia = np.zeros((2, 3, 3))
        inertia[1, 0, 0] = -1.0
        for name, value in {"load_mass": [5.0, -5.0], "load_inertia": inertia.ravel()}.items():
            before = driver.get(name)
            driver.set(name, value)
            with pytest.raises(FMICallException):
                driver.step(0.3, 0.1)
            driver.set(name, before)
    with Driver(write(plant_of(loaded), 3, tmp_path)) as driver:
        driver.step(0.0, 0.3)
        assert np.allclose(driver.state(), light, rtol=0.0, atol=1e-10)
