"""Sensors and estimators of an exported plant with controller: the bits of a run, also after snapshots."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from fmu.cases import plant_of, write
from fmu.driver import Driver

import cdpr
from cdpr.base.errors import CdprError
from cdpr.fmu.export import Plant, fmu_bytes
from cdpr.plugins.registry import registry
from cdpr.scenario import Scenario
from cdpr.simulation.exported import control_of
from cdpr.simulation.exported_start import exported_start
from cdpr.simulation.needs import omitted

STEP = 0.002
STEPS = 60
NOISE = {"noise": 1e-3, "drift": 1e-3}
SENSORS = [
    {"type": "pose", "name": "mocap", "position": NOISE, "attitude": NOISE, "delay": 2 * STEP, "dropout": 0.3},
    {"type": "twist", "velocity": NOISE, "turn_rate": NOISE, "period": 2 * STEP, "jitter": 2 * STEP},
]
ENCODERS = {"type": "encoders", "length": {"noise": 1e-4, "resolution": 1e-5}, "delay": STEP}
CELLS = {"type": "tension", "tension": {"noise": 0.5, "hysteresis": 0.01, "range": 200.0}}
LATE = {**CELLS, "period": 3 * STEP, "delay": 2 * STEP}
IMU = {"type": "imu", "period": 3 * STEP, "turn_rate": NOISE, "force": NOISE}
FIX = {"type": "receiver", "position": NOISE, "period": 5 * STEP, "jitter": 4 * STEP}
SMALL = {"robot.winch.type": "torque", "robot.winch.drum_radius": 0.05, "robot.winch.inertia": 0.002}
REST = {"initial.equilibrium": True}
ELASTIC = {**SMALL, "robot.cable": {"model": "elastic", "axial_stiffness": 1e5, "damping": 100.0}}
# Scenario and changes. The first two cover pose and twist without an estimator, and one that reads the winches. All but
# the first take long to compile.
CASES = {
    "measured": ("caroca", {"sensors": SENSORS}),
    "winches": ("camera_robot", {**REST, "sensors": [ENCODERS, LATE, IMU, FIX], "estimator.type": "ekf"}),
    "lengths": ("caroca", {"sensors": [ENCODERS]}),
    "kinematics": ("caroca", {"sensors": [ENCODERS], "estimator": {"type": "forward_kinematics", "filter_time": 0.01}}),
    "complementary": ("caroca", {"sensors": [ENCODERS, IMU], "estimator.type": "complementary"}),
    "ekf": ("caroca", {"sensors": [ENCODERS, IMU, FIX, *SENSORS], "estimator.type": "ekf"}),
    "elastic": ("caroca", {**ELASTIC, "sensors": [{**ENCODERS, "delay": 0.0}, *SENSORS]}),
    "feedback": ("caroca", {**ELASTIC, "sensors": [CELLS, *SENSORS], "controller.type": "tension_feedback"}),
    "servo": ("visual_servo", {}),
}
IN_FMI_2 = ("measured", "winches")


def scenario(case: str = "measured", **more: object) -> Scenario:
    name, changes = CASES[case]
    hold = {"trajectory": {"type": "hold"}, "simulation.control_step": STEP, "simulation.duration": STEPS * STEP}
    return cdpr.load_scenario(name, overrides={**hold, **changes, **more})


def exported(loaded: Scenario) -> Plant:
    plant = plant_of(loaded, loaded.simulation.physics_step)
    return replace(plant, control=control_of(loaded), state=exported_start(loaded).state)


def steps(driver: Driver, first: int, last: int, columns: list[str], start: float = 0.0) -> list[np.ndarray]:
    """Return the state at each sample after these steps, with the measurements and estimates of the sample before."""
    rows = []
    for k in range(first, last):
        driver.step(start + k * STEP, STEP)
        rows.append(np.concatenate([driver.state(), *(driver.get(name) for name in columns)]))
    return rows


def rows_of(run: cdpr.Run, columns: list[str]) -> np.ndarray:
    after = [run[name][1:].reshape(STEPS, -1) for name in ("position", "orientation", "velocity", "angular_velocity")]
    return np.concatenate([*after, *(run[name][:-1].reshape(STEPS, -1) for name in columns)], axis=1)


@pytest.mark.parametrize(
    ("case", "fmi"),
    [(name, 3) if name == "measured" else pytest.param(name, 3, marks=pytest.mark.slow) for name in CASES]
    + [pytest.param(name, 2, marks=pytest.mark.slow) for name in IN_FMI_2],
)
def test_it_equals_the_loop_also_after_snapshots(case, fmi, tmp_path):
    loaded = scenario(case)
    run = cdpr.simulate(loaded)
    plant = exported(loaded)
    columns = [column.name for column in plant.control.columns]
    assert columns
    with Driver(write(plant, fmi, tmp_path)) as driver:
        saved, found = {}, []
        for k in range(STEPS):
            if k in (1, 2, 30):
                saved[k] = driver.save()
            found += steps(driver, k, k + 1, columns)
        assert np.array_equal(found, rows_of(run, columns))
        for k, snapshot in saved.items():
            driver.restore(snapshot)
            assert np.array_equal(steps(driver, k, STEPS, columns), found[k:]), k
            driver.free(snapshot)
    other = cdpr.simulate(scenario(case, **{"simulation.seed": 1}))
    assert np.abs(rows_of(other, columns) - rows_of(run, columns)).max() > 1e-6  # the seed matters


@pytest.mark.parametrize("case", ["measured", pytest.param("winches", marks=pytest.mark.slow)])
def test_sensors_and_estimator_begin_at_any_start_time(case, tmp_path):
    plant = exported(scenario(case))
    columns = [column.name for column in plant.control.columns]
    ends = []
    for start in (0.0, 8.0):  # times in steps of a power of two would have no round-off; these have some
        with Driver(write(plant, 3, tmp_path), start=start) as driver:
            ends.append(steps(driver, 0, 20, columns, start))
    assert np.allclose(*ends, rtol=0.0, atol=1e-9)  # the steps of the plant differ by the round-off of the time


@pytest.mark.slow
def test_gains_of_an_inner_loop_are_parameters(tmp_path):
    gains = {"gain": [0.3] * 8, "integral_gain": [2.0] * 8, "integral_limit": [40.0] * 8, "kp": [90.0] * 6}
    plant = exported(scenario("feedback"))
    run = cdpr.simulate(scenario("feedback", **{f"controller.{name}": value for name, value in gains.items()}))
    with Driver(write(plant, 3, tmp_path), {f"controller.{name}": value for name, value in gains.items()}) as driver:
        assert np.array_equal(steps(driver, 0, STEPS, []), rows_of(run, []))
    assert not np.array_equal(rows_of(cdpr.simulate(scenario("feedback")), []), rows_of(run, []))


def test_measurements_and_estimates_are_outputs_with_units_and_axes(tmp_path):
    plant = exported(scenario("winches"))
    path = str(tmp_path / "plant.fmu")
    Path(path).write_bytes(fmu_bytes(plant, 3, source_only=True))
    assert validate_fmu(path) == []
    described = fmpy.read_model_description(path)
    about = {each.name: each for each in described.modelVariables}
    units = {
        "estimated_position": "m",
        "estimated_angular_velocity": "rad/s",
        "encoders_rate": "m/s",
        "tension_tension": "N",
        "imu_force": "m/s2",
        "receiver_age": "s",
    }
    assert {name: (about[name].causality, about[name].unit) for name in units} == {
        name: ("output", unit) for name, unit in units.items()
    }
    assert "platform axes" in about["imu_force"].description
    assert "world axes" in about["estimated_position"].description


def test_units_beyond_si_are_in_the_description():
    pixel = next(each for each in control_of(scenario("servo")).outputs(()) if each.name == "camera_pixel")
    assert (pixel.unit, ", px, at the last control step" in pixel.description) == ("", True)


def test_sensors_that_nothing_uses_are_left_out_and_reported():
    plain = control_of(scenario())
    more = control_of(scenario(sensors=[*SENSORS, {"type": "receiver"}, {"type": "range"}]))
    assert (plain.unused, more.unused) == ([], ["receiver", "range"])
    assert more.pipeline.names == plain.pipeline.names


class Still(cdpr.plugins.SnapshotOfArrays, cdpr.plugins.Estimator):
    arrays, closed = (), 0

    def close(self):
        type(self).closed += 1

    def estimate(self, time, out):
        out[:] = 0.0
        out[3] = 1.0


def test_an_estimator_of_a_plugin_without_kernels_is_rejected():
    plugins, name = registry().with_class("estimator", Still)
    loaded = scenario("lengths").with_changes({"estimator": {"type": name}}, plugins=plugins)
    with pytest.raises(CdprError, match=r"the estimator has no operation .* \(--set estimator.type=NAME\)"):
        control_of(loaded)
    assert Still.closed


@pytest.mark.parametrize("use", ["plant_fmu", "bare_controller_fmu", "native"])
def test_other_exports_report_sensors_and_estimator_once(use):
    lines = [line.split(":")[0] for line in omitted(scenario("kinematics"), use)]
    assert [line for line in lines if "sensor" in line or "estimat" in line] == ["sensors", "estimator"]


def test_a_sensor_with_the_name_of_a_variable_is_rejected():
    plant = exported(scenario("lengths", sensors=[{**ENCODERS, "name": "cable"}]))
    with pytest.raises(CdprError, match="column 'cable_length' has the name of another variable"):
        plant.variables()


def test_sensors_of_winches_need_the_winches():
    plant = replace(exported(scenario("winches")), winches=False)
    with pytest.raises(CdprError, match=r"sensors of the winches .* add --with-winch"):
        plant.variables()
