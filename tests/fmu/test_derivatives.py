"""Derivatives and dependencies of exported FMUs against finite differences."""

from __future__ import annotations

import ctypes

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmu.cases import FMI, load, plant_of, scenario, write
from fmu.driver import STATE, Driver
from spread import spread

from cdpr.mechanics.kinematics import wrench_matrix

PLAIN = ["caroca", "cogiro", "planar", "point_mass", "carriage", "spherical", "pulleys"]
# Central differences with steps of 1e-6 of a number's size: their round-off, as a share of the largest derivative.
DIFFERENCES = 2e-7
STEP = 1e-6


@pytest.fixture
def moved(tmp_path):
    """Return an FMU in Initialization Mode, somewhere off its home and turning, as far as its guide lets it."""
    opened = []

    def make(case, fmi):
        loaded = scenario(case)
        driver = Driver(write(plant_of(loaded), fmi, tmp_path))
        opened.append(driver)
        driver.fmu.reset()
        if fmi == 2:
            driver.fmu.setupExperiment(startTime=0.0)
        driver.fmu.enterInitializationMode()
        rng, free = np.random.default_rng(5), np.isin(["x", "y", "z", "rx", "ry", "rz"], loaded.robot.dof)
        turn = 0.1 * free[3:] * rng.uniform(0.5, 1.0, 3)
        driver.set("initial_quaternion", [1.0, *turn] / np.sqrt(1.0 + turn @ turn))
        driver.set("initial_velocity", free[:3] * rng.uniform(-0.5, 0.5, 3))
        driver.set("initial_angular_velocity", free[3:] * rng.uniform(-0.5, 0.5, 3))
        command, push = load(plant_of(loaded), 0.1)
        driver.set("cable_tension", np.abs(command))
        driver.set("external_force", push[:3])
        driver.set("external_moment", push[3:])
        return driver, loaded.robot

    yield make
    for driver in opened:
        driver.__exit__(None, None, None)


def derivative(driver, unknown, known, seed):
    unknowns, knowns = driver.references[unknown], driver.references[known]
    if driver.fmi == 2:
        return np.array(driver.fmu.getDirectionalDerivative(unknowns, knowns, list(seed)))
    found = (ctypes.c_double * driver.sizes[unknown])()  # FMPy's own function knows no arrays
    driver.fmu.fmi3GetDirectionalDerivative(
        driver.fmu.component,
        (ctypes.c_uint * len(unknowns))(*unknowns),
        len(unknowns),
        (ctypes.c_uint * len(knowns))(*knowns),
        len(knowns),
        (ctypes.c_double * len(seed))(*seed),
        len(seed),
        found,
        len(found),
    )
    return np.array(found)


OUTPUTS = (*STATE, "acceleration", "angular_acceleration", "cable_length", "cable_rate")
KNOWN = (
    "mass",
    "center_of_mass",
    "inertia",
    "gravity",
    "frame_anchors",
    "platform_anchors",
    "initial_position",
    "initial_quaternion",
    "initial_velocity",
    "initial_angular_velocity",
    "cable_tension",
    "external_force",
    "external_moment",
)


def seeds(name, driver, robot, rng):
    """A direction in which the parameter may go at all: inertias are symmetric, guides hold what they hold."""
    seed = rng.normal(size=driver.sizes[name])
    free = np.isin(["x", "y", "z", "rx", "ry", "rz"], robot.dof)
    if name == "inertia":
        seed = np.ravel(seed.reshape(3, 3) + seed.reshape(3, 3).T)
    elif name == "initial_velocity":
        seed *= free[:3]
    elif name == "initial_angular_velocity":
        seed *= free[3:]
    elif name == "initial_quaternion":
        seed[1:] *= free[3:]
    return seed


@spread("case, fmi", PLAIN, [2, 3])
def test_derivatives_are_those_of_finite_differences(case, fmi, moved):
    driver, robot = moved(case, fmi)
    rng = np.random.default_rng(6)
    scales = dict.fromkeys(OUTPUTS, 0.0)
    for known in KNOWN:
        at, seed = driver.get(known), seeds(known, driver, robot, rng)
        step = STEP * max(1.0, float(np.abs(at).max()))
        ends = []
        for side in (1.0, -1.0):
            driver.set(known, at + side * step * seed)
            ends.append({name: driver.get(name) for name in OUTPUTS})
        driver.set(known, at)
        for name in OUTPUTS:
            exact, size = derivative(driver, name, known, seed), np.abs(ends[0][name]).max()
            rough = (ends[0][name] - ends[1][name]) / (2.0 * step)
            scales[name] += np.abs(exact).max()
            assert np.allclose(
                exact, rough, rtol=0.0, atol=DIFFERENCES * (np.abs(exact).max() + size / step * 1e-7 + 1)
            )
    assert min(scales.values()) > 0.0 or robot.n < 6  # nothing is compared with nothing


