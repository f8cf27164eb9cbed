"""Cost of one closed-loop step, in units of one numpy.linalg.pinv of a 6x8 matrix in the same process."""

from __future__ import annotations

import json
import math
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from time import perf_counter, thread_time

import numpy as np

from cdpr.log.blocks import BLOCK
from cdpr.log.recorder import Recorder
from cdpr.plugins.registry import registry
from cdpr.scenario import Scenario, load_scenario
from cdpr.simulation.build import build
from cdpr.simulation.header import make_header
from cdpr.simulation.loop import Loop
from cdpr.simulation.pipeline import Pipeline
from cdpr.simulation.simulation import Simulation
from cdpr.tension.operations import Operation

SCENARIOS = Path(__file__).parent.parent / "scenarios"
SECONDS = 5.0
RUNS = 15  # counted, after one that is not
PINV_CALLS = 100
STEPS = 200  # of each part alone, in a chunk
BACKENDS = [name for name in ("reference", "mujoco", "bullet", "dart") if not registry().get("backend", name).missing]


def pinv_cost(matrix: np.ndarray) -> float:
    """Seconds of one pinv, over one chunk."""
    start = perf_counter()
    for _ in range(PINV_CALLS):
        np.linalg.pinv(matrix)
    return (perf_counter() - start) / PINV_CALLS


def add_steps(scenario: Scenario, steps: list[float], between: Callable[[], object] = lambda: None) -> None:
    """Run without a log; append the processor time of a step in each chunk, s. Call `between` after each chunk."""
    loop = Loop(build(scenario))
    loop.warm_up(scenario.initial.state())
    done, since = 0, thread_time()

    def chunk(k: int) -> None:
        nonlocal done, since
        steps.append((thread_time() - since) / (k - done))
        between()
        done, since = k, thread_time()

    rows = np.full((BLOCK, len(loop.row)), math.nan)  # filled again and again: new pages of memory are the log's cost
    loop.run(rows, chunk, steps=scenario.simulation.steps)


@dataclass(frozen=True)
class Kind:
    """Variant of the loop."""

    backend: str
    substeps: int = 1  # physics steps in one of control
    scenario: str = "caroca"
    interpreted: bool = False  # the controller's own method is called, from Python, in place of its kernel
    disk: bool = True  # the log goes there


def one_run(kind: Kind, steps: list[float], pinvs: list[float]) -> None:
    """Run once and append what a step and a pinv cost in each chunk, s."""
    overrides = {"simulation.duration": SECONDS, "simulation.physics_step": 1e-3 / kind.substeps}
    scenario = load_scenario(SCENARIOS / f"{kind.scenario}.yaml", backend=kind.backend, overrides=overrides)
    parts = build(scenario)
    if kind.interpreted:
        vars(parts.controller)["control"] = parts.controller.control  # for what is put in by hand no kernel speaks
    loop = Loop(parts)
    assert ("controller" in loop.pipeline.interpreted) == kind.interpreted
    loop.warm_up(scenario.initial.state())
    with tempfile.TemporaryDirectory() as folder:
        recorder = Recorder(make_header(scenario), scenario.simulation.steps, Path(folder))
        done, since = 0, perf_counter()

        def chunk(k: int) -> None:
            nonlocal done, since
            if kind.disk:
                recorder.flush(k)
            steps.append((perf_counter() - since) / (k - done))
            pinvs.append(pinv_cost(loop.W))
            done, since = k, perf_counter()

        loop.run(recorder.rows, chunk)
        recorder.close(loop.count)


def step_cost(kind: Kind) -> dict[str, float]:
    """Medians over interleaved chunks of several runs: a step and a pinv, s, and their ratio."""
    steps: list[float] = []
    pinvs: list[float] = []
    one_run(kind, [], [])
    for _ in range(RUNS):
        one_run(kind, steps, pinvs)
    step, pinv = median(steps), median(pinvs)
    return {"step_us": 1e6 * step, "pinv_us": 1e6 * pinv, "ratio": step / pinv}


def share(call: Callable[[], object], times: int, matrix: np.ndarray, before: Callable[[], object]) -> float:
    """Return the cost of each of `times` repetitions in a call, in pinvs: ratio of medians over interleaved chunks."""
    costs, pinvs = [], []
    for _ in range(30):
        before()
        start = perf_counter()
        call()
        costs.append((perf_counter() - start) / times)
        pinvs.append(pinv_cost(matrix))
    return median(costs) / median(pinvs)


