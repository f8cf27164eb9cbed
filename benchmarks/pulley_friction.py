"""Cost of friction on the pulleys of CoGiRo: a step with it, per step of frictionless pulleys, by backend and model.

Ratio of minima over many short chunks in one process, with runs of both kinds in turn.
"""

from __future__ import annotations

import json
import sys

from step import SCENARIOS, add_steps

from cdpr.scenario import load_scenario

ROBOT = SCENARIOS / "cogiro_pulleys.yaml"
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


def measure() -> dict[str, dict[str, dict[str, float]]]:
    """Return the time of a frictionless step, us, and the ratios with friction, by backend and cable model."""
    found: dict[str, dict[str, dict[str, float]]] = {}
    for backend in BACKENDS:
        for model, changes in MODELS.items():
            kinds = {"none": {}, **FRICTION}
            steps: dict[str, list[float]] = {name: [] for name in kinds}
            for _ in range(RUNS):
                for name, friction in kinds.items():
                    given = {**changes, **friction}
                    add_steps(load_scenario(ROBOT, backend=backend, overrides=given), steps[name])
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
