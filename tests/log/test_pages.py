"""Tables filled row by row: shape, ownership, and rejection of too large sizes as in numpy."""

import gc

import numpy as np
import pytest

from cdpr.log.pages import HUGE, table


@pytest.mark.parametrize("rows", [0, 1, 4000, HUGE // 80, HUGE // 80 + 1, 100_000])
def test_tables_are_writable_contiguous_and_owned(rows: int) -> None:
    first, second = table(rows, 10), table(rows, 10)
    assert first.shape == (rows, 10)
    assert first.flags.c_contiguous
    assert first.flags.writeable
    first[:], second[:] = 1.0, 2.0
    assert (first == 1.0).all()
    assert (second == 2.0).all()


def test_large_tables_begin_with_a_huge_page() -> None:
    assert table(HUGE, 1).ctypes.data % HUGE == 0


def test_a_table_outlives_what_it_was_made_of() -> None:
    part = table(HUGE, 1)[-5:]
    gc.collect()
    part[:] = np.arange(5.0)[:, None]
    assert part.sum() == 10.0


def test_more_than_there_is_ends_as_with_numpy() -> None:
    with pytest.raises((MemoryError, ValueError)):
        table(2**58, 1)
    with pytest.raises((MemoryError, ValueError)):
        table(2**70, 1)
