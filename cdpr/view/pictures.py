"""A robot at n rows of a run, or at n poses: what any viewer draws of each."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from cdpr.model.robot import Array
from cdpr.view.subject import Subject

# Share of a cable's largest tension: within that of a limit it is at it, and below that of zero it is slack. Solvers
# meet a limit to round-off, and what lies nearer than this to it no eye can tell from it.
AT_LIMIT = 1e-6


# Times what three quarters of all tensions stay below: tensions beyond are not those of a run that goes well.
BEYOND = 20.0


class State(IntEnum):
    """How a cable is drawn."""

    TAUT = 0
    SLACK = 1  # it does not pull
    LOWEST = 2  # its command is at or below its smallest tension
    HIGHEST = 3  # its command is at or above its largest
    BROKEN = 4  # it is no more


@dataclass(frozen=True, eq=False)
class Pictures:
    """A subject with m cables at n poses."""

    subject: Subject
    time: Array  # (n,), s
    position: Array  # (n, 3), m
    orientation: Array  # (n, 4), quaternion w, x, y, z
    tension: Array | None = None  # (n, m), N, in the cables; None where none is known
    state: NDArray[np.int8] | None = None  # (n, m), `State`; likewise
    desired_position: Array | None = None  # (n, 3), m, where it may be another than the position
    desired_orientation: Array | None = None  # (n, 4)
    force: Array | None = None  # (n, 3), N, from outside on the platform at its origin, where there is any

    @cached_property
    def ends(self) -> Array:
        """Ends of the cables on the frame and on the platform, (n, m, 2, 3), m."""
        return self.subject.ends(self.position, self.orientation)

    @cached_property
    def way(self) -> Array:
        """Where the point is that the motion leads, (n, 3), m: the platform's origin, or a tool."""
        return self.subject.led_at(self.position, self.orientation)

    @cached_property
    def desired_way(self) -> Array | None:
        """Where it is to be, (n, 3), m."""
        if self.desired_position is None or self.desired_orientation is None:
            return self.desired_position
        return self.subject.led_at(self.desired_position, self.desired_orientation)

    @property
    def range(self) -> tuple[float, float]:
        """Least and largest tension (N) of cables that pull: the range over which they are coloured.

        What a run that diverges ends in does not count.
        """
        if self.tension is None or self.state is None:
            return 0.0, 0.0
        pulling = self.tension[(self.state != State.SLACK) & (self.state != State.BROKEN) & np.isfinite(self.tension)]
        if not pulling.size:
            return 0.0, 0.0
        usual = pulling[pulling <= BEYOND * np.percentile(pulling, 75)]
        return float(usual.min()), float(usual.max())


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
    limits_until: float = np.inf,
) -> Pictures:
    """Return a subject at n poses, (n, 3) and (n, 4).

    Args:
        subject: the robot.
        time: (n,), s.
        position: of the platform's origin, m.
        orientation: of the platform.
        tension: in the cables, (n, m), N.
        command: what they were commanded to, (n, m), N; the tension unless given.
        desired: position and attitude that are asked for.
        force: from outside, (n, 3), N.
        limits_until: time (s) from which the subject's limits of tension do not hold any more.
    """
    state = None
    if tension is not None:
        state = _states(subject, time, tension, tension if command is None else command, limits_until)
    if force is not None and not np.any(force):
        force = None
    where, how = (None, None) if desired is None else desired
    return Pictures(subject, time, position, orientation, tension, state, where, how, force)


def weight_range(subject: Subject, weight: float) -> tuple[float, float]:
    """Return tensions (N) between which a cable's is likely to be, where no run is known yet, for a logarithmic ramp.

    From a quarter of the platform's weight (N) by cable to 32 times that, within the limits: suspended and braced
    robots alike stay inside, and a tension twice another's is a seventh of the ramp away. Without weight, from a
    thousandth of the largest limit on.
    """
    lowest, highest = float(subject.tension_min.min()), float(subject.tension_max.max())
    each = weight / len(subject.cables)
    low, high = (each / 4.0, 32.0 * each) if each > 0.0 else (1e-3 * highest, highest)
    low = max(low, min(lowest, highest / 2.0))
    return low, max(min(high, highest), 2.0 * low)


def _states(subject: Subject, time: Array, tension: Array, command: Array, limits_until: float) -> NDArray[np.int8]:
    state = np.full(tension.shape, State.TAUT, np.int8)
    near = AT_LIMIT * subject.tension_max
    known = (time < limits_until)[:, None]
    with np.errstate(invalid="ignore"):  # comparisons with NaN are false
        state[known & (command <= subject.tension_min + near)] = State.LOWEST
        state[known & (command >= subject.tension_max - near)] = State.HIGHEST
        # Cables are slack without tension; legs, whose lower limits are negative, push.
        state[(tension <= near) & (subject.tension_min >= 0.0)] = State.SLACK
    for cable, since in subject.broken:
        state[time >= since, cable] = State.BROKEN
    return state
