"""Checks of a backend with winches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cdpr.cables import ACTUATED, MODELS
from cdpr.cables.tables import line_table
from cdpr.mechanics.cable_geometry import cable_geometry
from cdpr.mechanics.energy import energy
from cdpr.model import Robot, Winch
from cdpr.plugins.backend import Operations
from cdpr.testing import samples
from cdpr.testing.backend_physics import NO_WRENCH, ONE_STEP, SHORT
from cdpr.testing.check import Check, expect, expect_close, needs
from cdpr.testing.samples import GRAVITY
from cdpr.testing.subjects import BackendSubject

WINCH = Winch(drum_radius=0.05, inertia=5e-3, viscous_friction=0.05)
STIFFNESS, DAMPING = 1e5, 100.0  # N, N s/m
CURVE = {"strain_1": 1e-3, "tension_1": 1e-3 * STIFFNESS}
CREEP = {"creep_coefficient_1": 0.2, "creep_time_1": 0.05, "hysteresis_stiffness": 2e4, "hysteresis_tension": 20.0}
STEP, STEPS = 2e-4, 500
HELD = 5e-3  # m, deviation of a servo under a changing load
BALANCED = 1e-2  # tolerance of the energy as a share of the work; a first-order engine has a thousandth
# Winches that take rates and lengths.
IDEAL, SERVO = (
    Winch(type="velocity"),
    replace(WINCH, type="position", own={"position_gain": 50.0, "velocity_gain": 10.0}),
)
PULL = 300.0  # N, at the start
APART = 1.0  # N, minimum difference between commands of some hundred newtons and tensions, by friction and inertia


def winched(model: str) -> Robot:
    """Return the free robot on winches."""
    robot = samples.free()
    cables = tuple(
        replace(c, winch=WINCH, axial_stiffness=STIFFNESS, damping=DAMPING, linear_density=0.0, own=CURVE | CREEP)
        for c in robot.cables
    )
    return replace(robot, cables=cables, cable_model=model)


def drives(winch: Winch) -> Robot:
    """Return the free robot on elastic cables with these winches."""
    robot = winched(ACTUATED)
    return replace(robot, cables=tuple(replace(cable, winch=winch) for cable in robot.cables))


def winches_pull_as_reported(subject: BackendSubject) -> None:
    """The tensions that the plant reports are the tensions that pull the platform.

    Friction and inertia of a winch change the tension of its cable. Therefore, the tension differs from the command.
    The plant must report the real tension, not the command. The acceleration of the platform and the work of the cables
    must correspond to this tension. Skipped if the backend supports no `cable_models` with winches.
    """
    models = subject.properties.get("cable_models", ())
    wound = [name for name, chain in MODELS.items() if not chain.immediate]
    needs(isinstance(models, list | tuple) and set(wound) & set(models), "it declares no winches")
    start = samples.state(np.random.default_rng(16), speed=0.2, tilt=0.2)
    tension = np.empty(8)
    for model in wound:
        if model not in models:
            continue
        robot = winched(model)
        backend = subject.make(start, robot, step=SHORT)
        backend.command[:] = 250.0
        backend.read_tension(tension)
        backend.step(1)
        wanted = samples.acceleration(samples.free(), start, GRAVITY, tension, NO_WRENCH)
        acceleration = (backend.state[7:] - start[7:]) / SHORT
        bound = 1e3 * ONE_STEP * max(1.0, float(np.abs(wanted).max()))  # tensions change during the step
        expect_close(acceleration, wanted, bound, f"acceleration under the reported tensions, {model} cables")
        subject.close(backend)
        backend = subject.make(start, robot, step=STEP)
        backend.command[:] = 250.0
        backend.step(STEPS)
        backend.read_tension(tension)
        expect(float(np.abs(tension - 250.0).max()) > APART, f"tensions of {model} cables are the commands")
        gained = sum(energy(robot.inertial, GRAVITY, backend.state)) - sum(energy(robot.inertial, GRAVITY, start))
        work = backend.cable_work()
        expect_close(gained / work, 1.0, BALANCED, f"share of the energy in the reported work, {model} cables")
        expect(bool((np.abs(tension) <= backend.highest + 1e-9).all()), "a tension exceeds `highest`")
        subject.close(backend)


def winches_wind_as_commanded(subject: BackendSubject) -> None:
    """Winches that take lengths or rates unwind as commanded.

    After `reset`, the plant does not know the unwound lengths yet, and reports NaN for them. The first command of each
    winch is its unwound length at the start. Later commands are lengths or rates, depending on the winch. An ideal
    drive must unwind exactly at the commanded rate, and a position servo must hold a constant commanded length. The
    tensions must follow from the stretch of the cables. Skipped if the backend does not declare `winch_commands` in its
    property `features`.
    """
    features = subject.properties.get("features", ())
    needs(isinstance(features, tuple | list) and "winch_commands" in features, "it does not declare winch_commands")
    start = samples.state(np.random.default_rng(17), speed=0.0, tilt=0.2)
    lengths = cable_geometry(line_table(samples.free()), start)[1] / (1.0 + PULL / STIFFNESS)
    rates = np.linspace(-0.2, 0.2, 8)
    for winch in (IDEAL, SERVO):
        robot = drives(winch)
        backend = subject.make(start, robot, step=STEP)
        unwound, rate, torque, tension = (np.full(8, -1.0) for _ in range(4))
        reading = backend.winch_readings(unwound, rate, torque)
        for run in ("first run", "run after a reset"):
            backend.reset(start)
            _perform(reading)
            expect(bool(np.isnan(unwound).all()), f"unwound lengths before the first command are {unwound}, {run}")
            backend.command[:] = lengths
            backend.read_tension(tension)
            _perform(reading)
            expect_close(unwound, lengths, 1e-12, f"unwound lengths at the start, m, {run}")
            expect_close(tension, np.full(8, PULL), 1e-6, f"tensions at the start, N, {run}")
            backend.command[:] = rates if winch is IDEAL else lengths
            backend.step(STEPS)
            backend.read_tension(tension)
            _perform(reading)
            wanted, tolerance = (lengths + STEPS * STEP * rates, 1e-10) if winch is IDEAL else (lengths, HELD)
            expect_close(unwound, wanted, tolerance, f"unwound lengths of {winch.type} winches, m, {run}")
            _, length, later = cable_geometry(line_table(robot), backend.state)
            pull = STIFFNESS * (length - unwound) / unwound + DAMPING * (later - rate)
            expect_close(tension, np.maximum(pull, 0.0), 1e-6, f"tensions of the stretched cables, N, {run}")
        subject.close(backend)


def _perform(operations: Operations) -> None:
    for do in operations:
        do()


CHECKS = [Check(winches_pull_as_reported), Check(winches_wind_as_commanded)]
