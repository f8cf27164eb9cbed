"""Cost of sensors: time that they add to a control step of CAROCA, in pinv, by kind of sensor.

A pinv is the time of numpy's pseudoinverse of a 6 x 8 matrix in the same process. Differences of minima over many short
chunks in one process, with runs of all kinds in turn.
"""

from __future__ import annotations

import json
import sys
from time import thread_time
from typing import Any

import numpy as np
from step import SCENARIOS

from cdpr.scenario import load_scenario
from cdpr.simulation.build import build
from cdpr.simulation.loop import Loop

RUNS = 12
LIMIT = 0.02  # pinv, of a pose sensor, without the second wrench matrix that any seen state needs
NOISE: dict[str, Any] = {"noise": 1e-4}
POSE = {"type": "pose", "position": NOISE, "attitude": NOISE}
TWIST = {"type": "twist", "velocity": NOISE, "turn_rate": NOISE}
SENSORS: dict[str, list[dict[str, Any]]] = {
    "none": [],
    "pose and twist without errors": [{"type": "pose"}, {"type": "twist"}],
    "pose and twist": [POSE, TWIST],
    "encoders": [{"type": "encoders", "length": NOISE}],
    "tension": [{"type": "tension", "tension": NOISE}],
    "imu": [{"type": "imu", "force": NOISE, "turn_rate": NOISE}],
    "receiver": [{"type": "receiver", "position": NOISE}],
}


def add_steps(sensors: list[dict[str, Any]], steps: list[float]) -> None:
    """Run once and append the processor time of a step in each chunk, s."""
    scenario = load_scenario(SCENARIOS / "caroca.yaml", overrides={"sensors": sensors})
    loop = Loop(build(scenario))
    loop.warm_up(scenario.initial.state())
    done, since = 0, thread_time()

    def chunk(k: int) -> None:
        nonlocal done, since
        steps.append((thread_time() - since) / (k - done))
        done, since = k, thread_time()

    loop.run(np.empty((scenario.simulation.steps + 1, len(loop.row))), chunk)


def pinv_time() -> float:
    """Return the least processor time of a pseudoinverse (6 x 8), s."""
    matrix, least = np.random.default_rng(0).normal(size=(6, 8)), np.inf
    for _ in range(200):
        since = thread_time()
        for _ in range(20):
            np.linalg.pinv(matrix)
        least = min(least, (thread_time() - since) / 20)
    return least


def measure() -> dict[str, float]:
    """Return the added time of each kind of sensors, pinv."""
    steps: dict[str, list[float]] = {name: [] for name in SENSORS}
    pinv = np.inf
    for _ in range(RUNS):
        for name, sensors in SENSORS.items():
            add_steps(sensors, steps[name])
        pinv = min(pinv, pinv_time())
    least = {name: min(each) / pinv for name, each in steps.items()}
    return {name: least[name] - least["none"] for name in SENSORS if name != "none"} | {"step": least["none"]}


if __name__ == "__main__":
    found = measure()
    if "--json" in sys.argv:
        print(json.dumps(found, indent=2))
    for name, cost in found.items() if "--json" not in sys.argv else ():
        print(f"{name}: {cost:.3f} pinv")
