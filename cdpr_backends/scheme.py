"""Integrators of the reference, bound for any number of steps. See `include/cdpr/scheme.hpp` for their scheme."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, Any

from cdpr.mechanics.anchors import Anchors, PlantAnchors
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.plugins import Backend
from cdpr.plugins.backend import Operations
from cdpr.plugins.snapshots import SnapshotOfArrays

if TYPE_CHECKING:
    from cdpr.native.library import Bound


def keep_state(state: Array, begin: Callable[[], object]) -> None:
    """Call an operation that starts the integrator in `state` (13,), which keeps its bits."""
    before = state.copy()
    begin()
    state[:] = before


class Integrator(SnapshotOfArrays, Backend):
    """Backend that integrates any number of physics steps in one operation, `bind_steps`."""

    _anchors: PlantAnchors | None = None

    def bind_steps(self, operation: str, **given: Any) -> None:
        """Set the operation of the kernel library that integrates, and its arguments except `steps`.

        It is bound at the first use of each number of steps and kept.
        """
        given |= {"state": self.state, "step": self.physics_step}
        self._operation, self._given = operation, given
        self._steps: Callable[[int], Bound] = cache(lambda n: bind(operation, **given, steps=n))

    def follow(self, anchors: Anchors) -> None:
        """Evaluate the cables with anchors that move, at the time of each stage."""
        given = self._given
        if not given["lines"].flags.writeable:
            given["lines"] = given["lines"].copy()
        self._anchors = own = PlantAnchors(anchors, given["lines"], self.physics_step)
        self.bind_steps(f"{self._operation}_anchored", **given, **own.given)
        self.arrays = (*self.arrays, *own.arrays)

    def restart(self) -> None:
        """Return anchors that move to time zero."""
        if self._anchors is not None:
            self._anchors.reset()

    def step(self, n: int) -> None:
        """Advance by n physics steps."""
        self._steps(n)()

    def operations(self, n: int) -> Operations:
        """Return the integrator for n physics steps."""
        return [self._steps(n)]
