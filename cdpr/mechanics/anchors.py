"""World anchors that move: live arrays that the plant and the loop evaluate at their own times.

An operation of the caller writes position, velocity and acceleration of all anchors at a time. Each owner of a table of
lines has an operation that calls it and writes the positions into that table. See `anchors.hpp`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cdpr.base.errors import CdprError
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import Compiled, bind

if TYPE_CHECKING:
    from cdpr.native.library import Bound


class Anchors:
    """World anchors of a robot as live arrays, at rest until `move`.

    Attributes:
        values: (3, m, 3) the three arrays below.
        position: (m, 3) anchors A_i [m].
        velocity: (m, 3) their velocities [m/s].
        acceleration: (m, 3) their accelerations [m/s^2].

    Raises:
        CdprError: if a cable does not leave from a point.

    Example:
        >>> import cdpr
        >>> from cdpr.mechanics.anchors import Anchors
        >>> Anchors(cdpr.load_robot("caroca")).position.shape
        (8, 3)
    """

    def __init__(self, robot: Robot) -> None:
        for cable in robot.cables:
            if cable.exit is not None and cable.exit.header:
                raise CdprError(
                    f"anchors that move: expected cables that leave from points, got exit {cable.exit.type} of cable "
                    f"'{cable.name}'; omit the exit"
                )
        self.values = np.zeros((3, robot.m, 3))
        self.position, self.velocity, self.acceleration = self.values
        self._rest = np.ascontiguousarray(robot.anchors[:, :3])
        self.position[:] = self._rest
        self._mover = np.zeros(2, dtype=np.int64)
        self._moving: Compiled | None = None

    def move(self, operation: Compiled) -> None:
        """Move the anchors.

        Args:
            operation: compiled operation that writes the arrays at a time [s] and returns 0; after another result the
                run ends. It is called in any order of times, so it must not have a memory.

        Raises:
            CdprError: if it is not a compiled operation.
        """
        if not isinstance(getattr(operation, "operation", None), int):
            raise CdprError(
                f"anchors that move: expected a compiled operation, such as the result of bind or Foreign, got "
                f"{type(operation).__name__}"
            )
        self._moving = operation  # keeps it alive
        self._mover[:] = operation.operation, operation.place

    def placing(self, lines: Array, robot: Robot | None = None) -> Bound:
        """Return the operation that writes the arrays at its time, and the positions into a table of lines.

        Args:
            lines: (m, 6) table of `line_table`; written.
            robot: robot of the table, if it has other anchors: they keep their distance from these.
        """
        rest = self._rest if robot is None else robot.anchors[:, :3]
        return bind("place_anchors", mover=self._mover, anchors=self.values, apart=rest - self._rest, lines=lines)


class PlantAnchors:
    """Anchors of one plant, which counts its physics steps.

    Attributes:
        given: arguments by which the operation `NAME_anchored` of an integrator exceeds `NAME`.
        arrays: memory for snapshots; zeros after a reset.

    Args:
        anchors: anchors that move.
        lines: (m, 6) table of lines of the plant; written.
        physics_step: physics step [s].
    """

    def __init__(self, anchors: Anchors, lines: Array, physics_step: float) -> None:
        self._kept = anchors, (placing := anchors.placing(lines))  # their addresses are in `given`
        past, taken = np.zeros(len(lines) + 1), np.zeros(1, dtype=np.int64)
        self.arrays: tuple[NDArray[Any], ...] = past, taken
        self._step = {
            "placing": np.array([placing.operation, placing.place], dtype=np.int64),
            "taken": taken,
            "every": physics_step,
        }
        self.given = {**self._step, "anchors": anchors.values, "past": past}

    def before_step(self) -> Bound:
        """Return the operation before each step of a plant that evaluates its cables once per step."""
        return bind("place_for_step", **self._step)

    def reset(self) -> None:
        """Return to time zero."""
        for array in self.arrays:
            array[:] = 0