@FMI
def test_loads_in_held_directions_have_no_effect(fmi, moved):
    driver, robot = moved("planar", fmi)
    assert robot.dof == ("x", "z", "ry")
    for name in OUTPUTS:
        assert not derivative(driver, name, "initial_velocity", [0.0, 1.0, 0.0]).any()
        assert not derivative(driver, name, "initial_angular_velocity", [1.0, 0.0, 1.0]).any()
        assert not derivative(driver, name, "initial_quaternion", [0.0, 1.0, 0.0, 1.0]).any()


@FMI
def test_a_quaternion_that_is_a_little_too_long_turns_by_as_much_less(fmi, moved):
    """It is made one of unit length, as its derivative is."""
    driver, _ = moved("caroca", fmi)
    length, seed, q = 1.0008, [0.1, -0.2, 0.3, 0.4], driver.get("initial_quaternion")
    unit = {name: derivative(driver, name, "initial_quaternion", seed) for name in OUTPUTS}
    driver.set("initial_quaternion", length * q)
    for name in OUTPUTS:
        found = derivative(driver, name, "initial_quaternion", seed)
        assert np.allclose(length * found, unit[name], rtol=1e-9, atol=1e-9)
    assert max(np.abs(value).max() for value in unit.values()) > 0.1


@FMI
def test_between_steps_accelerations_follow_tensions_by_the_wrench_matrix(fmi, tmp_path):
    loaded = scenario("caroca")
    plant = plant_of(loaded)
    with Driver(write(plant, fmi, tmp_path)) as driver:
        driver.set("cable_tension", load(plant, 0.0)[0])
        driver.step(0.0, 0.05)
        state, robot = driver.state(), loaded.robot
        W = wrench_matrix(robot, state)
        M = np.diag([robot.platform.mass] * 3)
        for i in range(robot.m):
            seed = np.eye(robot.m)[i]
            found = derivative(driver, "acceleration", "cable_tension", seed)
            assert np.allclose(M @ found, W[:3, i], rtol=1e-12, atol=1e-12)
            assert not derivative(driver, "position", "cable_tension", seed).any()
        with pytest.raises(FMICallException):  # a parameter is no longer known
            derivative(driver, "acceleration", "mass", [1.0])
        with pytest.raises(FMICallException):
            derivative(driver, "mass", "cable_tension", np.ones(8))
        if fmi == 3:
            with pytest.raises(FMICallException):
                derivative(driver, "acceleration", "cable_tension", np.ones(7))
    with Driver(write(plant_of(scenario("cogiro_elastic")), fmi, tmp_path)) as driver:
        about = fmpy.read_model_description(str(driver.folder))
        assert not about.coSimulation.providesDirectionalDerivative
        with pytest.raises(FMICallException):
            derivative(driver, "acceleration", "command", np.ones(8))


def described(about):
    """Names that each output of a model description depends on at the start; None for all."""
    return {
        unknown.variable.name: None if unknown.dependencies is None else {v.name for v in unknown.dependencies}
        for unknown in about.initialUnknowns
    }


@spread("case", PLAIN)
def test_dependencies_at_the_start_leave_nothing_out(case, moved):
    driver, robot = moved(case, 3)
    known = described(fmpy.read_model_description(str(driver.folder)))
    rng = np.random.default_rng(7)
    for name in KNOWN:
        seed = seeds(name, driver, robot, rng)
        for unknown in OUTPUTS:
            found = np.abs(derivative(driver, unknown, name, seed)).max()
            assert name in known[unknown] or found < 1e-12
    assert known["cable_length"] == {"initial_position", "initial_quaternion", "frame_anchors", "platform_anchors"}


@FMI
def test_scalars_and_arrays_depend_alike(fmi, tmp_path):
    """FMI 2 counts variables from 1, FMI 3 refers to values."""
    about = fmpy.read_model_description(str(write(plant_of(scenario("caroca")), fmi, tmp_path)))
    names = {key.split("[")[0]: {n.split("[")[0] for n in value} for key, value in described(about).items()}
    assert names["position"] == {"initial_position"}
    assert names["velocity"] == {"initial_velocity"}
    assert "cable_tension" in names["acceleration"]
    for unknown in about.outputs:
        at_once = {v.name.split("[")[0] for v in unknown.dependencies}
        expected = (
            {"cable_tension", "external_force", "external_moment"} if "acceleration" in unknown.variable.name else set()
        )
        assert at_once == expected
