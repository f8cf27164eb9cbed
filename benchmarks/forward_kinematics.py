"""Cost of forward kinematics, in units of one numpy.linalg.pinv of a 6x8 matrix in the same process."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from statistics import median
from time import perf_counter

import numpy as np
from step import pinv_cost

from cdpr.mechanics import kinematics
from cdpr.mechanics.forward_kinematics import forward_kinematics
from cdpr.scenario import load_scenario
from cdpr.simulation.build import build

SCENARIO = Path(__file__).parent.parent / "scenarios" / "caroca.yaml"
CHUNK = 50


def measure() -> dict[str, float]:
    """Medians over interleaved chunks: a fit and a pinv, s, their ratio, the iterations and the largest error, m."""
    scenario = load_scenario(SCENARIO)
    desired = np.zeros(19)
    sample = build(scenario).trajectory.sampler(desired)
    states = []
    for k in range(3000):
        sample(k * 1e-3)
        states.append(desired[:13].copy())
    robot = scenario.robot
    lengths = [kinematics.lengths(robot, state) for state in states]
    matrix = kinematics.wrench_matrix(robot, states[0])
    pose = states[0][:7]
    forward_kinematics(robot, lengths[0], pose)
    fits, pinvs, iterations, errors = [], [], [], []
    for first in range(0, len(states), CHUNK):
        start = perf_counter()
        for k in range(first, first + CHUNK):
            fit = forward_kinematics(robot, lengths[k], pose)
            pose = fit.pose
        fits.append((perf_counter() - start) / CHUNK)
        pinvs.append(pinv_cost(matrix))
        iterations.append(fit.iterations)
        errors.append(float(np.abs(pose - states[k][:7]).max()))
    cost, pinv = median(fits), median(pinvs)
    return {
        "fit_us": 1e6 * cost,
        "pinv_us": 1e6 * pinv,
        "ratio": cost / pinv,
        "iterations": median(iterations),
        "error": max(errors),
    }


def main() -> None:
    result = measure()
    if "--json" in sys.argv:
        print(json.dumps(result, indent=2))
        return
    print(
        f"{result['ratio']:.2f} pinv a fit ({result['fit_us']:.1f} us against {result['pinv_us']:.1f} us), "
        f"{result['iterations']:.0f} iterations, largest error {result['error']:.1e} m or quaternion unit"
    )


if __name__ == "__main__":
    main()
