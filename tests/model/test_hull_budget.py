"""Bounds on the time of convex hulls, and the depth of dents."""

from __future__ import annotations

import numpy as np
import pytest

from cdpr.base.files import UnreadableError
from cdpr.model.hull import convex_hull, deepest
from cdpr.scenario import mesh

CUBE = np.array([(x, y, z) for x in (0.0, 2.0) for y in (0.0, 2.0) for z in (0.0, 2.0)])


def test_a_hull_checks_its_budget_at_each_corner():
    calls = []
    convex_hull(CUBE, lambda: calls.append(None))
    assert len(calls) == 4  # beside those of the first tetrahedron


def test_a_hull_that_takes_too_long_is_given_up(tmp_path, monkeypatch):
    path = tmp_path / "cube.obj"
    path.write_text("".join(f"v {x} {y} {z}\n" for x, y, z in CUBE.tolist()))
    times = iter(range(0, 1000, 4))
    monkeypatch.setattr("cdpr.base.files.time.thread_time", lambda: float(next(times)))
    with pytest.raises(UnreadableError, match=r"cube\.obj': reading it takes more than 10 s of CPU time"):
        mesh.hull_of(str(path))


@pytest.mark.parametrize("copies", [1, 5000])  # in one piece, and in several
def test_the_deepest_corner_of_a_mesh(copies):
    inner = np.array([[0.3, 1.0, 1.0], [1.0, 1.5, 1.0], [1.0, 1.0, 1.9]])
    points = np.vstack([np.tile(CUBE, (copies, 1)), inner])
    assert deepest(points, *convex_hull(points)) == pytest.approx(0.5, abs=1e-12)
    assert deepest(CUBE, *convex_hull(CUBE)) == pytest.approx(0.0, abs=1e-12)
