"""Build a robot and a scenario in Python, save the scenario as YAML, and print the tracking error of two runs."""

import tempfile
from pathlib import Path

import numpy as np

import cdpr

corners = [[x, y, 3.0] for x, y in ((-2, -1.5), (2, -1.5), (-2, 1.5), (2, 1.5))]  # m, world
frame = np.repeat(corners, 2, axis=0)  # two cables from each corner
signs = [[1, -1, -1], [-1, 1, 1], [-1, -1, 1], [1, 1, -1], [-1, -1, -1], [1, 1, 1], [1, -1, 1], [-1, 1, -1]]
points = np.array(signs) * [0.3, 0.15, 0.1]  # m, platform axes
limits = {"tension_min": 10.0, "tension_max": 800.0}  # N
robot = cdpr.Robot.from_points(frame, points, mass=20.0, home=[0.0, 0.0, 1.2], name="portal", **limits)
scenario = cdpr.Scenario(
    name="pushed",
    robot=robot,
    simulation={"duration": 2.0},
    trajectory=cdpr.motions.Quintic(duration=1.5, to=cdpr.motions.Knot(position=(0.4, 0.2, 1.4))),
    events=[cdpr.events.Wrench(time=0.5, duration=0.2, force=(30.0, 0.0, 0.0))],
)
heavier = scenario.replace(robot=robot.replace(platform=robot.platform.replace(mass=30.0)))
for each in (scenario, heavier):
    run = cdpr.simulate(each)
    error = 1000.0 * np.linalg.norm(run.position_error, axis=1).max()
    print(f"{each.robot.platform.mass:.0f} kg: {run.status}, largest position error {error:.1f} mm")

with tempfile.TemporaryDirectory() as folder:
    file = Path(folder, "pushed.yaml")
    scenario.save(file)
    assert cdpr.load_scenario(file) == scenario
    print(f"{file.name}: {len(file.read_text().splitlines())} lines, loads to an equal scenario")
