"""Cost of pulleys: a whole step of the loop on caroca, and its cable geometry alone, relative to points."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from time import perf_counter

import numpy as np

from cdpr.cables.tables import line_table
from cdpr.native.bind import bind
from cdpr.scenario import load_scenario
from cdpr.simulation.build import build
from cdpr.simulation.loop import Loop

SCENARIO = Path(__file__).parent.parent / "scenarios" / "caroca.yaml"
PULLEY = {"robot.cable.exit.type": "pulley", "robot.cable.exit.radius": 0.05}
CHUNKS, CALLS = 400, 200


def least(works: list[Callable[[], object]]) -> list[float]:
    """Shortest chunk of each, s."""
    best = [np.inf] * len(works)
    for _ in range(CHUNKS):
        for k, work in enumerate(works):
            start = perf_counter()
            work()
            best[k] = min(best[k], perf_counter() - start)
    return best


def main() -> None:
    geometries, steps = [], []
    for overrides in ({}, PULLEY):
        scenario = load_scenario(SCENARIO, overrides=overrides)
        loop = Loop(build(scenario))
        loop.warm_up(scenario.initial.state())
        state, m = scenario.initial.state(), scenario.robot.m
        written = {"matrix": np.zeros((6, m)), "length": np.zeros(m), "rate": np.zeros(m)}
        call = bind("geometry", lines=line_table(scenario.robot), state=state, **written)
        geometries.append(lambda call=call: [call() for _ in range(CALLS)])
        rows = np.empty((CALLS + 1, len(loop.row)))

        def run(loop: Loop = loop, start: np.ndarray = state, rows: np.ndarray = rows) -> None:
            loop.parts.backend.reset(start)
            loop.run(rows, lambda _: None)

        steps.append(run)
    for name, works in (("cable geometry", geometries), ("step, in memory", steps)):
        point, pulley = least(works)
        print(f"{name}: {pulley / point:.2f} times that of points ({point / CALLS * 1e6:.2f} us)")


if __name__ == "__main__":
    main()
