"""Run a scenario on the reference integrator, and print the tracking error and the largest tension of each cable."""

import numpy as np

import cdpr

run = cdpr.simulate("caroca", overrides={"simulation.duration": 2.0})
error = np.linalg.norm(run.position_error, axis=1)  # (K,) m
print(f"{run.header.scenario}: {len(run.time)} samples, largest position error {1000.0 * error.max():.3f} mm")
for cable, tension in zip(run.header.cables, run.tension.max(axis=0), strict=True):
    print(f"  {cable}: at most {tension:.0f} N")
