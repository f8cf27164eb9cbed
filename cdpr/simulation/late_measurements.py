"""Periods and delays of measurements in the linearisation of a loop.

The linearised loop has exact sensors, and its state x changes to A x. An error e of the seen state at a sample, in the
coordinates of the platform, adds F e to the next state. Hence A = A0 + F G C, with the matrix C that selects these
coordinates and the gains G of the sensors. With measurements that are d control steps late and N apart,

    x[k + 1] = A0 x[k] + F G C x[k - l(k)],  l(k) = d + (k - d) mod N,

which is periodic (Francis and Georgiou, 1988, IEEE Trans. Automatic Control 33(9)). The matrix of a whole period has
the state x[k] and those measurements C x[k - N], C x[k - 2 N], ... that are used later: d / N of them, rounded up.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cdpr.model.robot import Array
from cdpr.model.rotations import matrix
from cdpr.scenario import Scenario
from cdpr.sensing.sensor import Sensor
from cdpr.simulation.linear_map import Linearised
from cdpr.simulation.linearised_scenario import NotLinearisedError
from cdpr.simulation.sensors import Sensors, seen_sensors

if TYPE_CHECKING:
    from cdpr.simulation.loop import Loop

BIAS = 1  # place in a row of errors
MOST_WAITING = 240  # values of measurements that are used later; the poles of more take seconds
LONGEST = 100  # control steps in the common period of pose and twist; most modes end within longer ones


@dataclass(frozen=True, eq=False)
class LateMeasurements:
    """Periods and delays of the sensors of pose and twist.

    Attributes:
        delay, every: (2,) of pose and twist, control steps.
        gain: (2 n,), of the coordinates of the platform: n of the pose, and their rates.
        rows: indices of the n degrees of freedom in position and rotation, world axes.
        control_step: s.
    """

    delay: tuple[int, int]
    every: tuple[int, int]
    gain: Array
    rows: tuple[int, ...]
    control_step: float

    def after(self, loop: Loop, error: Array, period: Callable[[Array], Array], x: Array) -> Array:
        """Return the state after a `period` from x, with an error (2 n,) of the seen state during it."""
        (sensors,) = (part for part in loop.parts.more if isinstance(part, Sensors))
        pose, twist = np.zeros(6), np.zeros(6)
        pose[list(self.rows)], twist[list(self.rows)] = np.split(error, 2)
        pose[3:] = matrix(loop.state[3:7]).T @ pose[3:]  # errors of attitudes are about axes of the platform
        errors = sensors.errors_of("pose"), sensors.errors_of("twist")
        biases = [each[:, BIAS] for each in errors]
        before = [bias.copy() for bias in biases]
        for bias, own in zip(biases, (pose, twist), strict=True):
            bias += own
        try:
            return period(x)
        finally:
            for bias, old in zip(biases, before, strict=True):
                bias[:] = old

    def included(self, loop: Linearised, F: Array) -> Linearised:
        """Return a linearised loop with these periods and delays.

        Args:
            loop: loop with exact sensors.
            F: (k, 2 n), derivative of its next state by an error of the seen state.

        Raises:
            NotLinearisedError: if the controller has a period of its own.
        """
        if round(loop.period / self.control_step) != 1:
            raise NotLinearisedError(
                "the measurements are late, and the controller has a period of several control steps"
            )
        span, waiting = math.lcm(*self.every), self.waiting
        held = np.concatenate([np.tile(part, count) for part, count in zip(self._parts, waiting, strict=True)])
        sides = loop.A + loop.corners, loop.A - loop.corners
        (up, B), (down, _) = (self._whole(loop, A, F, span) for A in sides)
        names = (*loop.names, *["controller"] * len(held))
        scale, rest = (np.concatenate([each, each[held]]) for each in (loop.scale, loop.rest))
        period = span * loop.period
        A, corners = 0.5 * (up + down), 0.5 * (up - down)
        late = max(self.every) * self.control_step
        return replace(
            loop, A=A, corners=corners, B=B, names=names, scale=scale, rest=rest, period=period, seen_every=late
        )

    @property
    def waiting(self) -> tuple[int, int]:
        """Numbers of measurements of pose and twist before the start of a period that are used later."""
        first, second = (-(-d // n) for d, n in zip(self.delay, self.every, strict=True))
        return first, second

    @property
    def _parts(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        n = len(self.rows)
        return np.arange(n), np.arange(n, 2 * n)

    def _whole(self, loop: Linearised, A: Array, F: Array, span: int) -> tuple[Array, Array]:
        """Return the derivatives of the state after a common period by the state and by the desired pose."""
        k, parts, waiting = len(A), self._parts, self.waiting
        own, by_seen = A.copy(), F * self.gain
        own[:, : len(self.gain)] -= by_seen
        size = k + sum(len(part) * count for part, count in zip(parts, waiting, strict=True))
        unit = np.eye(size, size + loop.B.shape[1])  # columns: of the state, and of the desired pose
        now, first = unit[:k], k
        measured: tuple[dict[int, Array], ...] = {}, {}  # by the number of the sample
        for found, part, count, every in zip(measured, parts, waiting, self.every, strict=True):
            for j in range(1, count + 1):
                found[-every * j] = unit[first : first + len(part)]
                first += len(part)
        for sample in range(span):
            after = own @ now
            for found, part, delay, every in zip(measured, parts, self.delay, self.every, strict=True):
                if sample % every == 0:
                    found[sample] = now[part]
                after += by_seen[:, part] @ found[(sample - delay) // every * every]
            after[:, size:] += loop.B
            now = after
        rows = [now]
        for found, count, every in zip(measured, waiting, self.every, strict=True):
            rows += [found[span - every * j] for j in range(1, count + 1)]
        whole = np.vstack(rows)
        return whole[:, :size], whole[:, size:]


def late_measurements(scenario: Scenario) -> LateMeasurements | None:
    """Return the periods and delays of the sensors that the controller uses; None if they are neither late nor apart.

    Raises:
        NotLinearisedError: if too many measurements are on their way.
    """
    step, robot = scenario.simulation.control_step, scenario.robot
    found = list(seen_sensors(scenario).values())
    delay = [round(sensor.delay / step) for sensor in found]
    every = [max(1, round(sensor.period / step)) for sensor in found]
    if not any(delay) and all(each == 1 for each in every):
        return None
    gains = np.array([[row[0] for row in sensor.errors(robot.m)] for sensor in found])[:, list(robot.rows)].ravel()
    late = LateMeasurements((delay[0], delay[1]), (every[0], every[1]), gains, tuple(robot.rows), step)
    values, repeat = robot.n * sum(late.waiting), math.lcm(*every)
    if values > MOST_WAITING:
        raise NotLinearisedError(
            f"up to {max(late.waiting)} measurements of a sensor are on their way to the controller: expected at most "
            f"{MOST_WAITING // robot.n} of pose and twist together"
        )
    if repeat > LONGEST:
        raise NotLinearisedError(
            f"the measurements of pose and twist repeat after {repeat} control steps: expected at most {LONGEST}, such "
            "as with equal periods"
        )
    return late


def ignored_errors(scenario: Scenario) -> tuple[str, ...]:
    """Return a note on the errors of sensors that a linearised loop does not contain; () if there are none."""
    names = [sensor.title for sensor in seen_sensors(scenario).values() if _random(sensor, scenario.robot.m)]
    what = "noise, drift, jitter and losses of the measurements are ignored"
    return (f"{what}: {', '.join(names)}",) if names else ()


def _random(sensor: Sensor, cables: int) -> bool:
    _, _, noise, drift, _ = zip(*sensor.errors(cables), strict=True)
    return bool(sensor.jitter or sensor.dropout or any(noise) or any(drift))
