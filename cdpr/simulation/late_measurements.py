"""Periods and delays of measurements in the linearisation of a loop.

The linearised loop has exact sensors, and its state x changes to A x. An error e of the seen state at a sample, in the
coordinates of the platform, adds F e to the next state. Hence A = A0 + F G C, with the matrix C that selects these
coordinates and the gains G of the sensors. With measurements that are d control steps late and N apart,

    x[k + 1] = A0 x[k] + F G C x[k - l(k)],  l(k) = d + (k - d) mod N,

which is periodic (Francis and Georgiou, 1988, IEEE Trans. Automatic Control 33(9)): the matrix of a whole period has
the states x[k], C x[k - 1], C x[k - 2], ...
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

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
MOST_WAITING = 600  # states of measurements that are on their way
LONGEST = 100  # control steps in the common period of pose and twist


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
        span, kept = math.lcm(*self.every), len(self.gain)
        lags = max(d + n - 1 for d, n in zip(self.delay, self.every, strict=True))
        sides = loop.A + loop.corners, loop.A - loop.corners
        (up, B), (down, _) = (self._whole(loop, A, F, span, lags) for A in sides)
        names = (*loop.names, *["controller"] * (kept * lags))
        scale, rest = (np.concatenate([each, np.tile(each[:kept], lags)]) for each in (loop.scale, loop.rest))
        period = span * loop.period
        A, corners = 0.5 * (up + down), 0.5 * (up - down)
        return replace(loop, A=A, corners=corners, B=B, names=names, scale=scale, rest=rest, period=period)

    def _whole(self, loop: Linearised, A: Array, F: Array, span: int, lags: int) -> tuple[Array, Array]:
        """Return the derivatives of the state after a common period by the state and by the desired pose."""
        k, kept, n = len(A), len(self.gain), len(self.rows)
        pose, size = slice(0, n), k + kept * lags
        by_seen = F * self.gain
        own = A.copy()
        own[:, :kept] -= by_seen
        whole, response = np.eye(size), np.zeros((size, loop.B.shape[1]))
        for phase in range(span):
            step = np.zeros((size, size))
            step[:k, :k] = own
            for i, part in enumerate((pose, slice(n, kept))):
                lag = self.delay[i] + (phase - self.delay[i]) % self.every[i]
                first = 0 if lag == 0 else k + kept * (lag - 1)
                step[:k, first + part.start : first + part.stop] += by_seen[:, part]
            for lag in range(lags):
                first = 0 if lag == 0 else k + kept * (lag - 1)
                step[k + kept * lag : k + kept * (lag + 1), first : first + kept] = np.eye(kept)
            whole, response = step @ whole, step @ response
            response[:k] += loop.B
        return whole, response


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
    lags = max(d + n - 1 for d, n in zip(delay, every, strict=True))
    if 2 * robot.n * lags > MOST_WAITING or math.lcm(*every) > LONGEST:
        raise NotLinearisedError(
            f"up to {lags} control steps lie between a measurement and its use, and the measurements of pose and twist "
            f"repeat after {math.lcm(*every)}: expected at most {MOST_WAITING // (2 * robot.n)} and {LONGEST}"
        )
    gain = np.array([[row[0] for row in sensor.errors(robot.m)] for sensor in found])
    about = gain[:, list(robot.rows)].ravel(), tuple(robot.rows), step
    return LateMeasurements((delay[0], delay[1]), (every[0], every[1]), *about)


def ignored_errors(scenario: Scenario) -> tuple[str, ...]:
    """Return a note on the errors of sensors that a linearised loop does not contain; () if there are none."""
    names = [sensor.title for sensor in seen_sensors(scenario).values() if _random(sensor, scenario.robot.m)]
    what = "noise, drift, jitter and losses of the measurements are ignored"
    return (f"{what}: {', '.join(names)}",) if names else ()


def _random(sensor: Sensor, cables: int) -> bool:
    _, _, noise, drift, _ = zip(*sensor.errors(cables), strict=True)
    return bool(sensor.jitter or sensor.dropout or any(noise) or any(drift))
