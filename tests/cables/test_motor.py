"""Electrical side of motors against the closed forms of the DC motor, in runs, summaries, sizes and messages."""

from __future__ import annotations

import numpy as np
import pytest

import cdpr
from cdpr.analysis.distribution.describe import describe_robot
from cdpr.analysis.sizing.demands import demands
from cdpr.analysis.sizing.duty import Duty
from cdpr.analysis.sizing.sizes import sizing
from cdpr.cables.motor import motor_readings
from cdpr.log.summary import Accumulator
from cdpr.simulation.columns import columns_of
from cdpr.ui.report.plots.run import by_name
from cdpr.ui.report.text.description import _winches

CONSTANT, RESISTANCE, GEAR = 0.08, 0.6, 12.0  # N m/A, ohm
MOTOR = {"torque_constant": CONSTANT, "resistance": RESISTANCE, "gear_ratio": GEAR}
CLOSE = 1e-12  # round-off of three operations
ELECTRICAL = "motor_current", "motor_voltage", "electrical_power"


def scenario(motor=None, **changes):
    winch = {f"robot.winch.{key}": value for key, value in (MOTOR if motor is None else motor).items()}
    return cdpr.load_scenario("scenarios/winch.yaml", overrides={"simulation.duration": 0.6, **winch, **changes})


@pytest.fixture(scope="module")
def run():
    return cdpr.simulate(scenario())


def test_a_motor_is_the_dc_motor_of_the_textbook(run):
    """The shaft turns N times as fast as the drum with 1 / N of its torque; k_t is also the voltage constant."""
    torque, speed = run.motor_torque / GEAR, run.drum_speed * GEAR
    current = torque / CONSTANT
    voltage = RESISTANCE * current + CONSTANT * speed
    np.testing.assert_allclose(run.motor_current, current, rtol=CLOSE)
    np.testing.assert_allclose(run.motor_voltage, voltage, rtol=CLOSE, atol=CLOSE * np.abs(voltage).max())
    balance = RESISTANCE * current**2 + run.motor_power
    np.testing.assert_allclose(run.electrical_power, balance, rtol=CLOSE, atol=CLOSE * np.abs(balance).max())
    assert np.abs(run.motor_power).max() > 50.0


def test_no_load_speed_and_stall_current():
    """At u = k_t N w there is no torque; at rest, the current is u / R."""
    robot = scenario().robot
    m, supply = robot.m, 24.0
    free, stall = supply / (CONSTANT * GEAR), CONSTANT * GEAR * supply / RESISTANCE
    torque, speed = np.array([[0.0] * m, [stall] * m]), np.array([[free] * m, [0.0] * m])
    current, voltage, power = motor_readings(robot, torque, speed)
    np.testing.assert_allclose(voltage, supply, rtol=CLOSE)
    np.testing.assert_allclose(current, [[0.0] * m, [supply / RESISTANCE] * m], rtol=CLOSE)
    np.testing.assert_allclose(power, [[0.0] * m, [supply**2 / RESISTANCE] * m], rtol=CLOSE)


def test_electrical_data_change_no_bit_of_a_run(run):
    plain = cdpr.simulate(scenario({}))
    names = plain.header.layout.fields
    assert not set(ELECTRICAL) & set(names)
    assert set(run.header.layout.fields) - set(names) == set(ELECTRICAL)
    for name in names:
        assert run[name].tobytes() == plain[name].tobytes(), name
    assert "motor_current_A" not in plain.summary()
    with pytest.raises(AttributeError, match="a motor with a `torque_constant`"):
        plain.motor_current  # noqa: B018


def test_the_summary_integrates_the_powers(run):
    figures = run.summary()
    power, time = run.electrical_power, run.time
    used, back = (np.trapezoid(np.maximum(each, 0.0), time, axis=0).sum() for each in (power, -power))
    assert figures["electrical_energy_J"]["used"] == pytest.approx(used, rel=CLOSE)
    assert figures["electrical_energy_J"]["regenerated"] == pytest.approx(back, rel=CLOSE)
    rms = np.sqrt(np.trapezoid(run.motor_current**2, time, axis=0) / time[-1]).max()
    assert figures["motor_current_A"]["rms"] == pytest.approx(rms, rel=CLOSE)
    assert figures["motor_current_A"]["max"] == np.abs(run.motor_current).max()
    assert figures["motor_voltage_V"]["max"] == np.abs(run.motor_voltage).max()


def test_figures_do_not_depend_on_the_size_of_batches(run):
    whole, parts = (Accumulator(run.header, len(run.rows)) for _ in range(2))
    whole.add(run.rows)
    for first, stop in ((0, 1), (1, 8), (8, 300), (300, len(run.rows))):
        parts.add(run.rows[first:stop])
    assert parts.figures() == whole.figures()


