"""Currents, voltages and electrical powers of motors as outputs of exported plants with winches."""

from __future__ import annotations

import fmpy
import numpy as np
from fmpy.validation import validate_fmu
from fmu.cases import ELASTIC, plant_of, write
from fmu.driver import Driver

import cdpr

CONSTANT, RESISTANCE, RATIO = 0.12, 0.5, 8.0  # N m/A and ohm of the motor, turns per turn of the drum
MOTORS = [
    *ELASTIC,
    f"robot.winch.torque_constant={CONSTANT}",
    f"robot.winch.resistance={RESISTANCE}",
    f"robot.winch.gear_ratio={RATIO}",
]
UNITS = {"motor_current": "A", "motor_voltage": "V", "electrical_power": "W"}


def test_they_are_those_of_dc_motors(tmp_path):
    loaded = cdpr.load_scenario("cogiro", overrides=MOTORS)
    path = write(plant_of(loaded), 3, tmp_path)
    assert validate_fmu(str(path)) == []
    about = {each.name: each for each in fmpy.read_model_description(str(path)).modelVariables}
    assert {name: about[name].unit for name in UNITS} == UNITS
    with Driver(path) as driver:
        driver.set("command", 300.0 + 100.0 * np.sin(np.arange(loaded.robot.m)))
        for k in range(5):
            driver.step(0.01 * k, 0.01)
        torque, speed = driver.get("motor_torque") / RATIO, driver.get("drum_speed") * RATIO  # of the shaft
        assert np.abs(torque).min() > 0.1
        assert np.abs(speed).min() > 0.1
        current = torque / CONSTANT
        voltage = RESISTANCE * current + CONSTANT * speed
        np.testing.assert_allclose(driver.get("motor_current"), current, rtol=1e-14)
        np.testing.assert_allclose(driver.get("motor_voltage"), voltage, rtol=1e-13)  # a sum of two signs
        np.testing.assert_allclose(driver.get("electrical_power"), voltage * current, rtol=1e-13)


def test_robots_without_data_of_motors_have_no_such_outputs():
    plant = plant_of(cdpr.load_scenario("cogiro", overrides=ELASTIC))
    assert not UNITS.keys() & {each.name for each in plant.variables()}
