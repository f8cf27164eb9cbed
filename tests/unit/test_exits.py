"""What every exit of a cable must do, whatever it is; and the C of those that have one, to the bit."""

from __future__ import annotations

import ctypes
import shutil
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from cdpr.cables import EXITS, Exit, Point, exits_of, in_c, read_exits
from cdpr.cables.lines import NUMBERS
from cdpr.fmu.export.library import library, sources

KERNELS = [kind for kind in EXITS if kind.kernels]
FOLDER = Path(import_module("cdpr.cables").__file__).parent
EXAMPLES = {"pulley": {"radius": 0.1, "axis": (0.3, -0.2, 0.9)}}  # options of each exit that has any


def name_of(kind: type[Exit]) -> str:
    return kind.kind()


def example(kind: type[Exit]) -> Exit:
    return kind(type=kind.kind(), **EXAMPLES[kind.kind()])


def rows(kind: type[Exit], count: int) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Rows as the kernels take them, with anchors on the platform, and their velocities."""
    rng, numbers = np.random.default_rng(1), example(kind).numbers()
    return [
        (np.concatenate([rng.uniform(-3, 3, 6), np.zeros(NUMBERS - 6), numbers]), P, rng.normal(size=3))
        for P in rng.uniform(-5, 5, (count, 3))
    ]


@pytest.mark.parametrize("kind", KERNELS, ids=name_of)
def test_the_length_changes_along_the_cable(kind):
    """Which all that follows from the exit point alone rests on; and the point's velocity is its derivative."""
    kernels, step = import_module(kind.kernels), 1e-5

    def whole(row, P):
        return np.linalg.norm(np.subtract(kernels.leave(row, tuple(P)), P)) + kernels.lead(row, tuple(P))[3]

    for row, P, V in rows(kind, 50):
        E = np.array(kernels.leave(row, tuple(P)))
        slope = (whole(row, P + step * V) - whole(row, P - step * V)) / (2.0 * step)
        assert slope == pytest.approx((P - E) @ V / np.linalg.norm(P - E), abs=1e-8)
        ahead, behind = (np.array(kernels.leave(row, tuple(P + side * step * V))) for side in (1.0, -1.0))
        np.testing.assert_allclose(kernels.carry(row, tuple(P), tuple(V)), (ahead - behind) / (2.0 * step), atol=1e-7)


class Vector(ctypes.Structure):
    _fields_ = [("x", ctypes.c_double), ("y", ctypes.c_double), ("z", ctypes.c_double)]


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
@pytest.mark.parametrize("kind", in_c(), ids=name_of)
def test_the_c_of_a_part_is_its_kernels_to_the_bit(kind, tmp_path):
    files = {name: text for name, text in sources().items() if name in ("exits.h", "vector.h", kind.source().name)}
    (tmp_path / "part.so").write_bytes(library(files, ("-std=c99", "-O2", "-fPIC", "-shared", "-ffp-contract=off")))
    part, kernels = ctypes.CDLL(str(tmp_path / "part.so")), import_module(kind.kernels)
    row_type, wound_type = ctypes.POINTER(ctypes.c_double), ctypes.POINTER(ctypes.c_double)
    leave, carry = getattr(part, f"{kind.kind()}_leave"), getattr(part, f"{kind.kind()}_carry")
    leave.argtypes, leave.restype = [row_type, Vector, wound_type], Vector
    carry.argtypes, carry.restype = [row_type, Vector, Vector], Vector
    for row, P, V in rows(kind, 300):
        own = np.concatenate([row[:3], row[NUMBERS:]])  # the C has no place for what it does not need
        given, wound = own.ctypes.data_as(row_type), ctypes.c_double()
        there = leave(given, Vector(*P), wound)
        assert (there.x, there.y, there.z, wound.value) == kernels.lead(row, tuple(P))
        assert (there.x, there.y, there.z) == kernels.leave(row, tuple(P))
        there = carry(given, Vector(*P), Vector(*V))
        assert (there.x, there.y, there.z) == kernels.carry(row, tuple(P), tuple(V))


@pytest.mark.parametrize("kind", EXITS, ids=name_of)
def test_it_goes_through_a_log_and_says_what_to_draw(kind, offset_robot):
    each = Point(type="point") if kind is Point else example(kind)
    cables = tuple(replace(cable, exit=each) for cable in offset_robot.cables)
    robot = replace(offset_robot, cables=cables)
    assert read_exits(exits_of(robot)) == ([] if kind is Point else [each] * robot.m)
    assert np.shape(each.outline([0, 0, 1], [0.1, 0, 1])) in ((0,), (33, 3))


def test_every_part_with_c_stands_beside_it():
    assert {kind.source().name for kind in in_c()} == {path.name for path in FOLDER.rglob("*.c")}
