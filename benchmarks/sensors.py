"""Cost of sensors: time that they add to a closed-loop step of CAROCA, in pinvs of a 6x8 matrix, by kind of sensor.

Differences of minima over many short chunks in one process, with runs of all kinds in turn; for a row of a rollout of
eight cases, of minima of the processor time of a long and a short one.
"""

from __future__ import annotations

import json
import sys
import time
from typing import Any

import numpy as np
from catenary import pinv_cost
from step import SCENARIOS, add_steps

import cdpr
from cdpr.scenario import load_scenario

RUNS = 12
ROLLOUTS, CASES = 3, 8
SHORT, LONG = 1.0, 13.0  # s, durations of rollouts with 1000 steps per second
NOISE: dict[str, Any] = {"noise": 1e-4}
POSE = {"type": "pose", "position": NOISE, "attitude": NOISE}
TWIST = {"type": "twist", "velocity": NOISE, "turn_rate": NOISE}
SENSORS: dict[str, list[dict[str, Any]]] = {
    "none": [],
    "pose and twist without errors": [{"type": "pose"}, {"type": "twist"}],  # with the second wrench matrix
    "pose and twist": [POSE, TWIST],
    "second pose, recorded only": [POSE, TWIST, {**POSE, "name": "other"}],
    "encoders": [{"type": "encoders", "length": NOISE}],
    "tension": [{"type": "tension", "tension": NOISE}],
    "imu": [{"type": "imu", "force": NOISE, "turn_rate": NOISE}],
    "receiver": [{"type": "receiver", "position": NOISE}],
}


def measure() -> dict[str, float]:
    """Return the time of a step without sensors, and what each kind of sensors adds, pinvs."""
    steps: dict[str, list[float]] = {name: [] for name in SENSORS}
    matrix, pinvs = np.random.default_rng(0).normal(size=(6, 8)), []
    for _ in range(RUNS):
        for name, sensors in SENSORS.items():
            scenario = load_scenario(SCENARIOS / "caroca.yaml", overrides={"sensors": sensors})
            add_steps(scenario, steps[name], lambda: pinvs.append(pinv_cost(matrix)))
    least = {name: min(each) / min(pinvs) for name, each in steps.items()}
    plain = least.pop("none")
    return {"a step without sensors": plain} | {name: cost - plain for name, cost in least.items()}


def measure_rollouts() -> dict[str, float]:
    """Return the time of a row of a rollout without sensors, and what each kind of sensors adds, pinvs."""
    spent: dict[tuple[str, float], float] = {}
    matrix, pinvs = np.random.default_rng(0).normal(size=(6, 8)), []
    for _ in range(ROLLOUTS):
        pinvs.append(pinv_cost(matrix))
        for name, sensors in SENSORS.items():
            for duration in (SHORT, LONG):
                overrides = {"simulation.duration": duration, "sensors": sensors}
                seeds, start = {"simulation.seed": list(range(CASES))}, time.process_time()
                cdpr.rollout("caroca", CASES, vary=seeds, overrides=overrides, columns=["position"], threads=1)
                took = time.process_time() - start
                spent[name, duration] = min(took, spent.get((name, duration), took))
    rows = 1000.0 * CASES * (LONG - SHORT)
    least = {name: (spent[name, LONG] - spent[name, SHORT]) / rows / min(pinvs) for name in SENSORS}
    plain = least.pop("none")
    return {"a row of a rollout without sensors": plain} | {
        f"{name}, in a rollout": cost - plain for name, cost in least.items()
    }


if __name__ == "__main__":
    found = measure() | measure_rollouts()
    if "--json" in sys.argv:
        print(json.dumps(found, indent=2))
    for name, cost in found.items() if "--json" not in sys.argv else ():
        print(f"{name}: {cost:.3f} pinv")
