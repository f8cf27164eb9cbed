"""Step a simulation, branch from a snapshot, push the platform in one branch, and compare the end positions."""

import numpy as np

import cdpr

with cdpr.Simulation("caroca", overrides={"simulation.duration": 2.0}) as simulation:
    simulation.until(0.5)
    moment = simulation.snapshot()
    simulation.until(1.0)
    free = simulation.state[:3]  # (3,) m, world
    simulation.restore(moment)
    simulation.push(force=[100.0, 0.0, 0.0], duration=0.2)  # N, world
    simulation.until(1.0)
    pushed = simulation.state[:3]
print(f"the push moves the platform by {1000.0 * np.linalg.norm(pushed - free):.2f} mm")
