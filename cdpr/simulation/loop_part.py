"""Base class of the parts that a loop has besides plant, controller and solver."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr.base.column import Column
from cdpr.base.errors import PluginError
from cdpr.base.needs import Needs, of_loop_part, of_moving_anchors
from cdpr.mechanics.anchors import Anchors
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import Compiled
from cdpr.native.random_numbers import Stream
from cdpr.plugins import Backend
from cdpr.plugins.snapshots import put_back, save
from cdpr.tension.operations import Operation


@dataclass(frozen=True, eq=False)
class Surroundings:
    """Live arrays and objects of the loop that its parts read and write.

    Attributes:
        robot: simulated robot.
        backend: plant.
        step: control period, s.
        view: function that returns the columns of the present row from one field to another, live.
        has: function that returns True if rows have a group of columns, a key of `cdpr.base.columns.GROUPS`.
        columns: the part's own columns, live, by name.
        state: (13,), true state of the present sample, read-only.
        seen: (13,), state that controller and tension stage use. It is read-only unless the part declares it in
            `writes`; it equals `state` until a part writes it, in each sample.
        seen_cables: (2, m), lengths, m, and rates, m/s, that the controller measures; likewise, with the true values.
        imposed: (m,), N, tensions that events impose on cables, such as a break; NaN for none. Read-only.
        sent: (m,), N, tensions as sent in the previous control step, before faults act on them, if a part sets
            `reads_commands`; 0 before the first one. Read-only.
        limits: (2, m), N, lowest and highest tensions that the tension distribution knows. Read-only.
        locked: (m,), True for cables that it knows to be broken or jammed. Read-only.
    """

    robot: Robot
    backend: Backend
    step: float
    view: Callable[..., Array]
    has: Callable[[str], bool]
    columns: Mapping[str, Array]
    state: Array
    seen: Array
    seen_cables: Array
    imposed: Array
    sent: Array
    limits: Array
    locked: NDArray[np.bool_]


class LoopPart:
    """Part of the loop with operations at named places of a step.

    The loop calls `connect` once, then takes the operations. Snapshots contain `saved_arrays`; a part with other state
    overrides `snapshot` and `restore`, and is then not simulated in blocks of rollouts.

    Attributes:
        name: name of the part in messages, in `run.json` and of its operations; unique in the loop.
        section: key of its section in a scenario, if it differs from the name.
        columns: columns that it adds to a row: those of a group in `cdpr.base.columns.GROUPS`, for the documentation.
        arrays: its memory besides the streams, live.
        writes: "seen" or "seen_cables" or both, if operations of `observed` write these arrays of `Surroundings`.
        reads_commands: True if it uses `sent` of `Surroundings`.
        works: sources of work on the platform that it adds, each with its column of the work since the first sample, J;
            "" if the work is unknown.
        moves_anchors: True if `anchor_motion` moves the anchors on the frame; at most one part of a loop. Its section
            declares `needs = of_moving_anchors()`, see `cdpr.base.needs`.
        needs: support that it needs, likewise; by default `of_loop_part()`: in each run, and rejected by exports.
        measures: True if its columns are measurements, which controllers observe.
        streams: its random streams, which restart at a reset. Their names must be unique in the loop.

    Example:
        >>> import numpy as np
        >>> from cdpr.base.column import Column
        >>> from cdpr.simulation.loop_part import LoopPart
        >>> from cdpr.tension.operations import Operation
        >>> class Travel(LoopPart):
        ...     name = "travel"
        ...     columns = (Column("travel", 1, "m", "Distance so far"),)
        ...     def connect(self, surroundings):
        ...         self.total, self.now = np.zeros(1), surroundings
        ...         self.arrays = (self.total,)
        ...     def observed(self, period):
        ...         return [Operation(self.name, lambda: self.add(period))]
        ...     def add(self, period):
        ...         self.total += period * np.linalg.norm(self.now.view("velocity"))
        ...         self.now.columns["travel"][:] = self.total
    """

    name: str = ""
    section: str = ""
    columns: tuple[Column, ...] = ()
    arrays: tuple[Array, ...] = ()
    writes: frozenset[str] = frozenset()
    reads_commands: bool = False
    works: Mapping[str, str] = MappingProxyType({})
    moves_anchors: bool = False
    needs: Needs = of_loop_part()
    streams: tuple[Stream, ...] = ()
    measures: bool = False

    def connect(self, surroundings: Surroundings) -> None:
        """Receive the live arrays of the loop, before `arrays` and the operations are read."""

    def anchor_motion(self, anchors: Anchors) -> Compiled:
        """Return the compiled operation that writes `anchors` at a time, s; see `Anchors.move`.

        It is called once, before `connect`, if `moves_anchors`. A nominal robot's anchors move with the true ones, with
        which the controller's wrench matrix is computed.
        """
        raise PluginError(f"part '{self.name}' declares moves_anchors but has no method anchor_motion")

    def observed(self, period: float) -> Sequence[Operation]:
        """Return the operations after the plant was observed, a control `period` (s) later; 0 at the first sample."""
        return ()

    def commanded(self) -> Sequence[Operation]:
        """Return the operations that turn the commands of the winches into those that their drives apply.

        They write the column `drive_command` at each sample, and at the first one up to twice.
        """
        return ()

    def distributed(self) -> Sequence[Operation]:
        """Return the operations after the tension stage, before the plant moves."""
        return ()

    def moved(self) -> Sequence[Operation]:
        """Return the operations after the plant moved, before it is observed."""
        return ()

    @property
    def title(self) -> str:
        """Return the name for messages."""
        return f"part of the loop '{self.name}'"

    @property
    def nonlinear(self) -> str:
        """Return why the loop cannot be linearised with it; "" if `arrays` are its states, and all maps are smooth."""
        return f"the states of the {self.title} are not known"

    @property
    def linear_states(self) -> tuple[Array, ...]:
        """Return the arrays that are states of the linearised loop; by default `arrays`."""
        return self.arrays

    @property
    def all_needs(self) -> tuple[Needs, ...]:
        """Return `needs`, and the needs of moving anchors if it moves them."""
        return (of_moving_anchors(), self.needs) if self.moves_anchors else (self.needs,)

    @property
    def in_arrays(self) -> bool:
        """Return True if `saved_arrays` contain its whole memory."""
        return type(self).snapshot is LoopPart.snapshot

    @property
    def saved_arrays(self) -> tuple[Array, ...]:
        """Return `arrays`, and the states of the streams."""
        return (*self.arrays, *(stream.state for stream in self.streams))

    def snapshot(self) -> object:
        """Return a copy of the memory."""
        return save(self.saved_arrays)

    def restore(self, snapshot: Any) -> None:
        """Restore a snapshot.

        Args:
            snapshot: result of `snapshot` of the same object.
        """
        put_back(snapshot, self.saved_arrays)

    def reset(self) -> None:
        """Return to the state before the first sample; by default all arrays become 0, and the streams restart."""
        for array in self.arrays:
            array[...] = 0
        for stream in self.streams:
            stream.restart()

    def describe(self) -> dict[str, Any]:
        """Return metadata for `run.json`; {} for none."""
        return {}

    def close(self) -> None:
        """Release resources; may be called again."""


def writes(parts: Iterable[LoopPart], name: str) -> bool:
    """Return True if one of these parts writes the array `name` of `Surroundings`."""
    return any(name in part.writes for part in parts)


def perceived_differs(nominal: Robot | None, parts: Iterable[LoopPart]) -> bool:
    """Return True if controller and tension stage use another robot or state than the true one.

    Their wrench matrix then differs from that of the plant, and a run has the columns of the true wrench and margins.

    Args:
        nominal: nominal robot, if it differs from the robot.
        parts: parts of the loop.
    """
    return nominal is not None or writes(parts, "seen")
