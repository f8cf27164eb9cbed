"""Time of a workspace by octree over its time on the grid: least of many rounds, one process, all cores."""

from __future__ import annotations

from pathlib import Path
from time import perf_counter

import cdpr
from cdpr.analysis.workspace import box, region

ROBOTS = Path(__file__).parent.parent / "scenarios" / "robots"
NAMES = ("cogiro", "caroca", "ipanema_1")
CELLS = 160  # along the longest side
HALF = [50.0, 50.0, 50.0, 5.0, 5.0, 5.0]  # N, N m
ROUNDS = 12


def measured(name: str) -> dict[str, float]:
    """Return the least times of both methods, s."""
    robot = cdpr.load_robot(ROBOTS / f"{name}.yaml")
    place, required = region(robot, cells=CELLS), box(HALF)
    least = {"grid": float("inf"), "octree": float("inf")}
    for _ in range(ROUNDS):
        for method in least:
            start = perf_counter()
            cdpr.workspace(robot, "wrench-feasible", region=place, required=required, method=method)
            least[method] = min(least[method], perf_counter() - start)
    return least


if __name__ == "__main__":
    for name in NAMES:
        times = measured(name)
        ratio = times["octree"] / times["grid"]
        print(f"{name:<12} grid {times['grid']:.3f} s, octree {times['octree']:.3f} s, ratio {ratio:.3f}")
