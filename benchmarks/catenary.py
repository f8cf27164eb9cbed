"""Cost of a closed-loop step of CAROCA by cable model, in pinvs of a 6x8 matrix: least of many short chunks."""

from __future__ import annotations

import json
import sys
from time import thread_time

import numpy as np
from step import SCENARIOS, add_steps

from cdpr.scenario import load_scenario

MODELS = ("ideal", "rigid", "elastic", "catenary")
DENSITY = 0.1  # kg/m
RUNS, PINVS = 5, 20
LIMITS = {"reference": 0.35, "mujoco": 0.25}  # pinvs a step with eight catenaries


def pinv_cost(matrix: np.ndarray) -> float:
    """Return the processor time of a pinv, s."""
    started = thread_time()
    for _ in range(PINVS):
        np.linalg.pinv(matrix)
    return (thread_time() - started) / PINVS


def step(backend: str, model: str) -> float:
    """Return the cost of a step, in pinvs."""
    changes = {"robot.cable.model": model, "robot.cable.linear_density": DENSITY}
    scenario = load_scenario(SCENARIOS / "winch.yaml", backend=backend, overrides=changes)
    matrix, steps, pinvs = np.random.default_rng(0).normal(size=(6, 8)), [], []
    for _ in range(RUNS):
        add_steps(scenario, steps, lambda: pinvs.append(pinv_cost(matrix)))
    return min(steps) / min(pinvs)


def measure() -> dict[str, dict[str, float]]:
    """Return the cost of a step by backend and cable model."""
    return {backend: {model: step(backend, model) for model in MODELS} for backend in LIMITS}


if __name__ == "__main__":
    found = measure()
    if "--json" in sys.argv:
        print(json.dumps(found, indent=2))
    for backend, costs in found.items() if "--json" not in sys.argv else ():
        print(f"{backend}: " + ", ".join(f"{model} {cost:.3f}" for model, cost in costs.items()) + " pinv a step")
    if "--gate" in sys.argv:
        sys.exit(any(found[backend]["catenary"] > limit for backend, limit in LIMITS.items()))
