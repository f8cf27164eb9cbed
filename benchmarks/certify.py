"""Decided share of certified static workspaces, and the time, on all cores."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from time import perf_counter

import cdpr
from cdpr.analysis.workspace import region, workspace

ROBOTS = Path(__file__).parent.parent / "scenarios" / "robots"
WANTED = {"cogiro": 0.01, "caroca": 0.03}  # share that may stay undecided


def measure() -> dict[str, dict[str, float]]:
    """All figures, by robot."""
    found = {}
    for name, undecided in WANTED.items():
        robot = cdpr.load_robot(ROBOTS / f"{name}.yaml")
        place = region(robot, cells=4)
        workspace(robot, "static", place, method="certify", undecided=0.9)  # kernels are there
        load, start = os.getloadavg()[0], perf_counter()
        made = workspace(robot, "static", place, method="certify", undecided=undecided)
        assert made.proofs is not None
        seconds, shares = perf_counter() - start, made.proofs.shares()
        found[name] = {"seconds": seconds, "load": load, "boxes": made.proofs.evaluated, **shares}
    return found


def main() -> None:
    found = measure()
    if "--json" in sys.argv:
        print(json.dumps(found, indent=2))
        return
    for name, told in found.items():
        shares = ", ".join(f"{100 * told[key]:.2f} % {key.replace('_', ' ')}" for key in list(told)[3:])
        print(f"{name}: {shares} in {told['seconds']:.1f} s, {told['boxes']} boxes (load before {told['load']:.2f})")


if __name__ == "__main__":
    main()
