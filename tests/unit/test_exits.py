"""What every exit of a cable must do, whatever it is."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest

from cdpr.cables import EXITS, Exit, Point, exits_of, read_exits
from cdpr.cables.lines import NUMBERS

KERNELS = [kind for kind in EXITS if kind.kernels]
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


@pytest.mark.parametrize("kind", EXITS, ids=name_of)
def test_it_goes_through_a_log_and_says_what_to_draw(kind, offset_robot):
    each = Point(type="point") if kind is Point else example(kind)
    cables = tuple(replace(cable, exit=each) for cable in offset_robot.cables)
    robot = replace(offset_robot, cables=cables)
    assert read_exits(exits_of(robot)) == ([] if kind is Point else [each] * robot.m)
    assert np.shape(each.outline([0, 0, 1], [0.1, 0, 1])) in ((0,), (33, 3))
