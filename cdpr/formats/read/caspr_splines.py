"""Points of CASPR trajectories and interpolation between them.

Curves are sampled at the trajectory's time step. If the step does not divide the time between two points, CASPR arrives
up to one step early and waits; here the point is reached at the time in the file.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cdpr.formats.read.xml import Element
from cdpr.model.robot import Array
from cdpr.scenario.motions.table import MAX_ROWS

LINEAR = "linear_spline_trajectory"
CUBIC = "cubic_spline_trajectory"
AVERAGE = "cubic_spline_average_velocity_trajectory"
QUINTIC = "quintic_spline_trajectory"
PARABOLIC = "parabolic_blend_trajectory"

# Interpolation function: returns coordinates, rates and second derivatives, each (k, n). Its arguments are the values
# (3, n) at a point and the next, times (k,) after the first, the duration T in s, and the blend time in s.
Between = Callable[[Array, Array, Array, float, float], tuple[Array, Array, Array]]


@dataclass(frozen=True)
class Points:
    """Points of a trajectory.

    Attributes:
        kind: kind of interpolation.
        times: (k,), s, starting at 0.
        q: (k, n), coordinates.
        rates: (k, n), first derivatives; 0 if the kind has none.
        seconds: (k, n), second derivatives; 0 if the kind has none.
        blends: (k,), durations of the parabolas before each point, s.
    """

    kind: str
    times: Array
    q: Array
    rates: Array
    seconds: Array
    blends: Array

    def share(self, k: int, time: float) -> tuple[float, float]:
        """Return the fraction of the way from point k to the next at a time, and its rate, 1/s, from rest to rest."""
        T, still = float(self.times[k + 1] - self.times[k]), np.zeros((3, 1))
        there = np.array([[1.0], [0.0], [0.0]])
        at, rate, _ = BETWEEN[self.kind](still, there, np.array([time - self.times[k]]), T, float(self.blends[k + 1]))
        return float(at[0, 0]), float(rate[0, 0])

    def sampled(self, element: Element) -> list[Array]:
        """Return times (k, 1), coordinates, rates and second derivatives, each (k, n), at the element's time step."""
        step = element.attribute_number("time_step")
        length = float(self.times[-1])
        count = length / step if step > 0.0 else np.inf
        if not count < MAX_ROWS:
            raise element.wrong(f"time_step: {step:g} s makes more than {MAX_ROWS} points, or none, of {length:g} s")
        parts: list[list[Array]] = [[], [], [], []]
        for k, (begin, end) in enumerate(zip(self.times[:-1].tolist(), self.times[1:].tolist(), strict=True)):
            T = end - begin
            t = np.linspace(0.0, T, max(1, round(T / step)) + 1)[(1 if k else 0) :]
            first, last = (np.stack([self.q[i], self.rates[i], self.seconds[i]]) for i in (k, k + 1))
            found = BETWEEN[self.kind](first, last, t, T, float(self.blends[k + 1]))
            for part, new in zip(parts, (begin + t[:, None], *found), strict=True):
                part.append(new)
        return [np.concatenate(part) for part in parts]


def read(element: Element, n: int, word: str) -> Points:
    """Return the points of a trajectory of n coordinates; `word` is the name of the coordinates in the file.

    Raises:
        FormatError: if a point is invalid.
    """
    points = element.child("points").all("point")
    if len(points) < 2:
        raise element.wrong(f"expected two or more points, got {len(points)}")
    times = _times(element, points)
    q = np.array([point.child(word).vector(n) for point in points])
    rates, seconds = np.zeros_like(q), np.zeros_like(q)
    if element.name == AVERAGE:
        slopes = np.diff(q, axis=0) / np.diff(times)[:, None]
        rates[1:-1] = 0.5 * (slopes[:-1] + slopes[1:])
        rates[0], rates[-1] = (points[k].child(f"{word}_dot").vector(n) for k in (0, -1))
    if element.name in (CUBIC, QUINTIC):
        rates = np.array([point.child(f"{word}_dot").vector(n) for point in points])
    if element.name == QUINTIC:
        seconds = np.array([point.child(f"{word}_ddot").vector(n) for point in points])
    return Points(element.name, times, q, rates, seconds, _blends(element, points, times))


