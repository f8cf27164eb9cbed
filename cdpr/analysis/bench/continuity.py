"""Detection of jumps of the tensions along a smooth path, by refinement of its steepest steps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from cdpr.mechanics.kinematics import make_state, wrench_matrix
from cdpr.model import Robot, rotations
from cdpr.model.robot import Array

# A step that remains above this share of its initial size after all bisections is a jump.
VANISHED = 1e-3


@dataclass(frozen=True, eq=False)
class Path:
    """Straight path between two poses, along which interpolated tensions balance the wrench.

    Attributes:
        robot: the robot.
        poses: (2, 7), positions (m) and quaternions.
        tensions: (2, m), N, within the limits, so that every point is feasible.
    """

    robot: Robot
    poses: Array
    tensions: Array

    def at(self, s: float) -> tuple[Array, Array]:
        """Return W (n, m) and the wrench (n,), both in the robot's degrees of freedom, at 0 <= s <= 1."""
        a, b = self.poses
        axis, angle = self._turn
        attitude = rotations.multiply(rotations.from_axis_angle(axis, s * angle), a[3:])
        state = make_state((1.0 - s) * a[:3] + s * b[:3], attitude)
        W = np.ascontiguousarray(wrench_matrix(self.robot, state)[self.robot.rows])
        return W, W @ ((1.0 - s) * self.tensions[0] + s * self.tensions[1])

    @cached_property
    def _turn(self) -> tuple[Array, float]:
        """Axis (3,) and angle, rad, of the rotation between the poses."""
        a, b = self.poses
        turn = rotations.rotation_vector(rotations.multiply(b[3:], rotations.conjugate(a[3:])))
        angle = float(np.linalg.norm(turn))
        return (turn / angle if angle > 0.0 else np.array([1.0, 0.0, 0.0])), angle


@dataclass(frozen=True)
class Steepest:
    """Steepest place found on a path."""

    change: float  # N, of one tension over the finest step
    first: float  # N, over the coarsest step
    answered: float  # share of the path's points with an answer

    def jumps(self, noise: float) -> bool:
        """Return True if the change does not vanish; `noise` is the scatter of answers to equal problems, N."""
        return self.change > VANISHED * self.first + noise


def steepest(answer: Callable[[float], Array | None], steps: int, halvings: int, places: int = 1) -> Steepest:
    """Return the steepest place of a path, found by bisection of its largest steps.

    What lies between the samples may be missed.

    Args:
        answer: function of 0 <= s <= 1 that returns tensions (m,), or None; steps without answer are ignored.
        steps: number of equal steps.
        halvings: number of bisections towards the steeper side.
        places: number of largest steps to refine; the one with the largest final change is returned.
    """

    def change(a: Array | None, b: Array | None) -> float:
        return 0.0 if a is None or b is None else float(np.abs(b - a).max())

    points = [answer(k / steps) for k in range(steps + 1)]
    found = [change(a, b) for a, b in pairwise(points)]
    answered = sum(point is not None for point in points) / len(points)
    best = Steepest(0.0, 0.0, answered)
    for k in sorted(range(steps), key=lambda k: -found[k])[:places]:
        s, width, low, high = k / steps, 1.0 / steps, points[k], points[k + 1]
        last = found[k]
        for _ in range(halvings):
            width /= 2
            middle = answer(s + width)
            before, after = change(low, middle), change(middle, high)
            if before >= after:
                high, last = middle, before
            else:
                s, low, last = s + width, middle, after
        if last >= best.change:
            best = Steepest(last, found[k], answered)
    return best
