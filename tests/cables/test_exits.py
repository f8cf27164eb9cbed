"""Requirements on all exits of cables."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cdpr.cables import EXITS, Exit, Point, exits_of, read_exits
from cdpr.cables.tables import exits

WITH_HEADER = [kind for kind in EXITS.values() if kind.header]
EXAMPLES = {"pulley": {"radius": 0.1, "axis": (0.3, -0.2, 0.9)}}  # options of each exit that has any


def name_of(kind: type[Exit]) -> str:
    return kind.kind()


def example(kind: type[Exit]) -> Exit:
    return kind(type=kind.kind(), **EXAMPLES[kind.kind()])


def rows(kind: type[Exit], count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows as of `line_table`, with anchors on the platform in the world, and their velocities."""
    rng, own = np.random.default_rng(1), [list(EXITS).index(kind.kind()), *example(kind).numbers()]
    table = np.column_stack([rng.uniform(-3, 3, (count, 6)), np.tile(own, (count, 1))])
    return table, rng.uniform(-5, 5, (count, 3)), rng.normal(size=(count, 3))


@pytest.mark.parametrize("kind", WITH_HEADER, ids=name_of)
def test_the_length_changes_along_the_cable(kind):
    """The velocity of the exit point is its derivative; other results depend on it."""
    step, (table, tips, velocities) = 1e-5, rows(kind, 50)

    def whole(at):
        point, _, wrapped = exits(table, at)
        return np.linalg.norm(point - at, axis=1) + wrapped

    point, moving, _ = exits(table, tips, velocities)
    slope = (whole(tips + step * velocities) - whole(tips - step * velocities)) / (2.0 * step)
    along = np.sum((tips - point) * velocities, axis=1) / np.linalg.norm(tips - point, axis=1)
    np.testing.assert_allclose(slope, along, atol=1e-8)
    ahead, behind = (exits(table, tips + side * step * velocities)[0] for side in (1.0, -1.0))
    np.testing.assert_allclose(moving, (ahead - behind) / (2.0 * step), atol=1e-7)


@pytest.mark.parametrize("kind", EXITS.values(), ids=name_of)
def test_the_layout_follows_the_log(kind, offset_robot):
    each = Point(type="point") if kind is Point else example(kind)
    cables = tuple(replace(cable, exit=each) for cable in offset_robot.cables)
    robot = replace(offset_robot, cables=cables)
    assert read_exits(exits_of(robot)) == ([] if kind is Point else [each] * robot.m)
    assert np.shape(each.outline([0, 0, 1], [0.1, 0, 1])) in ((0,), (33, 3))
