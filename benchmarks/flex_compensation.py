"""Cost of flex compensation, us a pose: minima over chunks of poses of robots with eight cables, in one process.

The figure of a robot is the time of one call with many poses divided by their number. The cables of the first robot
stretch, those of the second also sag.
"""

from __future__ import annotations

import json
import sys
from time import perf_counter

import numpy as np
from step import pinv_cost

import cdpr

ROBOTS = ("caroca_winches", "cogiro_servos")
POSES, CHUNKS = 2000, 40
SPREAD = 0.2  # m, of the poses about the home pose in each direction
LIMIT = 2.0  # us a pose, of cables that do not sag


def measure() -> dict[str, dict[str, float]]:
    """Return the time of a pose, us, and in units of one pinv of a 6x8 matrix, by robot."""
    generator, found = np.random.default_rng(0), {}
    matrix = generator.normal(size=(6, 8))
    for name in ROBOTS:
        robot = cdpr.load_robot(name)
        assert robot.home is not None
        poses = np.tile(robot.home, (POSES, 1))
        poses[:, :3] += generator.uniform(-SPREAD, SPREAD, (POSES, 3))
        times, pinvs = [], []
        for _ in range(CHUNKS):
            start = perf_counter()
            cdpr.compensated_lengths(robot, poses)
            times.append(perf_counter() - start)
            pinvs.append(pinv_cost(matrix))
        pose = min(times) / POSES
        found[name] = {"pose_us": 1e6 * pose, "ratio": pose / min(pinvs)}
    return found


if __name__ == "__main__":
    figures = measure()
    if "--json" in sys.argv:
        print(json.dumps(figures, indent=2))
    else:
        for name, each in figures.items():
            print(f"{name}: {each['pose_us']:.2f} us a pose, {each['ratio']:.3f} pinv")
    if "--gate" in sys.argv:
        sys.exit(figures[ROBOTS[0]]["pose_us"] > LIMIT)
