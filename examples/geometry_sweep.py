"""Vary the height of a platform, and print the static workspace and the largest capacity margin of each robot."""

import numpy as np

import cdpr

frame = np.repeat([[-2, -1.5, 3], [2, -1.5, 3], [-2, 1.5, 3], [2, 1.5, 3]], 2, axis=0)  # m, world
signs = [[1, -1, -1], [-1, 1, 1], [-1, -1, 1], [1, 1, -1], [-1, -1, -1], [1, 1, 1], [1, -1, 1], [-1, 1, -1]]
for height in np.linspace(0.1, 0.5, 5):  # m
    points = 0.5 * np.array(signs) * [0.6, 0.3, height]  # m, platform axes
    robot = cdpr.Robot.from_points(frame, points, mass=20.0, tension_min=10.0, tension_max=800.0)
    found = cdpr.workspace(robot, "static", cells=16)
    print(f"{height:.1f} m: {found.volume:5.1f} m^3, largest margin {np.nanmax(found.value):5.1f} N")
