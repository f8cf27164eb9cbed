"""Interrupts while samples are counted: what is counted again afterwards is counted once."""

from __future__ import annotations

import sys
from types import FrameType
from typing import Any

import pytest
from log_cases import make_header, make_rows, same_bits

from cdpr.log import summary as summary_module
from cdpr.log.summary import Accumulator
from cdpr.mechanics import reach as reach_module

SUMMED = 16  # in place of thousands
FIRST, STOP = SUMMED - 5, SUMMED + 3  # a piece that completes one block of squares and begins the next
BOUNDED = {"bounds": ((0.1,) * 4, (5.0,) * 4, (0.5,) * 4)}
FILES = (summary_module.__file__, reach_module.__file__)


def interrupted(tally: Accumulator, rows: Any, after: int) -> bool:
    """Count rows, with an interrupt at the line number `after` of those that do it; False where there are fewer."""
    left = after

    def trace(frame: FrameType, event: str, _: object) -> Any:
        nonlocal left
        if frame.f_code.co_filename not in FILES:  # a kernel is not interrupted
            return None
        if event == "line":
            left -= 1
            if left < 0:
                raise KeyboardInterrupt
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        tally.add(rows)
    except KeyboardInterrupt:
        return True
    finally:
        sys.settrace(before)
    return False


@pytest.mark.slow
@pytest.mark.parametrize("more", [0, 20])  # samples that came until the rest is counted
def test_interrupted_cases_are_counted_once(more: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(summary_module, "SUMMED", SUMMED)
    header = make_header(4, **BOUNDED)
    rows = make_rows(header, STOP + more)
    whole = Accumulator(header, len(rows))
    whole.add(rows)
    assert max(whole.figures()["beyond_limits_steps"].values()) > 0
    after = 0
    while True:
        tally = Accumulator(header, len(rows))
        tally.add(rows[:FIRST])
        cut = interrupted(tally, rows[FIRST:STOP], after)
        tally.add(rows[tally.count :])
        assert tally.figures() == whole.figures(), f"an interrupt at line event {after}"
        assert tally.beyond.exceeded() == whole.beyond.exceeded()
        assert same_bits(tally.status, whole.status)
        if not cut:
            break
        after += 1
    assert after > 50
