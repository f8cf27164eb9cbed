"""Estimators under test: a motion of a robot, the measurements of its sensors, and calls of the estimator."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.log.layout import Layout
from cdpr.mechanics import dynamics, kinematics
from cdpr.model import Robot, rotations
from cdpr.model.robot import Array, read_only
from cdpr.native.bind import bind
from cdpr.native.random_numbers import Stream
from cdpr.plugins import Estimator, EstimatorInputs, SensorModel
from cdpr.sensing import SENSORS, Sensor
from cdpr.sensing.measurement import kernel_arguments
from cdpr.sensing.sensor import Sources
from cdpr.testing import samples
from cdpr.testing.check import expect
from cdpr.testing.samples import GRAVITY
from cdpr.testing.sensors import SAMPLES
from cdpr.testing.subjects import Subject

STEP = 1e-3  # s
STEPS = 600
BREAKS, KNOWN = 200, 250  # control steps: the cable breaks, and the tension distribution detects it
DEFAULT_SENSORS = ("encoders",)
NOISE = 2e-4  # standard deviation of all measured values, in their units


@dataclass(frozen=True, eq=False)
class Motion:
    """Motion of a robot under the tensions of a controller, at control steps k.

    Attributes:
        states: (K, 13), states.
        commands: (K, m), N, tensions as sent at each control step, before the break.
        tensions: (K, m), N, true tensions.
    """

    states: Array
    commands: Array
    tensions: Array


@lru_cache
def motion(*, breaks: bool) -> Motion:
    """Return a motion of `samples.braced`; with a cable that breaks."""
    robot = samples.braced()
    state = np.concatenate([[0.0, 0.0, 2.0], [1.0, 0.0, 0.0, 0.0], np.zeros(6)])
    middle = 0.3 * (robot.tension_min + robot.tension_max)
    states, commands, tensions = np.empty((STEPS, 13)), np.empty((STEPS, robot.m)), np.empty((STEPS, robot.m))
    for k in range(STEPS):
        intact = np.ones(robot.m, bool)
        intact[0] = not (breaks and k >= KNOWN)
        command = _held(robot, state, k * STEP, middle, intact)
        true = command.copy()
        if breaks and k >= BREAKS:
            true[0] = 0.0
        states[k], commands[k], tensions[k] = state, command, true
        state = samples.travel(robot, state, GRAVITY, true, np.zeros(6), STEP, STEP)
    return Motion(states, commands, tensions)


def _held(robot: Robot, state: Array, time: float, middle: Array, intact: Array) -> Array:
    """Return the tensions that guide the platform along a circle."""
    angle, radius = 4.0 * time, 0.1
    wanted = np.array([radius * np.sin(angle), radius * (1.0 - np.cos(angle)), 2.0])
    rate = np.array([radius * 4.0 * np.cos(angle), radius * 4.0 * np.sin(angle), 0.0])
    inertial = dynamics.required_wrench(robot, state, GRAVITY)
    force = robot.platform.mass * (100.0 * (wanted - state[:3]) + 20.0 * (rate - state[7:10]))
    moment = -np.array([200.0, 300.0, 400.0]) * rotations.rotation_vector(state[3:7]) - 60.0 * state[10:]
    W = kinematics.wrench_matrix(robot, state)[:, intact]
    command = np.zeros(robot.m)
    command[intact] = middle[intact] + np.linalg.pinv(W) @ (
        inertial + np.concatenate([force, moment]) - W @ middle[intact]
    )
    return np.clip(command, 0.0, robot.tension_max)


class Measuring:
    """Sensors on a robot that follows a motion: recorded once, and given to an estimator step by step.

    Args:
        of: motion of `samples.braced`.
        sensors: the sensors.
        start: (13,), state from which the estimate begins; that of the motion by default.
        known_from: control step from which the tension distribution knows that the first cable is broken.

    Attributes:
        models: sensors, as the estimator gets them.
        inputs: other inputs of the estimator.
    """

    def __init__(
        self, of: Motion, sensors: Sequence[Sensor], *, start: Array | None = None, known_from: int = STEPS
    ) -> None:
        robot = samples.braced()
        self._of, self._known_from = of, known_from
        self._lowest, self._highest = robot.tension_min, robot.tension_max
        self._records = [_record(robot, of, sensor) for sensor in sensors]
        self._live = [(np.zeros(record.shape[1] - 2), np.zeros(1), np.zeros(1)) for record in self._records]
        self.models = [
            SensorModel(sensor, *map(read_only, live)) for sensor, live in zip(sensors, self._live, strict=True)
        ]
        m = robot.m
        self._time, self._command, self._limits = np.zeros(1), np.zeros(m), np.zeros((2, m))
        self._held = np.zeros(m, dtype=bool)
        command, held = read_only(self._command), read_only(self._held)
        begin = read_only(of.states[0] if start is None else start)
        known = command, ("tension",) * m, command, read_only(self._limits), held
        self.inputs = EstimatorInputs(read_only(self._time), begin, *known)
        self.take(0)

    def take(self, k: int) -> None:
        """Provide the measurements and the commands before control step k."""
        self._time[0] = k * STEP
        self._command[:] = self._of.commands[k - 1] if k else 0.0
        self._limits[:] = self._lowest, self._highest
        self._held[0] = k >= self._known_from
        self._limits[:, self._held] = 0.0
        for record, (measured, age, fresh) in zip(self._records, self._live, strict=True):
            measured[:], age[0], fresh[0] = record[k, :-2], record[k, -2], record[k, -1]


def _record(robot: Robot, of: Motion, sensor: Sensor) -> Array:
    """Return measured values, their age and whether they are new, at each control step (K, n + 2)."""
    layout = Layout(robot.m)
    row = np.zeros(layout.width)

    def view(first: str, last: str | None = None) -> Array:
        return row[layout.span(first, last or first)]

    state = view("position", "angular_velocity")
    sources = Sources(robot, state, GRAVITY, STEP, (), view, lambda _: False, lambda *_: ())
    truth = sensor.truth(sources)
    settings, memory = kernel_arguments(sensor, robot.m, STEP)
    measured, age, time = np.zeros(len(truth.values)), np.zeros(1), np.zeros(1)
    given = {"truth": truth.values, "stream": Stream(0, f"sensors.{sensor.title}").state, "time": time}
    measure = bind("measure", **given, measured=measured, age=age, **settings, **memory)
    found, before = np.empty((len(of.states), len(measured) + 2)), 0.0
    for k, now in enumerate(of.states):
        state[:] = now
        view("length")[:], view("rate")[:] = kinematics.lengths(robot, now), kinematics.rates(robot, now)
        view("tension")[:] = of.tensions[k - 1] if k else 0.0
        time[0] = k * STEP
        for operation in truth.write:
            operation(time[0])
        measure()
        found[k] = *measured, age[0], k == 0 or age[0] < before + 0.5 * STEP
        before = float(age[0])
    return found


class EstimatorSubject(Subject):
    """An estimator under test."""

    def sensors(self, **settings: Any) -> list[Sensor]:
        """Return the sensors that it declares, with these settings; `noise` is that of all quantities.

        Raises:
            CdprError: if it declares an unknown type.
        """
        noise = settings.pop("noise", 0.0)
        names = self.properties.get("sensors", DEFAULT_SENSORS)
        found = []
        for name in names:
            if name not in SENSORS:
                raise CdprError(f"it declares sensors of the unknown type {name!r}")
            sensor = SAMPLES.get(name, SENSORS[name])()
            kind = type(sensor)
            errors = {each.key: {"noise": noise} for each in sensor.quantities if each.key in kind.model_fields}
            found.append(kind(**{**sensor.to_dict(), **errors, **settings}))
        return found

    def make(self, measuring: Measuring) -> Estimator:
        """Create an estimator for these measurements, connected."""
        estimator: Estimator = self._create(samples.braced(), GRAVITY, STEP, tuple(measuring.models), self.options)
        self._open.append(estimator)
        estimator.connect(measuring.inputs)
        return estimator

    def run(self, measuring: Measuring, steps: int = STEPS) -> Array:
        """Return the estimates (steps, 13) of a new estimator."""
        return follow(self.make(measuring), measuring, range(steps))


def follow(estimator: Estimator, measuring: Measuring, steps: range, out: Array | None = None) -> Array:
    """Return the estimates (K, 13) at these control steps; `out` contains that before them."""
    out = np.full(13, np.nan) if out is None else out
    rows = np.empty((len(steps), 13))
    for row, k in zip(rows, steps, strict=True):
        measuring.take(k)
        estimator.estimate(k * STEP, out)
        expect(np.isfinite(out).all(), f"estimate {out.tolist()} at step {k}")
        row[:] = out
    return rows


def errors(estimates: Array, of: Motion) -> Array:
    """Return the errors (K, 4): position, m, attitude, rad, velocity, m/s, and angular velocity, rad/s."""
    found = np.empty((len(estimates), 4))
    for k, (estimate, state) in enumerate(zip(estimates, of.states, strict=False)):
        turn = rotations.multiply(rotations.conjugate(estimate[3:7]), state[3:7])
        parts = estimate[:3] - state[:3], rotations.rotation_vector(turn), *np.split(estimate[7:] - state[7:], 2)
        found[k] = [np.linalg.norm(part) for part in parts]
    return found
