"""Operations of a control step, executed in order."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from cdpr.base.errors import Infeasible


class Operation(NamedTuple):
    """Operation of a control step, compiled if it is a bound operation.

    Bound operations are results of `cdpr.native.bind.bind` or `cdpr.native.foreign.Foreign`.
    """

    name: str  # part that it belongs to
    do: Callable[..., object]
    refused: Callable[[Any], object] | None = None  # called with a nonzero return value
    skip: int = 0  # number of following operations to skip then
    # Called before `refused`, with a float; a result of 0 means that it was handled. Compiled like `do`.
    mend: Callable[[float], int] | None = None
    timed: bool = False  # True if it takes the time, s
    when: Callable[[], bool] | None = None  # condition, which may change at events
    due: bool = False  # True if it is executed only at events
    telling: bool = False  # also executed after Infeasible, to report on that sample

    @property
    def unconditional(self) -> bool:
        """True if it is always executed."""
        return self.when is None and not self.due and self.name != ""

    def __call__(self, time: float) -> int:
        """Execute it; return the number of operations to skip."""
        if self.when is not None and not self.when():
            return 0
        return self.meet(self.do(time) if self.timed else self.do())

    def meet(self, code: object) -> int:
        """Handle its return value; return the number of operations to skip."""
        if self.refused is None or not code:
            return 0
        if self.mend is None or self.mend(code):  # type: ignore[arg-type]
            self.refused(code)
        return self.skip


def perform(operations: Sequence[Operation], time: float = 0.0) -> None:
    """Execute operations in order; after Infeasible, also the operations that report on the sample."""
    i = 0
    while i < len(operations):
        try:
            i += 1 + operations[i](time)
        except Infeasible:
            report_failed_sample(operations[i + 1 :], time)
            raise


def report_failed_sample(operations: Sequence[Operation], time: float) -> None:
    """Execute the operations that report on a sample without tensions."""
    for operation in operations:
        if operation.telling:
            operation(time)
