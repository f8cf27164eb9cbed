"""Cost of friction on the pulleys of CoGiRo: a step with it, per step of frictionless pulleys, by backend and model.

Ratio of minima over many short chunks in one process, with runs of both kinds in turn.
"""

from __future__ import annotations

import json
import sys
from time import thread_time

import numpy as np
from step import SCENARIOS

from cdpr.scenario import load_scenario
from cdpr.simulation.build import build
from cdpr.simulation.loop import Loop

BACKENDS, RUNS = ("reference", "mujoco"), 8
STEEL = {"robot.cable.axial_stiffness": 1e6, "robot.cable.damping": 500.0}
WINCH = {"robot.winch": {"drum_radius": 0.05, "inertia": 0.02}}
MODELS = {
    "ideal": {},
    "rigid": {"robot.cable.model": "rigid", **WINCH},
    "elastic": {"robot.cable.model": "elastic", **STEEL, **WINCH},
}
GROOVE = {"robot.cable.exit.friction": 0.05}
BEARING = {"robot.cable.exit.bearing_friction": 0.1, "robot.cable.exit.bearing_radius": 0.01}
FRICTION = {"groove": GROOVE, "bearing": BEARING}
LIMIT = 1.5


def add_steps(backend: str, changes: dict[str, object], steps: list[float]) -> None:
    """Run once and append the processor time of a step in each chunk, s."""
    scenario = load_scenario(SCENARIOS / "cogiro_pulleys.yaml", backend=backend, overrides=changes)
    loop = Loop(build(scenario))
    loop.warm_up(scenario.initial.state())
    done, since = 0, thread_time()

    def chunk(k: int) -> None:
        nonlocal done, since
        steps.append((thread_time() - since) / (k - done))
        done, since = k, thread_time()

    loop.run(np.empty((scenario.simulation.steps + 1, len(loop.row))), chunk)


def measure() -> dict[str, dict[str, dict[str, float]]]:
    """Return the time of a frictionless step, us, and the ratios with friction, by backend and cable model."""
    found: dict[str, dict[str, dict[str, float]]] = {}
    for backend in BACKENDS:
        for model, changes in MODELS.items():
            kinds = {"none": {}, **FRICTION}
            steps: dict[str, list[float]] = {name: [] for name in kinds}
            for _ in range(RUNS):
                for name, friction in kinds.items():
                    add_steps(backend, {**changes, **friction}, steps[name])
            least = {name: min(each) for name, each in steps.items()}
            ratios = {name: least[name] / least["none"] for name in FRICTION}
            found.setdefault(backend, {})[model] = {"frictionless_us": 1e6 * least["none"], **ratios}
    return found


if __name__ == "__main__":
    found = measure()
    if "--json" in sys.argv:
        print(json.dumps(found, indent=2))
    for backend, models in found.items() if "--json" not in sys.argv else ():
        for model, costs in models.items():
            ratios = ", ".join(f"{name} friction {costs[name]:.2f}" for name in FRICTION)
            print(f"{backend}, {model}: {costs['frictionless_us']:.2f} us a step without friction; ratios: {ratios}")
    if "--gate" in sys.argv:
        worst = max(costs[name] for models in found.values() for costs in models.values() for name in FRICTION)
        sys.exit(worst > LIMIT)
