"""Complete state of a loop between two samples."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from cdpr.model.robot import Array
from cdpr.plugins import TensionSolver
from cdpr.plugins.snapshots import Saved, SnapshotOfArrays, put_back, save
from cdpr.simulation.controller_calls import ControllerCalls
from cdpr.simulation.parts import Parts
from cdpr.simulation.sample import Sample
from cdpr.simulation.schedule import Schedule
from cdpr.tension.command import CommandStage
from cdpr.tension.stage import TensionStage


@dataclass(frozen=True, eq=False)
class Moment:
    """Copy of the complete state of a loop."""

    place: tuple[int, int, float, int]  # as `Pipeline.place`
    live: Saved
    own: list[Any]  # of the parts

    @property
    def count(self) -> int:
        """Number of complete samples."""
        return self.place[0]

    @property
    def time(self) -> float:
        """Time, s."""
        return self.place[2]


class Memory:
    """Parts and arrays of a loop that determine its future."""

    def __init__(
        self,
        parts: Parts,
        present: Sample,
        stage: TensionStage | CommandStage,
        schedule: Schedule,
        calls: ControllerCalls,
    ) -> None:
        backend = parts.backend
        self._parts, self._stage, self._calls = parts, stage, calls
        # All members with a memory; only the backend needs a state to reset, and events are reset when a run begins.
        self._resettable = (stage, parts.controller, calls, parts.solver, *parts.more)
        self._owners, self._schedule = (backend, *self._resettable), schedule
        geometry = present.live.W, present.true_W
        self._live = (present.row, *geometry, *present.perceived, *present.anchors, backend.command, backend.external)
        if present.layout.has("drums"):
            self._live += present.drive, present.issued

    def reset(self, start: Array) -> None:
        """Reset all members, the plant to the state `start` (13,)."""
        for member in self._resettable:
            member.reset()
        self._parts.backend.command[...] = 0.0
        self._parts.backend.reset(start)

    def take(self, place: tuple[int, int, float, int]) -> Moment:
        """Return a copy.

        Raises:
            PluginError: if a part does not support it.
        """
        own = [owner.snapshot() for owner in self._owners]
        return Moment(place, save(self._live), [*own, self._schedule.snapshot(place[0])])

    def put_back(self, moment: Moment) -> None:
        """Restore a copy.

        Raises:
            PluginError: if a part does not support it.
        """
        for owner, taken in zip((*self._owners, self._schedule), moment.own, strict=True):
            owner.restore(taken)
        put_back(moment.live, self._live)

    @property
    def arrays(self) -> tuple[Array, ...] | None:
        """Return the arrays that steps change and need, the row first; None if a part has other state.

        Changes by events are not included.
        """
        backend, controller, solver = self._parts.backend, self._parts.controller, self._parts.solver
        plain = isinstance(solver, TensionSolver) and type(solver).snapshot is TensionSolver.snapshot
        if not (plain and isinstance(backend, SnapshotOfArrays) and isinstance(controller, SnapshotOfArrays)):
            return None
        more = self._parts.more
        if not all(part.in_arrays for part in more):
            return None
        members = (backend, controller, self._stage, self._calls)
        several = [*self._live, backend.state, *(array for member in members for array in member.arrays)]
        several += [array for part in more for array in part.saved_arrays]
        return tuple({id(array): array for array in several}.values())
