"""Distribute the platform's weight at several heights with several solvers, and print the smallest tension of each."""

import numpy as np

import cdpr

robot = cdpr.load_robot("caroca")
heights = np.linspace(0.8, 1.6, 5)  # m
poses = np.tile([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], (len(heights), 1))
poses[:, 2] = heights
print("height [m]: " + "  ".join(f"{height:6.2f}" for height in heights))
for solver in ("qp", "lp", "centroid"):
    found = cdpr.distribute(robot, poses, solver=solver)
    assert found.feasible.all()
    print(f"{solver:>11}: " + "  ".join(f"{tension:6.1f}" for tension in found.tension.min(axis=1)) + "  N")
