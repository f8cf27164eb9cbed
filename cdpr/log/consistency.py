"""Consistency of an estimator: errors of its estimate, and their normalised squares, counted during a run.

If the model of the estimator is right, the normalised innovation squared (NIS) of n values has a chi-square
distribution with n degrees of freedom, and so has the normalised estimation error squared (NEES): Bar-Shalom, Li,
Kirubarajan, Estimation with Applications to Tracking and Navigation (2001), section 5.4. Their means per value are then
1, and 95 % of the samples are within the band between the quantiles at 2.5 % and 97.5 %.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from cdpr.log.header import Header
from cdpr.log.run import Run
from cdpr.model import rotations
from cdpr.model.robot import Array

BAND = 0.025, 0.975  # shares of the chi-square distribution below the two ends of the band
NORMAL = 1.959963984540054  # quantile of the standard normal distribution at 97.5 %
MANY = 1000  # degrees of freedom above which Wilson and Hilferty's approximation is exact to 1e-6, and the sum slow
CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])
RESIDUAL = "fit_residual"  # column of estimators that fit poses to lengths, NaN where no pose fits
ERRORS = "position_error_m", "orientation_error_rad", "velocity_error_m_s", "angular_velocity_error_rad_s"


class Squares(NamedTuple):
    """Normalised squares so far.

    Attributes:
        total: their sum.
        values: sum of their degrees of freedom.
        samples: number of samples with such a value.
        inside: number of those within the band.
        last: the last of them.
        last_values: its degrees of freedom.
    """

    total: float = 0.0
    values: float = 0.0
    samples: int = 0
    inside: int = 0
    last: float = 0.0
    last_values: float = 0.0

    def added(self, squares: Array, sizes: Array) -> Squares:
        """Return the sums including the next samples, (k,), in their order: batches of any size give equal bits."""
        used = np.isfinite(squares) & (sizes > 0)
        squares, sizes = squares[used], sizes[used]
        if not len(squares):
            return self
        total = float(np.cumsum([self.total, *squares])[-1])
        inside = self.inside
        for size in np.unique(sizes).tolist():
            low, high = band(int(size))
            these = squares[sizes == size]
            inside += int(np.count_nonzero((these >= low) & (these <= high)))
        values, samples = self.values + float(sizes.sum()), self.samples + len(squares)
        return Squares(total, values, samples, inside, float(squares[-1]), float(sizes[-1]))

    def figures(self) -> dict[str, float] | None:
        """Return the mean per value, the share within the band, and the last one; None without samples."""
        if not self.samples:
            return None
        return {
            "mean_per_value": self.total / self.values,
            "inside_95_percent": self.inside / self.samples,
            "last": self.last,
            "last_values": self.last_values,
        }


class Consistency(NamedTuple):
    """Figures of an estimate so far.

    Attributes:
        samples: number of samples.
        largest: (4,), largest errors of position, attitude, velocity and angular velocity.
        squares: (4,), sums of the squared errors.
        nis, nees: normalised squares.
        unfitted: number of samples at which no pose fits the measured lengths; None if the estimator fits no poses.
    """

    samples: int = 0
    largest: Array = np.zeros(4)
    squares: Array = np.zeros(4)
    nis: Squares = Squares()
    nees: Squares = Squares()
    unfitted: int | None = None

    def figures(self) -> dict[str, Any]:
        """Return plain figures, {} without an estimator."""
        if not self.samples:
            return {}
        rms = np.sqrt(self.squares / self.samples)
        found: dict[str, Any] = {
            name: {"max": float(high), "rms": float(mean)}
            for name, high, mean in zip(ERRORS, self.largest, rms, strict=True)
        }
        for name, each in (("nis", self.nis), ("nees", self.nees)):
            if (figures := each.figures()) is not None:
                found[name] = figures
        if self.unfitted is not None:
            found["unfitted_samples"] = self.unfitted
        return {"estimate": found}


def consistency(found: Consistency, header: Header, rows: Array) -> Consistency:
    """Return the figures including the next samples of a run, (n, width); unchanged without an estimator."""
    if not header.layout.has("estimated") or not len(rows):
        return found
    run = Run(header, rows)
    norms = np.linalg.norm(np.stack(estimate_errors(run)), axis=2)  # (4, n)
    largest = np.fmax(found.largest, norms.max(axis=1))
    squares = np.cumsum(np.concatenate([found.squares[:, None], norms**2], axis=1), axis=1)[:, -1]
    nis, nees = found.nis, found.nees
    if header.layout.has("innovation"):
        nis = nis.added(run["nis"], run["nis_size"])
    if header.layout.has("uncertainty"):
        nees = nees.added(run["nees"], np.count_nonzero(run["estimate_sigma"] > 0.0, axis=1))
    unfitted = found.unfitted
    if RESIDUAL in header.layout.fields:
        unfitted = (unfitted or 0) + int(np.count_nonzero(np.isnan(run[RESIDUAL])))
    return Consistency(found.samples + len(rows), largest, squares, nis, nees, unfitted)


def estimate_errors(run: Run) -> tuple[Array, Array, Array, Array]:
    """Return true minus estimated position, attitude, velocity and angular velocity of a run, (K, 3) each.

    The attitude error is the rotation vector, rad, in platform axes, from the estimated to the true attitude.
    """
    estimate = run["estimated_orientation"]
    turn = rotations.between(estimate, run["orientation"])  # world axes
    names = "position", "velocity", "angular_velocity"
    position, velocity, turning = (run[name] - run[f"estimated_{name}"] for name in names)
    return position, rotations.rotate(estimate * CONJUGATE, turn), velocity, turning


@lru_cache(maxsize=256)
def band(size: int) -> tuple[float, float]:
    """Return the ends of the 95 % band of a chi-square distribution with `size` degrees of freedom.

    Of many, by Wilson and Hilferty: Abramowitz and Stegun, 26.4.17.
    """
    if size > MANY:
        spread = 2.0 / (9.0 * size)
        low, high = (size * (1.0 - spread + sign * NORMAL * math.sqrt(spread)) ** 3 for sign in (-1.0, 1.0))
        return low, high
    low, high = (_quantile(share, size) for share in BAND)
    return low, high


def _quantile(share: float, size: int) -> float:
    low, high = 0.0, size + 20.0 * math.sqrt(2.0 * size) + 20.0
    for _ in range(100):  # more halvings than bits
        middle = 0.5 * (low + high)
        if _above(middle, size) > 1.0 - share:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def _above(x: float, size: int) -> float:
    """Return the probability that a chi-square number exceeds x: Abramowitz and Stegun, 26.4.4 and 26.4.5."""
    half = 0.5 * x
    odd = size % 2
    found = math.erfc(math.sqrt(half)) if odd else math.exp(-half)
    for k in range(1 if odd else 2, size, 2):
        found += math.exp(0.5 * k * math.log(half) - half - math.lgamma(0.5 * k + 1.0)) if half > 0.0 else 0.0
    return found
