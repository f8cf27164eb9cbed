"""The C of each part of cables that has some is its kernels, to the bit, whatever numbers they are given."""

from __future__ import annotations

import ctypes
import os
import shutil
import struct
from importlib import import_module
from pathlib import Path

import numba
import numpy as np
import pytest
from test_exits import example, rows

import cdpr.fmu.export
from cdpr.cables.chain import MOST, Number, Winch
from cdpr.cables.exit import Exit
from cdpr.cables.lines import NUMBERS
from cdpr.cables.twin import name_in_c, source
from cdpr.errors import CdprError
from cdpr.fields import Positive
from cdpr.fmu.export.library import library, part_sources, sources
from cdpr.fmu.export.parts import exits, spans, winches

pytestmark = pytest.mark.skipif(shutil.which(os.environ.get("CC") or "cc") is None, reason="no C compiler")

PARTS = [*exits(), *winches(), *spans()]
FLAGS = ("-std=c99", "-O2", "-fPIC", "-shared", "-ffp-contract=off", "-Wall", "-Wextra", "-Wshadow", "-Werror")

DOUBLE, ROW = ctypes.c_double, ctypes.POINTER(ctypes.c_double)

# What no robot has, in place of any number: it must come out alike, too. Interpreted kernels divide by no 0.
HOSTILE = [0.0, -0.0, 1.0, -1.0, 5e-324, 1e-160, 1e160, -1e308, np.inf, -np.inf, np.nan]
PLAIN = [1.0, -1.0, 1e-3, 1e3]


class Vector(ctypes.Structure):
    _fields_ = [("x", DOUBLE), ("y", DOUBLE), ("z", DOUBLE)]


class Held(ctypes.Structure):
    _fields_ = [("tension", DOUBLE), ("mass", DOUBLE)]


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """All parts in one library, compiled without a warning."""
    path = tmp_path_factory.mktemp("parts") / "parts.so"
    files = {name: sources()[name] for name in (*part_sources(), "parts.h", "vector.h")}
    path.write_bytes(library(files, FLAGS))
    return ctypes.CDLL(str(path))


def bits(values):
    """All bits, but those that tell one NaN from another."""
    return [b"nan" if np.isnan(value) else struct.pack("d", value) for value in np.ravel(values)]


def function(library, name, result, *arguments):
    found = getattr(library, name)
    found.restype, found.argtypes = result, arguments
    return found


def floats(structure):
    return [getattr(structure, name) for name, _ in structure._fields_]


def given(rng, count):
    """Rows of numbers: sizes that robots have, others over the whole range, and among them hostile ones."""
    hostile = PLAIN if numba.config.DISABLE_JIT else HOSTILE
    size = 3.0 if numba.config.DISABLE_JIT else 150.0
    for k in range(600):
        row = (
            rng.uniform(0.1, 10.0, count) if k % 3 else rng.normal(size=count) * 10.0 ** rng.uniform(-size, size, count)
        )
        if k % 2:
            row[rng.integers(count, size=3)] = np.array(hostile)[rng.integers(len(hostile), size=3)]
        yield row


def exit_pairs(kind, name, kernels, library):
    leave = function(library, f"{name}_leave", Vector, ROW, Vector, ROW)
    carry = function(library, f"{name}_carry", Vector, ROW, Vector, Vector)
    rng = np.random.default_rng(2)
    places = rows(kind, 300)
    if not numba.config.DISABLE_JIT:
        width = len(example(kind).numbers())
        hostile = given(rng, 3 + width + 6)
        places += [(np.concatenate([x[:3], np.zeros(NUMBERS - 3), x[3:-6]]), x[-6:-3], x[-3:]) for x in hostile]
    for row, P, V in places:
        own = np.concatenate([row[:3], row[NUMBERS:]])  # the C has no place for what it does not need
        wound, there = DOUBLE(), own.ctypes.data_as(ROW)
        yield [*floats(leave(there, Vector(*P), wound)), wound.value], kernels.lead(row, tuple(P))
        yield floats(leave(there, Vector(*P), None)), kernels.leave(row, tuple(P))
        yield floats(carry(there, Vector(*P), Vector(*V))), kernels.carry(row, tuple(P), tuple(V))


def winch_pairs(part, name, kernels, library):
    held = function(library, f"{name}_held", Held, ROW, *[DOUBLE] * 3)
    turn = function(library, f"{name}_turn", DOUBLE, ROW, *[DOUBLE] * 3)
    width = max(len(part.numbers), 1)
    for row in given(np.random.default_rng(3), width + 3):
        numbers, more = row[:width].copy(), row[width:].tolist()
        yield floats(held(numbers.ctypes.data_as(ROW), *more)), kernels.held(numbers, *more)
        yield turn(numbers.ctypes.data_as(ROW), *more), kernels.turn(numbers, *more)


def span_pairs(part, name, kernels, library):
    pull = function(library, f"{name}_pull", DOUBLE, ROW, *[DOUBLE] * 4)
    rest = function(library, f"{name}_rest", DOUBLE, ROW, *[DOUBLE] * 2)
    width = max(len(part.numbers), 1)
    for row in given(np.random.default_rng(4), width + 3):
        numbers, more = row[:width].copy(), row[width:].tolist()
        for lowest in (0.0, -np.inf):
            yield pull(numbers.ctypes.data_as(ROW), *more, lowest), kernels.pull(numbers, *more, lowest)
        yield rest(numbers.ctypes.data_as(ROW), *more[:2]), kernels.rest(numbers, *more[:2])


@pytest.mark.parametrize("part", PARTS, ids=lambda part: name_in_c(part.kernels))
@pytest.mark.usual("direct", "drum", "elastic")
def test_the_c_of_a_part_is_its_kernels_to_the_bit(part, compiled):
    if isinstance(part, type) and issubclass(part, Exit):
        pairs = exit_pairs
    else:
        pairs = winch_pairs if isinstance(part, Winch) else span_pairs
    count = 0
    for in_c, in_python in pairs(part, name_in_c(part.kernels), import_module(part.kernels), compiled):
        assert bits(in_c) == bits(in_python)
        count += 1
    assert count >= 900


def test_all_c_beside_parts_is_that_of_a_part():
    folder = Path(import_module("cdpr.cables").__file__).parent
    assert {source(part.kernels) for part in PARTS} == set(folder.rglob("*.c"))


def test_rows_have_the_length_that_c_expects():
    text = (Path(cdpr.fmu.export.__file__).parent / "source" / "parts.h").read_text()
    assert f"PART_NUMBERS = {MOST} " in text
    with pytest.raises(CdprError, match="takes 8 numbers at most, not 9"):
        Winch(numbers=tuple(Number(f"cable.n{i}", Positive, "", "") for i in range(MOST + 1)))


@pytest.mark.parametrize(
    ("name", "unit", "told"),
    [
        ("drum.mass", "kg", "cable.KEY or winch.KEY, not drum.mass"),
        ("cable.sag", "furlong", "the unit furlong is not"),
        ("cable.sag", "mm", "the unit mm is no SI unit"),  # in an FMU it would count as m
    ],
)
def test_numbers_that_no_file_could_hold_are_refused(name, unit, told):
    with pytest.raises(CdprError, match=told):
        Number(name, Positive, unit, "")
