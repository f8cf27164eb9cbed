"""Kernels with their arguments, as compiled code calls them."""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from cdpr.model.address import caller
from cdpr.model.bound import ENTRY, bound
from cdpr.model.jit import kernel
from cdpr.model.robot import Array

if numba.config.DISABLE_JIT:
    pytest.skip("NUMBA_DISABLE_JIT: nothing is compiled", allow_module_level=True)

call_entry = caller(ENTRY)


@kernel
def enter(entry: int, place: int, time: float) -> int:
    return call_entry(entry, place, time)


class Pair(NamedTuple):
    rows: Array
    share: float


class Nest(NamedTuple):
    pair: Pair
    on: bool
    numbers: NDArray[np.int64]


@kernel
def gather(table, vector, block, nest, whole, number, flag, out):
    """Write of each argument what tells it from others."""
    out[0] = table.shape[0] * 1000 + table.shape[1]
    out[1] = table[table.shape[0] - 1, table.shape[1] - 1]
    out[2] = vector[vector.shape[0] - 1]
    out[3] = block[block.shape[0] - 1, 1, 2]
    out[4] = nest.pair.rows[1, 0] + nest.pair.share
    out[5] = nest.numbers[2] if nest.on else -1.0
    out[6] = whole
    out[7] = number
    out[8] = 1.0 if flag else 0.0
    return whole


@pytest.mark.slow
@given(st.integers(1, 5), st.integers(1, 7), st.integers(-(2**40), 2**40), st.floats(), st.booleans())
def test_arguments_of_all_kinds_arrive(m, n, whole, number, flag):
    rng = np.random.default_rng(m * 10 + n)
    nest = Nest(Pair(rng.normal(size=(2, n)), 0.5), flag, np.array([1, 2, 3], dtype=np.int64))
    given_ = rng.normal(size=(m, n)), rng.normal(size=m), rng.normal(size=(n, 2, 3)), nest, whole, number, flag
    direct, entered = np.zeros(9), np.zeros(9)
    assert gather(*given_, direct) == whole
    made = bound(partial(partial(gather, *given_[:3]), *given_[3:], entered))
    assert made is not None
    assert enter(made.operation, made.place, 0.0) == whole
    np.testing.assert_array_equal(entered, direct)


@kernel
def note(out, time):
    out[0] = time


@kernel
def above(value, time):
    return value[0] > time


def test_the_time_comes_last_and_what_returns_nothing_returns_0():
    out = np.zeros(1)
    made = bound(partial(note, out), timed=True)
    assert made is not None
    assert (enter(made.operation, made.place, 2.5), out[0]) == (0, 2.5)
    asked = bound(partial(above, out), timed=True)
    assert asked is not None
    assert [enter(asked.operation, asked.place, time) for time in (2.0, 3.0)] == [1, 0]


def test_kernels_of_one_kind_share_what_calls_them():
    @kernel
    def other(out, time):
        out[0] = -time

    out = np.zeros(1)
    made = [bound(partial(each, out), timed=True) for each in (note, other)]
    assert made[0].operation == made[1].operation
    enter(made[1].operation, made[1].place, 2.0)
    assert out[0] == -2.0


class Loose(NamedTuple):
    names: list


@pytest.mark.parametrize(
    "call",
    [
        lambda: None,
        partial(print, 1),
        partial(note, out=np.zeros(1)),
        partial(note, np.zeros(1, dtype=np.float32)),
        partial(note, np.zeros((2, 2))[:, 0]),
        partial(note, np.zeros(1, dtype=">f8")),
        partial(note, [0.0]),
        partial(note, Loose([])),
        partial(note, "text"),
    ],
    ids=[
        "function",
        "built in",
        "by name",
        "4 bytes",
        "strided",
        "other byte order",
        "list",
        "tuple of a list",
        "text",
    ],
)
def test_what_compiled_code_cannot_take_is_left_to_python(call):
    assert bound(call, timed=True) is None
