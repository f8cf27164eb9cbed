"""Cables that pass their anchors or swivel axes, where the energy balance is not meaningful."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr.cables import read_exits
from cdpr.log.header import Header
from cdpr.log.run import Run
from cdpr.model.robot import Array

STRIDE = 32  # samples between two checks far from axes

WHERE = {"through_anchor_s": "anchor", "through_axis_s": "swivel axis"}  # by figure
PASSED = "passed"  # figure with the sentence


class Singular(NamedTuple):
    """First passages so far.

    Attributes:
        found: cable index and time, s, by figure.
        last: pose (7,) of the previous sample; None before the first.
    """

    found: Mapping[str, tuple[int, float]] = {}
    last: Array | None = None

    def added(self, part: Run, intact: NDArray[np.bool_]) -> Singular:
        """Return the passages including those of the next samples (n,); `intact` (n, m) marks unbroken cables."""
        found = dict(self.found)
        poses = part.rows[:, part.header.layout.span("position", "orientation")]
        if "through_anchor_s" not in found:
            # Length minus the possible shortening until the next sample; not positive if the cable passes its anchor.
            reach = np.where(intact, part.length - np.abs(part.rate) * part.header.control_step, np.inf)
            _keep(found, "through_anchor_s", reach <= 0.0, part.time)
        if "through_axis_s" not in found and (cables := swivelling(part.header)):
            over = _turned_over(part, poses if self.last is None else np.vstack([self.last, poses]), cables)
            turned = np.zeros_like(intact)
            turned[len(intact) - len(over) :, [i for i, _ in cables]] = over
            _keep(found, "through_axis_s", turned & intact, part.time)
        return Singular(found, poses[-1].copy())

    def figures(self, cables: tuple[str, ...]) -> dict[str, Any]:
        """Return the first times of passages through an anchor and an axis, s, and a sentence; empty if none."""
        if not self.found:
            return {}
        rows = [(time, cables[i], WHERE[name]) for name, (i, time) in self.found.items()]
        text = "; ".join(f"cable '{cable}' passes its {where} at {time:.4g} s" for time, cable, where in sorted(rows))
        return {**{name: time for name, (_, time) in self.found.items()}, PASSED: text}


def swivelling(header: Header) -> list[tuple[int, Array]]:
    """Return index and direction (3,) of each cable with a swivel axis."""
    swivels = [each.swivel() if each else None for each in read_exits(header.exits)]
    return [(i, np.array(swivel)) for i, swivel in enumerate(swivels) if swivel is not None]


def _keep(found: dict[str, tuple[int, float]], name: str, where: NDArray[np.bool_], time: Array) -> None:
    if where.any():
        k, i = np.argwhere(where)[0]
        found[name] = int(i), float(time[k])


def _turned_over(part: Run, poses: Array, cables: list[tuple[int, Array]]) -> NDArray[np.bool_]:
    """Return where a swivel turns by more than 90 degrees from one pose (n, 7) to the next, (n - 1, cables)."""
    over = np.zeros((len(poses) - 1, len(cables)), bool)
    anchors = np.array(part.header.anchors)[[i for i, _ in cables]]
    axes = np.array([axis for _, axis in cables])
    # Upper bound of the speed of the cables' ends between the coarse poses.
    spin, arm = np.linalg.norm(part.angular_velocity, axis=1).max(), np.linalg.norm(anchors[:, 3:], axis=1).max()
    speed = float(np.linalg.norm(part.velocity, axis=1).max() + spin * arm)
    coarse = np.linalg.norm(_square(poses[::STRIDE], anchors, axes), axis=2)
    near = ~(coarse.min(axis=1) > 2.0 * STRIDE * part.header.control_step * speed)
    for block in np.flatnonzero(near).tolist():
        k = max(block - 1, 0) * STRIDE
        arms = _square(poses[k : (block + 1) * STRIDE + 1], anchors, axes)
        over[k : k + len(arms) - 1] = np.sum(arms[1:] * arms[:-1], axis=2) < 0.0
    return over


def _square(poses: Array, anchors: Array, axes: Array) -> Array:
    """Return the parts, perpendicular to the axes, of the vectors between the cables' anchors, (n, m, 3), m."""
    q = poses[:, None, 3:]
    b = anchors[:, 3:]
    t = 2.0 * np.cross(q[..., 1:], b)
    d = poses[:, None, :3] + b + q[..., :1] * t + np.cross(q[..., 1:], t) - anchors[:, :3]
    return np.asarray(d - np.sum(d * axes, axis=2)[..., None] * axes)
