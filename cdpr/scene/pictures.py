"""Frames of a robot at n rows of a run or n poses, for any viewer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from cdpr.model.robot import Array
from cdpr.scene.subject import Subject

# Relative to a cable's largest tension: distance to a limit at which it counts as reached, and tension below which a
# cable counts as slack. Solvers reach limits only to round-off; smaller differences are invisible.
AT_LIMIT = 1e-6


# Multiple of the 75th percentile of the tensions; larger tensions belong to a diverging run.
BEYOND = 20.0


FINEST = 33  # points of the line of a sagging cable: a power of two plus one
TINY = np.finfo(float).tiny


class State(IntEnum):
    """Display state of a cable."""

    TAUT = 0
    SLACK = 1  # no tension
    LOWEST = 2  # command at or below the smallest tension
    HIGHEST = 3  # command at or above the largest tension
    BROKEN = 4  # broken


@dataclass(frozen=True, eq=False)
class Pictures:
    """Subject with m cables at n poses."""

    subject: Subject
    time: Array  # (n,), s
    position: Array  # (n, 3), m
    orientation: Array  # (n, 4), quaternion w, x, y, z
    tension: Array | None = None  # (n, m), N, tensions in the cables; None if unknown
    state: NDArray[np.int8] | None = None  # (n, m), `State`; None if unknown
    desired_position: Array | None = None  # (n, 3), m, None if not distinguished from the position
    desired_orientation: Array | None = None  # (n, 4)
    force: Array | None = None  # (n, 3), N, external force at the platform's origin; None if zero
    unwound: Array | None = None  # (n, m), m, unwound lengths; None if unknown or if no cable sags
    readings: Mapping[str, Array] = field(default_factory=dict)  # (n, k) of each of the subject's sensors, if known

    @cached_property
    def ends(self) -> Array:
        """Ends of the cables on the frame and on the platform, (n, m, 2, 3), m."""
        return self.subject.ends(self.position, self.orientation)

    def cable_lines(self, count: int) -> Array:
        """Return lines of the cables from frame to platform, (n, m, count, 3), m; (n, m, 2, 3) if none is a curve."""
        if self.unwound is None:
            return self.ends
        return self.subject.curves(self.position, self.orientation, self.unwound, count)

    def thinned_lines(self, tolerance: float) -> Array:
        """Return the lines with the fewest points, 2^k + 1, that are within `tolerance` (m) of the cables.

        The lines have at most `FINEST` points. Cables that are not finite are ignored.
        """
        fine = self.cable_lines(FINEST)
        for step in (FINEST - 1 >> k for k in range(FINEST.bit_length())):
            kept = fine[:, :, ::step] if step < fine.shape[2] else fine
            if _apart(fine, kept) <= tolerance:
                break
        return kept

    @cached_property
    def way(self) -> Array:
        """Positions of the guided point, (n, 3), m: the platform's origin, or a tool."""
        return self.subject.led_at(self.position, self.orientation)

    @cached_property
    def desired_way(self) -> Array | None:
        """Desired positions of the guided point, (n, 3), m."""
        if self.desired_position is None or self.desired_orientation is None:
            return self.desired_position
        return self.subject.led_at(self.desired_position, self.desired_orientation)

    @property
    def range(self) -> tuple[float, float]:
        """Smallest and largest tension (N) of taut cables, for the colours, without outliers of a diverged run."""
        if self.tension is None or self.state is None:
            return 0.0, 0.0
        pulling = self.tension[(self.state != State.SLACK) & (self.state != State.BROKEN) & np.isfinite(self.tension)]
        if not pulling.size:
            return 0.0, 0.0
        usual = pulling[pulling <= BEYOND * np.percentile(pulling, 75)]
        return float(usual.min()), float(usual.max())


def _apart(fine: Array, kept: Array) -> float:
    """Return the largest distance (m) of points (..., k s + 1, 3) from lines through every s-th of them."""
    pieces = kept.shape[2] - 1
    step = (fine.shape[2] - 1) // pieces
    start, along = kept[:, :, :-1, None], np.diff(kept, axis=2)[:, :, :, None]
    inner = fine[:, :, :-1].reshape(*fine.shape[:2], pieces, step, 3)
    away = inner - start
    with np.errstate(all="ignore"):
        share = np.clip((away * along).sum(-1) / np.maximum((along * along).sum(-1), TINY), 0.0, 1.0)
        distance = np.linalg.norm(away - share[..., None] * along, axis=-1)
    return float(np.max(distance[np.isfinite(distance)], initial=0.0))


def pictures(
    subject: Subject,
    time: Array,
    position: Array,
    orientation: Array,
    *,
    tension: Array | None = None,
    command: Array | None = None,
    desired: tuple[Array, Array] | None = None,
    force: Array | None = None,
    unwound: Array | None = None,
    readings: Mapping[str, Array] | None = None,
    limits_until: float = np.inf,
) -> Pictures:
    """Return a subject at n poses.

    Args:
        subject: the robot.
        time: (n,), s.
        position: (n, 3), m, of the platform's origin.
        orientation: (n, 4), quaternion w, x, y, z.
        tension: (n, m), N, in the cables.
        command: (n, m), N; defaults to `tension`.
        desired: desired positions (n, 3), m, and orientations (n, 4).
        force: (n, 3), N, external force.
        unwound: (n, m), m, unwound lengths, for the curves of cables that sag.
        readings: columns of sensors (n, w), by name: distances, m, or 1 for each point that is seen.
        limits_until: time (s) from which the subject's tension limits no longer apply.
    """
    state = None
    if tension is not None:
        state = _states(subject, time, tension, tension if command is None else command, limits_until)
    if force is not None and not np.any(force):
        force = None
    where, how = (None, None) if desired is None else desired
    if not subject.spans:
        unwound = None
    read = {
        each.name: each.read(np.asarray(readings[each.column]))
        for each in subject.sensors
        if readings and each.column in readings
    }
    return Pictures(subject, time, position, orientation, tension, state, where, how, force, unwound, read)


MOST = 1e6  # N, above all tensions of robots


def weight_range(subject: Subject, weight: float) -> tuple[float, float]:
    """Return an estimated range of cable tensions (N) for a logarithmic colour ramp, before a run is known.

    The range is a quarter to 32 times the platform's weight (N) per cable, within the limits. It contains tensions of
    suspended and fully constrained robots; a factor of 2 is a seventh of the ramp. Without weight, the range starts at
    a thousandth of the largest limit.
    """
    lowest, highest = float(subject.tension_min.min()), float(subject.tension_max.max())
    highest = min(highest, MOST)
    each = weight / len(subject.cables)
    low, high = (each / 4.0, 32.0 * each) if each > 0.0 else (1e-3 * highest, highest)
    low = max(low, min(lowest, highest / 2.0))
    return low, max(min(high, highest), 2.0 * low)


def _states(subject: Subject, time: Array, tension: Array, command: Array, limits_until: float) -> NDArray[np.int8]:
    state = np.full(tension.shape, State.TAUT, np.int8)
    near = AT_LIMIT * np.where(np.isfinite(subject.tension_max), subject.tension_max, 0.0)
    known = (time < limits_until)[:, None]
    with np.errstate(invalid="ignore"):  # comparisons with NaN are False
        state[known & (command <= subject.tension_min + near)] = State.LOWEST
        state[known & (command >= subject.tension_max - near)] = State.HIGHEST
        # Cables without tension are slack; rigid legs, with negative lower limits, push.
        state[(tension <= near) & (subject.tension_min >= 0.0)] = State.SLACK
    for cable, since in subject.broken:
        state[time >= since, cable] = State.BROKEN
    return state
