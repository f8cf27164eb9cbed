"""External wrenches and commands of cables for the lanes of a batch, checked before a step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cdpr.analysis.rollouts.case import Case, Given
from cdpr.base.errors import CdprError
from cdpr.model.arrays import checked
from cdpr.scenario.events.commands import Kind
from cdpr.simulation.external_command import check_lengths


def given_command(values: Mapping[Kind, ArrayLike | None], stepped: NDArray[np.bool_], m: int) -> Given | None:
    """Return the kind and values (lanes, 6) or (lanes, m) of the only command that is not None, if any.

    Args:
        values: commands by kind.
        stepped: (lanes,) True for the lanes to step; numbers of others need not be finite.
        m: number of cables.

    Raises:
        CdprError: if there are several, or they are not finite numbers of that shape.
    """
    found = [(kind, given) for kind, given in values.items() if given is not None]
    if not found:
        return None
    if len(found) > 1:
        raise CdprError(f"step: expected {found[0][0]} or {found[1][0]}, not both")
    ((kind, given),) = found
    numbers = checked(given, (len(stepped), 6 if kind == "wrench" else m), kind)
    if not np.isfinite(numbers[stepped]).all():
        raise CdprError(f"{kind}: all numbers of the lanes that are stepped must be finite")
    return kind, numbers


def check_given(cases: Sequence[Case], lanes: Sequence[int], given: Given, steps: int, last: int) -> None:
    """Check a command for some lanes.

    Args:
        cases: all cases.
        lanes: numbers of the lanes, which can be stepped.
        given: kind and values of the command.
        steps: number of steps.
        last: number of the last sample.

    Raises:
        CdprError: if winches do not take it, a length is out of range, or the robot of a lane stops within the steps.
    """
    kind, values = given
    for lane in lanes:
        case = cases[lane]
        outside = case.loop.outside
        if outside.end <= last:
            outside.check_stop(case.count, min(steps, last - case.count), last, f"step: lane {lane}")
        if kind == "wrench":  # all winches take it
            continue
        try:
            check_lengths(kind, values[lane].tolist(), outside.command(kind).cables)
        except CdprError as error:
            raise CdprError(f"step: lane {lane}: {error}") from None


def rows_of(given: Given | None, at: slice | list[int]) -> Given | None:
    """Return the command of some lanes."""
    return None if given is None else (given[0], np.ascontiguousarray(given[1][at]))
