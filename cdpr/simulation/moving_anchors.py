"""Anchors that a part of the loop moves, as the plant, the sample and the nominal robot use them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NoReturn

import numpy as np

from cdpr.base.errors import CdprError, PluginError
from cdpr.cables.tables import line_table
from cdpr.mechanics.anchors import Anchors
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.simulation.loop_part import LoopPart
from cdpr.simulation.observe import Observation
from cdpr.simulation.parts import Parts
from cdpr.tension.operations import Operation


def moving_part(parts: Iterable[LoopPart]) -> LoopPart | None:
    """Return the part of a loop that moves the anchors; None if they are at rest.

    Raises:
        CdprError: if several parts move them.
    """
    movers = [part for part in parts if part.moves_anchors]
    if len(movers) > 1:
        names = ", ".join(repr(part.name) for part in movers)
        raise CdprError(f"anchors that move: expected one part that moves them, got {names}")
    return movers[0] if movers else None


class LoopAnchors:
    """Anchors of a loop. Anchors at rest have no operations and no arrays.

    Attributes:
        arrays: memory of the loop for snapshots.

    Raises:
        CdprError: if several parts move the anchors, or the robot does not support it.
        PluginError: if the backend does not support it.
    """

    def __init__(self, parts: Parts) -> None:
        part = moving_part(parts.more)
        self._anchors: Anchors | None = None
        self.arrays: tuple[Array, ...] = ()
        if part is None:
            return
        self._name, self._cables = part.name, [cable.name for cable in parts.robot.cables]
        self._anchors = anchors = Anchors(parts.robot)
        anchors.move(part.anchor_motion(anchors))
        parts.backend.follow(anchors)
        self._past = np.zeros(parts.robot.m)
        self.arrays = (anchors.values, self._past)

    def lines(self, robot: Robot) -> Array:
        """Return a table of lines (m, w) for `placing`; the frozen one of the robot if the anchors are at rest."""
        return line_table(robot) if self._anchors is None else line_table(robot).copy()

    def placing(self, lines: Array, robot: Robot) -> list[Operation]:
        """Return the operations that write the anchors at the time of the sample into the table of a robot."""
        if self._anchors is None:
            return []
        checking = bind("not_finite", values=self._anchors.values.reshape(-1))
        return [
            Operation(self._name, self._anchors.placing(lines, robot), self._refuse, timed=True),
            Operation(self._name, checking, self._refuse_numbers),
        ]

    def effects(self, seen: Observation, tension: Array, period: float) -> list[Operation]:
        """Return the operation that adds the motion of the anchors to the rates and the work of an observed sample.

        Args:
            seen: the sample, observed with anchors at rest.
            tension: (m,), held since the sample before, N.
            period: control period, s; 0 at the first sample.
        """
        if self._anchors is None:
            return []
        observe = bind(
            "observe_anchors",
            anchors=self._anchors.values,
            matrix=seen.matrix,
            tension=tension,
            past=self._past,
            rate=seen.rate,
            work=seen.energies[2:3],
            period=period,
        )
        return [Operation(self._name, observe)]

    def _refuse_numbers(self, _: int) -> NoReturn:
        assert self._anchors is not None
        k, i, axis = np.argwhere(~np.isfinite(self._anchors.values))[0]
        what, bad = ("position", "velocity", "acceleration")[k], self._anchors.values[k, i, axis]
        raise PluginError(
            f"the motion of the anchors by '{self._name}' wrote {bad} into the {what} of cable '{self._cables[i]}'; "
            "expected finite numbers"
        )

    def _refuse(self, code: int) -> NoReturn:
        raise PluginError(f"the motion of the anchors by '{self._name}' returned {code}; expected 0")
