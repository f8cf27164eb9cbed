"""The FMU of winches alone, against their equations solved by scipy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from conftest import ROOT
from fmpy.validation import validate_fmu
from fmu.cases import ELASTIC, write
from fmu.driver import Driver
from scipy.integrate import solve_ivp

from cdpr.cables.tables import home_lengths
from cdpr.fmu.export import Actuator
from cdpr.fmu.read.archive import open_archive
from cdpr.fmu.read.mapping import map_signals
from cdpr.scenario import load_scenario

STEP, STEPS = 1e-3, 400
# N, with steps of 1 ms at 100 rad/s and more; half of it is scipy's. Without damping of the order of 1e-6.
TENSION = 1e-4
RADIUS, INERTIA, VISCOUS, COULOMB, COULOMB_SPEED, STIFFNESS, DAMPING = 0.05, 0.002, 0.01, 0.1, 0.1, 1e5, 100.0


@pytest.fixture(scope="module")
def robot():
    return load_scenario(ROOT / "scenarios" / "caroca.yaml", overrides=ELASTIC).robot


def given(t):
    """Commands, lengths and rates (8,) at time t; the lengths go up and down."""
    phase = np.arange(8.0)
    length = 4.0 + 0.01 * np.sin(5.0 * t + phase)
    return 300.0 + 200.0 * np.sin(7.0 * t + phase), length, 0.05 * np.cos(5.0 * t + phase)


def tension_of(length, rate, unstretched, speed):
    pull = STIFFNESS * (length - unstretched) / unstretched + DAMPING * (rate + RADIUS * speed)
    return np.where(length > unstretched, np.maximum(pull, 0.0), 0.0)


def expected():
    """Tensions (K, 8) at the end of each step, with what was given at its beginning."""
    command, length, rate = given(0.0)
    y = np.concatenate([length / (1.0 + command / STIFFNESS), -rate / RADIUS])
    rows = []
    for k in range(STEPS):
        command, length, rate = given(k * STEP)

        def slope(t, y, command=command, length=length, rate=rate):
            unstretched, speed = y[:8], y[8:]
            tension = tension_of(length, rate, unstretched, speed)
            friction = VISCOUS * speed + COULOMB * np.tanh(speed / COULOMB_SPEED)
            return np.concatenate([-RADIUS * speed, (RADIUS * (command - tension) - friction) / INERTIA])

        y = solve_ivp(slope, (0.0, STEP), y, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
        rows.append(tension_of(length, rate, y[:8], y[8:]))
    return np.array(rows)


@pytest.mark.slow
def test_it_follows_its_equations_and_alike_in_both_versions(robot, tmp_path):
    found = []
    for fmi in (2, 3):
        path = write(Actuator(robot, STEP / 10), fmi, tmp_path)
        assert validate_fmu(str(path)) == []
        rows = []
        with Driver(path) as driver:
            for k in range(STEPS):
                for name, values in zip(("command", "cable_length", "cable_rate"), given(k * STEP), strict=True):
                    driver.set(name, values)
                if k == 0:  # it begins as commanded
                    assert np.allclose(driver.get("cable_tension"), given(0.0)[0], rtol=1e-9)
                driver.step(k * STEP, STEP)
                rows.append(driver.get("cable_tension"))
        found.append(np.array(rows))
    assert (found[0] == found[1]).all()
    assert np.ptp(found[1]) > 100.0
    assert np.abs(found[1] - expected()).max() < TENSION


@pytest.mark.parametrize("fmi", [2, 3])
def test_tensions_follow_the_lengths_at_once(fmi, robot, tmp_path):
    """Properties that a host relies on when it couples the FMU with a platform, as described in it."""
    path = write(Actuator(robot, STEP), fmi, tmp_path)
    with Driver(path) as driver:
        _, length, rate = given(0.0)
        for name, values in zip(("command", "cable_length", "cable_rate"), given(0.0), strict=True):
            driver.set(name, values)
        driver.step(0.0, STEP)
        driver.set("cable_length", length + 0.001)
        driver.set("cable_rate", rate + 0.1)
        unstretched, speed = driver.get("unstretched_length"), driver.get("drum_speed")
        assert np.allclose(driver.get("cable_tension"), tension_of(length + 0.001, rate + 0.1, unstretched, speed))
        driver.set("cable_length", unstretched - 0.001)
        assert (driver.get("cable_tension") == 0.0).all()


@pytest.mark.parametrize("moved", [0.0, 0.5])  # m, of the anchors
def test_gears_drums_that_grow_and_tackles(moved, robot, tmp_path):
    """The equations of `cdpr.cables.transmission` by scipy; their numbers are parameters, those not used are none."""
    growth, lines, reeving, efficiency = 2e-4, 2.0, 2.0, 0.7
    own = {"drum_growth": growth, "lines": lines, "reeving": reeving, "efficiency": efficiency}
    cables = tuple(replace(cable, winch=replace(cable.winch, own=own)) for cable in robot.cables)
    geared = replace(robot, cables=cables)
    names = [{each.name for each in Actuator(one, STEP).variables()} for one in (robot, geared)]
    assert names[1] - names[0] == {f"winch.{key}" for key in (*own, "home_length")}
    home, (command, length, rate) = home_lengths(robot) + moved, given(0.0)

    def per_turn(unwound):
        return np.sqrt(RADIUS**2 + growth * lines * reeving * (home - unwound)) / reeving

    def pull(y):
        tension = STIFFNESS * (length - y[:8]) / y[:8] + DAMPING * (rate + per_turn(y[:8]) * y[8:])
        return np.where(length > y[:8], np.maximum(tension, 0.0), 0.0)

    def slope(_, y):
        radius, speed = per_turn(y[:8]), y[8:]
        friction = VISCOUS * speed + COULOMB * np.tanh(speed / COULOMB_SPEED)
        lost = (1.0 - efficiency) * np.tanh(speed / COULOMB_SPEED)
        load = (1.0 + efficiency + lost) / (1.0 + efficiency - lost)
        return np.concatenate([-radius * speed, (radius * (command - pull(y) * load) - friction) / INERTIA])

    y = length / (1.0 + command / STIFFNESS)
    y = np.concatenate([y, -rate / per_turn(y)])
    changes = {"winch.home_length": home} if moved else {}
    with Driver(write(Actuator(geared, STEP / 50), 3, tmp_path), changes) as driver:
        for name, values in zip(("command", "cable_length", "cable_rate"), given(0.0), strict=True):
            driver.set(name, values)
        for k in range(10):
            driver.step(k * STEP, STEP)
        y = solve_ivp(slope, (0.0, 10 * STEP), y, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
        assert np.abs(driver.get("cable_tension") - pull(y)).max() < TENSION
        np.testing.assert_allclose(driver.get("drum_speed"), y[8:], atol=1e-6)


def test_its_signals_map_by_themselves(robot, tmp_path):
    mapping = map_signals(open_archive(write(Actuator(robot, STEP), 3, tmp_path)).description, robot, role="winch")
    assert list(mapping.inputs.ports) == ["command", "cable_length", "cable_rate"]
    assert "cable_tension" in mapping.outputs.ports


def test_saved_states_continue_to_the_bit(robot, tmp_path):
    with Driver(write(Actuator(robot, STEP), 3, tmp_path)) as driver:
        driver.set("command", given(0.0)[0])
        driver.step(0.0, STEP)
        saved = driver.save()
        ends = []
        for _ in range(2):
            driver.restore(saved)
            driver.set("cable_rate", given(0.0)[2])
            for k in range(1, 20):
                driver.step(k * STEP, STEP)
            ends.append(np.concatenate([driver.get("cable_tension"), driver.get("drum_speed")]))
        driver.free(saved)
    assert (ends[0] == ends[1]).all()
