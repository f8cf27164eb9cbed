"""Groups of up to eight cases that are stepped together, in blocks if their structure allows."""

from __future__ import annotations

from collections.abc import Sequence

from cdpr.analysis.rollouts import block
from cdpr.analysis.rollouts.case import Case, Given, Plan
from cdpr.analysis.rollouts.recipe import UnfitError
from cdpr.model.robot import Array
from cdpr.scenario.events.commands import Kind


class Group:
    """Cases that are stepped together, in a block if their structure allows.

    Args:
        plan: data shared by all cases.
    """

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        # By the kind of external commands, None without any; no block if the cases do not fit.
        self._blocks: dict[Kind | None, block.Block | None] = {}

    def go(self, cases: Sequence[Case], stops: Sequence[int], given: Given | None = None) -> None:
        """Take up to eight cases to their own samples, unless they end before.

        Args:
            cases: cases, all begun.
            stops: number of the sample of each.
            given: kind and values (cases, 6) or (cases, m) of external wrenches or commands.
        """
        ready = [(case, stop) for case, stop in zip(cases, stops, strict=True) if case.ready(stop)]
        for k, case in enumerate(cases):
            if case.started:
                case.give(None if given is None else (given[0], given[1][k]))
        shared = self._block(None if given is None else given[0], [case for case, _ in ready])
        if shared is not None:
            shared.go(*zip(*ready, strict=True))
        for case, stop in ready:
            if shared is None and case.ready(stop):
                case.go(stop)

    def again(
        self,
        cases: list[Case],
        stops: Sequence[int],
        given: Given | None,
        rows: Array,
        at: slice | list[int],
    ) -> bool:
        """Take the cases of the last call all this number of steps further, and write their rows into columns `at`.

        Return False if `go` has to do or to finish this.
        """
        shared = self._blocks.get(None if given is None else given[0])
        if shared is None or (given is not None and not shared.give(cases, given[1])):
            return False
        return shared.again(cases, stops, rows, at)

    def _block(self, kind: Kind | None, cases: Sequence[Case]) -> block.Block | None:
        """Return the block; None if these cases are too few, or run alone."""
        if kind not in self._blocks and len(cases) >= block.WORTHWHILE:
            try:
                self._blocks[kind] = block.Block(self._plan, cases[0])
            except UnfitError:
                self._blocks[kind] = None
        return self._blocks.get(kind) if cases else None

    def show(self, cases: Sequence[Case], rows: Array, columns: Sequence[int]) -> None:
        """Write the rows of the cases in lanes into columns of `rows`."""
        for shared in self._blocks.values():
            if shared is not None:
                shared.show(cases, rows, columns)