@pytest.mark.parametrize("weight", [False, True], ids=["winding in", "paying out"])
def test_sizes_have_the_energy_of_a_steady_motion(weight):
    """A tension T at a speed v: i = r T / (k_t N), P = R i^2 +- T v; it is fed back if the cable drives the motor."""
    robot = scenario().robot
    radius, tension, speed, duration = 0.05, 300.0, 0.5, 2.0
    frictionless = {"drum_radius": radius, "inertia": 0.002, "viscous_friction": 0.0, "coulomb_friction": 0.0}
    robot = scenario({}, **{"robot.winch": {**frictionless, **MOTOR}}).robot
    time = np.linspace(0.0, duration, 201)
    rate = np.full((201, robot.m), speed if weight else -speed)
    pose, wrench = np.tile([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], (201, 1)), np.zeros((201, 6))
    held = np.full((201, robot.m), tension)
    length = 3.0 + rate * time[:, None]
    duty = Duty("made", robot, held, length, np.ones(201, bool), time, rate, pose, wrench)
    found = demands(duty)
    current = radius * tension / (CONSTANT * GEAR)
    omega = (-1.0 if weight else 1.0) * GEAR * speed / radius
    power = RESISTANCE * current**2 + (-1.0 if weight else 1.0) * tension * speed
    assert found.current == pytest.approx(current)
    assert found.current_rms == pytest.approx(current)
    assert found.voltage == pytest.approx(abs(RESISTANCE * current + CONSTANT * omega))
    assert found.used == pytest.approx(max(power, 0.0) * duration)
    assert found.regenerated == pytest.approx(max(-power, 0.0) * duration)
    assert found.feedback_power == pytest.approx(max(-power, 0.0))
    assert (power < 0.0) == weight


def test_sizes_report_too_weak_supplies_and_motors(run):
    strong = sizing([Duty.of_scenario(scenario(MOTOR | {"supply_voltage": 1e3, "rated_current": 1e3}), "strong")])
    assert not strong.parts[0][4]
    weak = sizing([Duty.of_scenario(scenario(MOTOR | {"supply_voltage": 0.1, "rated_current": 0.1}), "weak")])
    volts, amperes = weak.parts[0][4]
    assert "cable_8 have motors that need more than their supply_voltage" in volts
    assert "cable_8 have motors whose rms current exceeds their rated_current" in amperes
    unknown = sizing([Duty.of_scenario(scenario({}), "unknown")]).to_dict()["cables"][0]
    assert unknown["motor_current_peak_A"] is unknown["electrical_energy_used_J"] is None


def test_columns_and_panels(run):
    panels = by_name(run)
    assert {"motor_current", "electrical_power"} <= set(panels)
    assert "motor_current" not in by_name(cdpr.simulate(scenario({}, **{"simulation.duration": 0.01})))
    (line,) = _winches(describe_robot(scenario().robot)["cables"])
    assert "motor of 0.08 N m/A and 0.6 ohm" in line


def test_motors_without_torque_have_no_current():
    """An ideal drive follows its command, with any torque."""
    ideal = {"robot.winch": {"type": "position", "drum_radius": 0.05, **MOTOR}}
    servo = {"robot.cables[0].winch": {"type": "torque", "drum_radius": 0.05, "inertia": 0.002, **MOTOR}}
    changes = {"simulation.duration": 0.05, **ideal, **servo}
    mixed = cdpr.simulate(cdpr.load_scenario("scenarios/camera_robot.yaml", overrides={**changes, **COMPUTED}))
    assert np.isfinite(mixed.motor_current[:, 0]).all()
    assert np.isnan(mixed.motor_current[:, 1:]).all()
    assert mixed.summary()["motor_current_A"]["max"] == np.abs(mixed.motor_current[:, 0]).max()


def test_steppers_ignore_electrical_data():
    winch = {"type": "stepper", "drum_radius": 0.05, "stall_torque": 3.0, **MOTOR}
    loaded = cdpr.load_scenario("scenarios/camera_robot.yaml", overrides={"robot.winch": winch})
    assert set(loaded.unused) == {"robot.winch.torque_constant", "robot.winch.resistance"}
    assert not set(ELECTRICAL) & {column.name for column in columns_of(loaded)}


COMPUTED = {"controller": {"type": "computed_torque", "kp": 40.0, "kd": 12.0}}
MESSAGES = {
    "resistance": ({"torque_constant": 0.1}, "torque_constant: currents and voltages of a motor need resistance (ohm)"),
    "supply": ({"supply_voltage": 48.0}, "need torque_constant (N m/A) and resistance (ohm) too"),
    "negative": ({"torque_constant": -0.1, "resistance": 1.0}, "must be greater than 0 (N m/A), got -0.1"),
}


@pytest.mark.parametrize("name", MESSAGES)
def test_messages(name):
    motor, text = MESSAGES[name]
    with pytest.raises(cdpr.CdprError) as caught:
        scenario(motor)
    assert text in str(caught.value)
