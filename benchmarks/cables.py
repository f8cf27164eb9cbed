"""Cost of a closed-loop step and of an infeasible sample over the number of cables, in pinvs of a 6x8 matrix."""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import thread_time

import numpy as np
import yaml
from step import SCENARIOS, pinv_cost

from cdpr.scenario import load_scenario
from cdpr.simulation.build import build
from cdpr.simulation.loop import Loop

CABLES = (8, 12, 32, 64, 100, 200)
CHUNKS = 60
BEYOND = 1000.0  # times the wanted wrench: more than the cables can exert


def cable(k: int, m: int) -> dict[str, list[float]]:
    """Cable k of m: anchors on a circle of 4 m, in turn on the floor and at 3.5 m."""
    frame, body = 2.0 * np.pi * k / m, 2.0 * np.pi * (3 * k % m) / m + 0.3
    height, level = 3.5 if k % 2 else 0.0, -0.2 if k % 4 < 2 else 0.2
    return {
        "frame": [float(4.0 * np.cos(frame)), float(4.0 * np.sin(frame)), height],
        "platform": [float(0.6 * np.cos(body)), float(0.3 * np.sin(body)), level],
    }


def make_loop(m: int, folder: Path) -> Loop:
    """A closed loop of a robot with m cables, at its first sample."""
    data = yaml.safe_load((SCENARIOS / "caroca.yaml").read_text())
    robot = yaml.safe_load((SCENARIOS / "robots" / "caroca.yaml").read_text())
    robot |= {"cables": [cable(k, m) for k in range(m)], "tension": {"min": 50, "max": 1500}}
    file = folder / f"{m}.yaml"
    file.write_text(yaml.safe_dump(data | {"robot": robot}))
    scenario = load_scenario(file)
    loop = Loop(build(scenario))
    loop.warm_up(scenario.initial.state())
    loop.run(np.empty((2, len(loop.row))), lambda _: None)
    return loop


def ratio(call: Callable[[], object], calls: int, matrix: np.ndarray) -> float:
    """Least processor time of a call, in least pinvs, over chunks in turn."""
    call()
    best, pinv = np.inf, np.inf
    for _ in range(CHUNKS):
        started = thread_time()
        for _ in range(calls):
            call()
        best = min(best, (thread_time() - started) / calls)
        pinv = min(pinv, pinv_cost(matrix))
    return best / pinv


def measure(cables: tuple[int, ...] = CABLES) -> dict[str, dict[str, float]]:
    """By the number of cables: pinvs of a step and of an infeasible distribution, with the nearest wrench."""
    matrix, found = np.random.default_rng(0).normal(size=(6, 8)), {}
    with tempfile.TemporaryDirectory() as folder:
        for m in cables:
            loop = make_loop(m, Path(folder))
            rows, calls = np.empty((21, len(loop.row))), max(1, 200 // m)
            step = ratio(lambda loop=loop, rows=rows: loop.run(rows, lambda _: None), calls, matrix) / (len(rows) - 1)
            far = BEYOND * loop.wrench

            def infeasible(loop: Loop = loop, far: np.ndarray = far) -> None:
                loop.wrench[:] = far
                loop.stage.distribute()

            found[str(m)] = {"step": step, "infeasible": ratio(infeasible, 4 * calls, matrix)}
    return found


def gate(limit: float) -> None:
    """Fail where many cables cost more than `limit` times what a dozen do."""
    few, many = measure((12, 100)).values()
    ratios = {what: many[what] / few[what] for what in few}
    print(
        *(f"100 cables, {what}: {ratio:.1f} times 12 cables, at most {limit:g}" for what, ratio in ratios.items()),
        sep="\n",
    )
    sys.exit(any(ratio > limit for ratio in ratios.values()))


if __name__ == "__main__":
    if "--gate" in sys.argv:
        gate(float(sys.argv[sys.argv.index("--gate") + 1]))
    result = measure()
    if "--json" in sys.argv:
        print(json.dumps(result, indent=2))
    else:
        for m, figures in result.items():
            print(f"{m:>4} cables: {figures['step']:.2f} pinv a step, {figures['infeasible']:.2f} an infeasible sample")