def part_costs(backend: str) -> dict[str, float]:
    """Return the cost of each part's operations as a separate step, in a constant pose, in pinvs."""
    scenario = load_scenario(SCENARIOS / "caroca.yaml", backend=backend, overrides={"trajectory": {"type": "hold"}})
    start = scenario.initial.state()
    with tempfile.TemporaryDirectory() as folder:
        loop = Loop(build(scenario))
        loop.warm_up(start)
        recorder = Recorder(make_header(scenario), scenario.simulation.steps, Path(folder))
        loop.run(recorder.rows, lambda _: None)
        since = perf_counter()
        for k in range(BLOCK, loop.count, BLOCK):
            recorder.flush(k)
        log = (perf_counter() - since) / k
        recorder.close(loop.count)

    parts = build(scenario)
    loop = Loop(parts)
    loop.warm_up(start)
    rows = np.empty((BLOCK, len(loop.row)))
    loop.begin(rows, BLOCK)
    loop.decide()
    parts.backend.command[:] = loop.tension
    still = parts.backend.snapshot()

    def cost(operations: list[Operation]) -> float:
        pipeline = Pipeline(operations, [], loop.row, 0.0)
        pipeline.rows, pipeline.due = rows, -1

        def go() -> None:
            pipeline.run_until(pipeline.count + STEPS)

        return share(go, STEPS, loop.W, lambda: parts.backend.restore(still))

    done = [operation for operation in loop.pipeline.operations if operation.name and not operation.due]
    # The plant comes last: only it moves something, above all its clock, which must not be found to go wrong.
    names = sorted(dict.fromkeys(operation.name for operation in done), key=lambda name: name == "backend")
    row = cost([])
    shares: dict[str, float] = {}
    for name in names:
        told = f"{name} (Python)" if name in loop.pipeline.interpreted else name
        shares[told] = cost([operation for operation in done if operation.name == name]) - row
    return {**shares, "row": row, "log": log / median(pinv_cost(loop.W) for _ in range(30))}


def command_costs(calls: int = 50) -> dict[str, float]:
    """Cost of `Simulation.step()`, us, and of a step with a command from outside as a share of it, at rest.

    Minima over interleaved chunks of one step a call; of n steps a call the share is smaller.
    """
    overrides = {"simulation.duration": 60.0, "trajectory": {"type": "hold"}}
    sims = [Simulation(SCENARIOS / "caroca.yaml", backend="reference", overrides=overrides) for _ in range(3)]
    for sim in sims:
        sim.step()
    tension = sims[0].tension
    wrench = sims[0].row[sims[0].header.layout.columns["wrench"]]
    steps = (
        sims[0].step,
        lambda: sims[1].step(wrench=wrench),
        lambda: sims[2].step(tension=tension),
    )
    least = [math.inf] * 3
    for _ in range(400):
        for i, step in enumerate(steps):
            start = thread_time()
            for _ in range(calls):
                step()
            least[i] = min(least[i], (thread_time() - start) / calls)
    return {"step_us": 1e6 * least[0], "wrench": least[1] / least[0], "tension": least[2] / least[0]}


def measure() -> dict[str, dict[str, object]]:
    """All figures, by backend."""
    result: dict[str, dict[str, object]] = {}
    for backend in BACKENDS:
        result[backend] = {
            **step_cost(Kind(backend)),
            "ratio_in_memory": step_cost(Kind(backend, disk=False))["ratio"],
            "ratio_python_controller": step_cost(Kind(backend, interpreted=True))["ratio"],
            "ratio_cogiro": step_cost(Kind(backend, scenario="cogiro"))["ratio"],
            "ratio_10_substeps": step_cost(Kind(backend, substeps=10))["ratio"],
            "parts": part_costs(backend),
        }
    return result


def gate(limit: float) -> None:
    """Fail where a step costs more than `limit` pinvs."""
    for backend in BACKENDS:
        ratio = step_cost(Kind(backend))["ratio"]
        print(f"{backend}: {ratio:.2f} pinv a step, at most {limit:g} allowed")
        if ratio > limit:
            sys.exit(1)


def main() -> None:
    if "--gate" in sys.argv:
        gate(float(sys.argv[sys.argv.index("--gate") + 1]))
        return
    if "--commands" in sys.argv:
        costs = command_costs()
        print(
            f"step(): {costs['step_us']:.2f} us; wrench= {costs['wrench']:.2f}, tension= {costs['tension']:.2f} of it"
        )
        return
    result = measure()
    if "--json" in sys.argv:
        print(json.dumps(result, indent=2))
        return
    for backend, costs in result.items():
        print(
            f"{backend}: {costs['ratio']:.2f} pinv a step, {costs['ratio_in_memory']:.2f} in memory, "
            f"{costs['ratio_python_controller']:.2f} with a controller in Python, {costs['ratio_cogiro']:.2f} for "
            f"cogiro, {costs['ratio_10_substeps']:.2f} with 10 physics steps "
            f"({costs['step_us']:.1f} us against {costs['pinv_us']:.1f} us)"
        )
        for part, share in costs["parts"].items():
            print(f"  {part:<20} {share:.3f}")


if __name__ == "__main__":
    main()