def _times(element: Element, points: list[Element]) -> Array:
    """Return the times of the points, (k,), s, starting at 0."""
    definition = element.attribute("time_definition")
    if definition not in ("absolute", "relative"):
        raise element.wrong(f"time_definition: expected absolute or relative, got '{definition}'")
    given = np.array([0.0, *(point.attribute_number("time") for point in points[1:])])
    times = np.cumsum(given) if definition == "relative" else given
    late = np.flatnonzero(np.diff(times) <= 0.0)
    if len(late):
        raise points[late[0] + 1].wrong(f"time: this point comes {np.diff(times)[late[0]]:g} s after the one before it")
    return np.asarray(times)


def _blends(element: Element, points: list[Element], times: Array) -> Array:
    """Return the durations of the parabolas before each point, (k,), s."""
    found = np.zeros(len(points))
    if element.name != PARABOLIC:
        return found
    default = element.attribute_number("blend_time_default", 0.0)
    for k, (point, T) in enumerate(zip(points[1:], np.diff(times).tolist(), strict=True), 1):
        found[k] = point.attribute_number("blend_time", default)
        if found[k] < 0.0:
            raise point.wrong(f"blend_time: expected at least 0 s, got {found[k]:g}")
        if 2.0 * found[k] > T:
            raise point.wrong(f"blend_time: {found[k]:g} s twice is longer than the {T:g} s of this move")
    return found


def _straight(a: Array, b: Array, t: Array, T: float, _: float) -> tuple[Array, Array, Array]:
    slope = (b[0] - a[0]) / T
    return a[0] + t[:, None] * slope, np.tile(slope, (len(t), 1)), np.zeros((len(t), len(slope)))


def _polynomial(conditions: int) -> Between:
    """Return the interpolation with 2 (cubic) or 3 (quintic) conditions at each end."""

    def between(a: Array, b: Array, t: Array, T: float, _: float) -> tuple[Array, Array, Array]:
        order = 2 * conditions
        powers = np.array([[_derivative(p, d, x) for p in range(order)] for x in (0.0, T) for d in range(conditions)])
        c = np.linalg.solve(powers, np.concatenate([a[:conditions], b[:conditions]]))
        rows = [np.array([[_derivative(p, d, x) for p in range(order)] for x in t.tolist()]) @ c for d in range(3)]
        return rows[0], rows[1], rows[2]

    return between


def _derivative(power: int, times: int, x: float) -> float:
    """Return the derivative of x^power of order `times`."""
    factor = 1.0
    for k in range(times):
        factor *= power - k
    return factor * x ** (power - times) if power >= times else 0.0


def _blended(a: Array, b: Array, t: Array, T: float, blend: float) -> tuple[Array, Array, Array]:
    """Interpolate linearly with a parabola of `blend` s at each end."""
    if blend <= 0.0:
        return _straight(a, b, t, T, 0.0)
    way = b[0] - a[0]
    top = way / (T - blend)
    x = t[:, None]
    begins, ends = x < blend, x > T - blend
    at = np.where(begins, 0.5 * top / blend * x**2, top * (x - 0.5 * blend))
    at = np.where(ends, way - 0.5 * top / blend * (T - x) ** 2, at)
    rate = np.where(begins, top / blend * x, np.where(ends, top / blend * (T - x), top))
    return a[0] + at, rate, np.where(begins, top / blend, np.where(ends, -top / blend, 0.0))


BETWEEN: dict[str, Between] = {
    LINEAR: _straight,
    CUBIC: _polynomial(2),
    AVERAGE: _polynomial(2),
    QUINTIC: _polynomial(3),
    PARABOLIC: _blended,
}
