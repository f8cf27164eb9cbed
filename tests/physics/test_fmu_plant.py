"""Exported FMUs against the backend `reference`, and FMI 2 against FMI 3."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from fmu.cases import CASES, FMI, load, plant_of, scenario, write
from fmu.driver import Driver, FMICallException

from cdpr.mechanics.kinematics import wrench_matrix
from cdpr.native.rotations import multiply, rotation_vector
from cdpr_backends.reference_schemes import make

# m, rad and their rates, over one second without control: what the rounding of other operations grows to. Most cases
# agree to the bit.
OPEN_LOOP = 1e-12
CLOSED_LOOP = 1e-9  # over four seconds
# Of tensions, N per N: a stiff cable makes a force of 1e5 N/m from the rounding of its length.
TENSION = 1e-9


def open_loop(driver, plant, steps, *, substeps=1, start=0):
    """States and tensions (K, 13 + m)."""
    name, h = "command" if plant.winches else "cable_tension", plant.physics_step
    rows = []
    for k in range(start, start + steps, substeps):
        command, wrench = load(plant, k * h)
        driver.set(name, command)
        driver.set("external_force", wrench[:3])
        driver.set("external_moment", wrench[3:])
        driver.step(k * h, substeps * h)
        rows.append(np.concatenate([driver.state(), driver.get("cable_tension")]))
    return np.array(rows)


def reference(plant, steps):
    """The same of the backend."""
    backend = make(plant.robot, plant.gravity, plant.physics_step, None)
    backend.reset(plant.state)
    rows = np.empty((steps, 13 + plant.robot.m))
    for k in range(steps):
        backend.command[:], backend.external[:] = load(plant, k * plant.physics_step)
        backend.step(1)
        rows[k, :13] = backend.state
        backend.read_tension(rows[k, 13:])
    return rows


# Common parts of other combinations: guides, exits and spans that are here in other combinations.
REPEATS = {
    "cogiro",
    "cogiro_elastic",
    "cogiro_tabulated",
    "cogiro_viscoelastic",
    "pulleys_elastic",
    "pulleys_mixed",
    "planar_elastic",
    "planar_mixed",
    "spherical_rigid",
}


@pytest.mark.parametrize("case", [pytest.param(x, marks=pytest.mark.slow if x in REPEATS else ()) for x in CASES])
@pytest.mark.usual("caroca", "mixed")
def test_it_moves_as_reference_does_and_alike_in_both_versions(case, tmp_path):
    plant = plant_of(scenario(case))
    expected = reference(plant, 500)
    assert np.abs(expected[-1, :7] - plant.state[:7]).max() > 0.1
    if plant.winches and plant.robot.unilateral:
        assert (expected[:, 13:] == 0.0).any()  # slack cables took part
    found = []
    for fmi in (2, 3):
        with Driver(write(plant, fmi, tmp_path)) as driver:
            found.append(open_loop(driver, plant, 500))
    assert (found[0] == found[1]).all()
    assert np.abs(found[1] - expected)[:, :13].max() < OPEN_LOOP
    assert np.abs(found[1] - expected)[:, 13:].max() < TENSION * expected.max()


def test_long_steps_are_those_of_reference_too(tmp_path, offset_robot):
    """The error of the scheme would show another body frame; 20 ms make it 1e-5."""
    plant = dataclasses.replace(plant_of(scenario("caroca"), 0.02), robot=offset_robot)
    expected = reference(plant, 50)
    with Driver(write(plant, 3, tmp_path)) as driver:
        found = open_loop(driver, plant, 50)
    assert np.abs(found - expected).max() < OPEN_LOOP


@pytest.mark.slow
def test_closed_loop_stays_with_reference(tmp_path):
    """A proportional-derivative loop about a moving target, each with the feedback of its own state."""
    loaded = scenario("cogiro")
    plant, h, steps = plant_of(loaded), 1e-3, 4000
    backend = make(plant.robot, plant.gravity, h, None)
    backend.reset(plant.state)
    gains = np.repeat([100.0, 20.0], 6)

    def command(state, k):
        desired = np.zeros(19)
        desired[:7] = plant.state[:7]
        desired[0] += 0.5 * np.sin(k * h)
        turn = rotation_vector(multiply(desired[3:7], state[3:7] * [1.0, -1.0, -1.0, -1.0]))
        error = np.concatenate([desired[:3] - state[:3], turn])
        wrench = 90.0 * (gains[:6] * error + gains[6:] * (desired[7:13] - state[7:]))
        wrench[:3] -= 90.0 * plant.gravity
        return 300.0 + np.linalg.pinv(wrench_matrix(plant.robot, state)) @ wrench

    worst = moved = 0.0
    with Driver(write(plant, 3, tmp_path)) as driver:
        state = driver.state()
        for k in range(steps):
            backend.command[:] = command(backend.state, k)
            backend.step(1)
            driver.set("cable_tension", command(state, k))
            driver.step(k * h, h)
            state = driver.state()
            worst = max(worst, np.abs(state - backend.state).max())
            moved = max(moved, np.abs(state[:3] - plant.state[:3]).max())
    assert moved > 0.3
    assert worst < CLOSED_LOOP


@FMI
def test_a_long_step_is_made_of_physics_steps(fmi, tmp_path):
    plant = plant_of(scenario("caroca"))
    path = write(plant, fmi, tmp_path)
    with Driver(path) as one, Driver(path) as many:
        one.set("cable_tension", load(plant, 0.0)[0])
        many.set("cable_tension", load(plant, 0.0)[0])
        one.step(0.0, 0.005)
        for k in range(5):
            many.step(k * 0.001, 0.001)
        assert (one.state() == many.state()).all()
        one.step(0.005, 0.0015)  # two steps of 0.75 ms
        many.step(0.005, 0.00075)
        many.step(0.00575, 0.00075)
        assert (one.state() == many.state()).all()
        one.step(0.0065, 0.00205)  # a little more than two steps are three, and not two that leave some out
        for k in range(3):
            many.step(0.0065 + k * 0.00205 / 3, 0.00205 / 3)
        assert np.allclose(one.state(), many.state(), rtol=0.0, atol=1e-14)


def other_plant(plant):
    """Another mass, inertia, centre of mass, gravity, step, anchor and start."""
    robot = plant.robot
    platform = dataclasses.replace(
        robot.platform,
        mass=120.0,
        inertia=robot.platform.inertia + 0.5 * (np.ones((3, 3)) - np.eye(3)),
        center_of_mass=np.array([0.02, -0.01, 0.1]),
    )
    cables = list(robot.cables)
    cables[0] = dataclasses.replace(cables[0], frame=cables[0].frame + 0.1, platform=cables[0].platform - 0.05)
    state = np.array([0.1, 0.2, 1.3, 0.8, 0.0, 0.6, 0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
    robot = dataclasses.replace(robot, platform=platform, cables=tuple(cables))
    return dataclasses.replace(plant, robot=robot, gravity=np.array([0.0, 1.0, -3.7]), physics_step=0.002, state=state)


@pytest.mark.slow
@FMI
@pytest.mark.parametrize("case", ["caroca", "cogiro_elastic"])
@pytest.mark.usual("caroca-3", "cogiro_elastic-2")
def test_parameters_take_effect(case, fmi, tmp_path):
    """Set from outside, they make the FMU of another robot, before and during initialization."""
    plant = plant_of(scenario(case))
    other = other_plant(plant)
    if plant.winches:
        winch = dataclasses.replace(other.robot.cables[1].winch, drum_radius=0.04, inertia=0.003, coulomb_speed=0.2)
        cable = dataclasses.replace(other.robot.cables[1], winch=winch, axial_stiffness=2e5, damping=50.0)
        cables = (other.robot.cables[0], cable, *other.robot.cables[2:])
        other = dataclasses.replace(other, robot=dataclasses.replace(other.robot, cables=cables))
    path = write(plant, fmi, tmp_path)
    values = {each.name: each.values for each in other.variables() if each.causality == "parameter"}
    with Driver(write(other, fmi, tmp_path / "..")) as driver:
        expected = open_loop(driver, other, 200)
    for early, late in ((values, {}), ({}, values)):
        with Driver(path, early, late) as driver:
            assert np.allclose(driver.at_start, other.state, rtol=0, atol=1e-15)
            assert (open_loop(driver, other, 200) == expected).all()
            with pytest.raises(FMICallException):  # too late, unlike what is tunable
                driver.set("initial_position", np.zeros(3))


@pytest.mark.slow
@FMI
@pytest.mark.parametrize(
    ("case", "name", "value", "said"),
    [
        ("caroca", "mass", 0.0, "mass must be greater than 0"),
        ("caroca", "mass", np.nan, "not finite"),
        ("caroca", "gravity", [0, np.inf, 0], "not finite"),
        ("caroca", "physics_step", 0.0, "physics_step must be"),
        ("caroca", "inertia", np.diag([1.0, 1.0, 0.0]), "positive definite"),
        ("caroca", "inertia", [[1, 2, 0], [2, 1, 0], [0, 0, 1]], "positive definite"),
        ("caroca", "inertia", [[1, 0.1, 0], [0, 1, 0], [0, 0, 1]], "symmetric"),
        ("caroca", "initial_quaternion", [0, 0, 0, 0], "length 1"),
        ("planar", "initial_quaternion", [0.8, 0.6, 0, 0], "held"),
        ("planar", "initial_velocity", [0, 1, 0], "held"),
        ("spherical", "initial_velocity", [0, 0, 1], "held"),
        ("cogiro_elastic", "cable.axial_stiffness", [0.0] * 8, "axial_stiffness must be"),
        ("cogiro_rigid", "winch.inertia", [-1.0] * 8, "winch.inertia must be"),
    ],
)
@pytest.mark.usual("*-3", "caroca-mass-*-2")
def test_unsound_parameters_are_refused(case, name, value, said, fmi, tmp_path, capfd):
    path = write(plant_of(scenario(case)), fmi, tmp_path)
    with pytest.raises(FMICallException), Driver(path, {name: value}):
        pass
    assert said in capfd.readouterr().out


@FMI
@pytest.mark.parametrize("case", ["caroca", "cogiro_elastic", "planar"])
@pytest.mark.usual("caroca-3", "cogiro_elastic-2")
def test_saved_states_continue_to_the_bit(case, fmi, tmp_path):
    """In the same instance, as bytes, and in another instance."""
    plant = plant_of(scenario(case))
    path = write(plant, fmi, tmp_path)
    with Driver(path) as driver, Driver(path) as other:
        open_loop(driver, plant, 50)
        saved = driver.save()
        content = driver.serialise(saved)
        expected = open_loop(driver, plant, 100, start=50)
        driver.restore(saved)
        driver.free(saved)
        assert (open_loop(driver, plant, 100, start=50) == expected).all()
        again = other.deserialise(content)
        other.restore(again)
        other.free(again)
        assert (open_loop(other, plant, 100, start=50) == expected).all()


def test_a_state_of_another_robot_is_refused(tmp_path, capfd):
    plant = plant_of(scenario("caroca"))
    heavier = dataclasses.replace(plant, robot=other_plant(plant).robot)
    with Driver(write(plant, 3, tmp_path)) as driver, Driver(write(heavier, 3, tmp_path / "..")) as other:
        saved = driver.save()
        with pytest.raises(FMICallException):
            other.deserialise(driver.serialise(saved))
        driver.free(saved)
    assert "not a snapshot of this FMU" in capfd.readouterr().out


@FMI
def test_silent_mistakes_are_errors(fmi, tmp_path, capfd):
    plant = plant_of(scenario("caroca"))
    with Driver(write(plant, fmi, tmp_path)) as driver:
        driver.step(0.0, 0.001)
        for time, duration, said in [(0.005, 0.001, "is at 0.001 s"), (0.001, 0.0, "greater than 0")]:
            with pytest.raises(FMICallException):
                driver.step(time, duration)
            assert said in capfd.readouterr().out
        driver.set("cable_tension", np.full(8, np.nan))
        with pytest.raises(FMICallException):
            driver.step(0.001, 0.001)
        assert "not finite" in capfd.readouterr().out
        with pytest.raises(FMICallException):
            driver.set("position", np.zeros(3))


@FMI
def test_reset_restores_the_exported_state(fmi, tmp_path):
    plant = plant_of(scenario("caroca"))
    with Driver(write(plant, fmi, tmp_path), {"mass": 10.0}) as driver:
        first = open_loop(driver, plant, 20)
        driver.fmu.terminate()
        driver.fmu.reset()
        driver.initialise({}, {})
        assert driver.get("mass") == plant.robot.platform.mass
        assert not np.array_equal(open_loop(driver, plant, 20), first)
