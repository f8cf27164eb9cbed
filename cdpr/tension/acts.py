"""What is done in each step of the loop, one thing after the other."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from cdpr.errors import Infeasible


class Act(NamedTuple):
    """One thing that is done in each step; by compiled code where it is a bound operation.

    That is what `cdpr.native.bind.bind` returns, or a `cdpr.native.foreign.Foreign`.
    """

    name: str  # of the part whose work it is
    do: Callable[..., object]
    refused: Callable[[Any], object] | None = None  # called with what it returned, where that is not 0
    skip: int = 0  # so many of the acts that follow are left out then
    # Called before `refused`, with a float: 0 where no more is to be done about it. By compiled code, as `do`.
    mend: Callable[[float], int] | None = None
    timed: bool = False  # whether it takes the time, s
    when: Callable[[], bool] | None = None  # whether it is done at all: may change where something happens
    due: bool = False  # whether it is done only where something happens
    telling: bool = False  # done also where an act before it raised Infeasible: it tells of that sample

    @property
    def plain(self) -> bool:
        """Whether it is done always."""
        return self.when is None and not self.due and self.name != ""

    def __call__(self, time: float) -> int:
        """Do it; return how many acts to leave out."""
        if self.when is not None and not self.when():
            return 0
        return self.meet(self.do(time) if self.timed else self.do())

    def meet(self, code: object) -> int:
        """Do what is to be done about what it returned; return how many acts to leave out."""
        if self.refused is None or not code:
            return 0
        if self.mend is None or self.mend(code):  # type: ignore[arg-type]
            self.refused(code)
        return self.skip


def perform(acts: Sequence[Act], time: float = 0.0) -> None:
    """Do acts one after the other; after Infeasible those that tell of the sample, too."""
    i = 0
    while i < len(acts):
        try:
            i += 1 + acts[i](time)
        except Infeasible:
            tell(acts[i + 1 :], time)
            raise


def tell(acts: Sequence[Act], time: float) -> None:
    """Do those of the acts that tell of a sample without tensions."""
    for act in acts:
        if act.telling:
            act(time)
