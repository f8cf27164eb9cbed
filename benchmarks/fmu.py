"""Cost of an FMU as a plant: our step against FMPy's convenience calls, a closed loop in pinvs, a worker process."""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from statistics import median
from time import perf_counter

import fmpy
import fmpy.fmi2
import fmpy.fmi3
import numpy as np
from step import SCENARIOS, Kind, pinv_cost, step_cost

from cdpr.fmu.export import Plant, cached_fmu
from cdpr.fmu.read.archive import open_archive
from cdpr.fmu.read.options import FmuFile
from cdpr.fmu.run.running import Isolation, RunningFmu
from cdpr.scenario import load_scenario

STEP = 1e-3  # s
CALLS, CHUNKS = 200, 60

# Upper limits: a step of ours in units of FMPy's, a closed-loop step in units of a pinv of 6x8.
LIMITS = {"step": 0.5, "loop": 1.5}


class Convenience:
    """An FMU by FMPy's own calls: set the inputs, do a step, get the outputs as an array."""

    def __init__(self, path: Path, folder: str, like: RunningFmu) -> None:
        about = fmpy.read_model_description(str(path), validate=False)
        fmpy.extract(str(path), unzipdir=folder)
        third = about.fmiVersion == "3.0"
        kind = fmpy.fmi3.FMU3Slave if third else fmpy.fmi2.FMU2Slave
        self.slave = slave = kind(
            guid=about.guid, modelIdentifier=about.coSimulation.modelIdentifier, unzipDirectory=folder
        )
        slave.instantiate()
        if not third:
            slave.setupExperiment()
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        plan, size = like.instance.plan, like.instance.outputs.size
        self.inputs, self.outputs = ([reference for reference, _ in side] for side in (plan.inputs, plan.outputs))
        self.values = like.instance.inputs.tolist()
        self.set = slave.setFloat64 if third else slave.setReal
        self.get = partial(slave.getFloat64, nValues=size) if third else slave.getReal
        self.steps = 0

    def step(self) -> np.ndarray:
        self.set(self.inputs, self.values)
        self.slave.doStep(self.steps * STEP, STEP)
        self.steps += 1
        return np.asarray(self.get(self.outputs))


def interleaved(calls: dict[str, Callable[[], object]]) -> dict[str, float]:
    """Median seconds of each call and of one pinv of 6x8, over chunks in turn."""
    matrix = np.random.default_rng(0).normal(size=(6, 8))
    costs: dict[str, list[float]] = {name: [] for name in (*calls, "pinv")}
    for _ in range(CHUNKS):
        for name, call in calls.items():
            start = perf_counter()
            for _ in range(CALLS):
                call()
            costs[name].append((perf_counter() - start) / CALLS)
        costs["pinv"].append(pinv_cost(matrix))
    return {name: median(values) for name, values in costs.items()}


def plant_costs(fmi: int) -> dict[str, float]:
    """One step of the plant alone, by our calls in this process and in another, and by FMPy's."""
    scenario = load_scenario(SCENARIOS / "caroca_fmu.yaml")
    path = cached_fmu(Plant(scenario.robot, scenario.gravity, STEP, scenario.initial.state()), fmi)
    with ExitStack() as made:

        def running(isolation: Isolation) -> RunningFmu:
            fmu = RunningFmu(open_archive(path), "caroca", "plant", scenario.robot, STEP, FmuFile(), isolation)
            made.callback(fmu.close)
            fmu.start({})
            return fmu

        here, apart = running("inproc"), running("process")
        theirs = Convenience(path, made.enter_context(tempfile.TemporaryDirectory()), here)
        costs = interleaved(
            {
                "ours": partial(here.instance.step, 1),
                "process": partial(apart.instance.step, 1),
                "fmpy": theirs.step,
            }
        )
        np.testing.assert_array_equal(here.instance.outputs, theirs.get(theirs.outputs))  # the same was computed
    return costs


def measure() -> dict[str, dict[str, float]]:
    """All figures, by version of the standard."""
    result = {}
    for fmi in (2, 3):
        costs = plant_costs(fmi)
        result[f"FMI {fmi}"] = {
            **{f"{name}_us": 1e6 * seconds for name, seconds in costs.items()},
            "step": costs["ours"] / costs["fmpy"],
            "process": costs["process"] / costs["ours"],
            "process_pinv": costs["process"] / costs["pinv"],
        }
    result["FMI 3"]["loop"] = step_cost(Kind("fmu", scenario="caroca_fmu"))["ratio"]
    result["reference"] = {"loop": step_cost(Kind("reference", scenario="caroca_fmu"))["ratio"]}
    return result


def main() -> None:
    result = measure()
    if "--json" in sys.argv:
        print(json.dumps(result, indent=2))
    for name, figures in result.items() if "--json" not in sys.argv else ():
        print(f"{name}: " + ", ".join(f"{key} {value:.3g}" for key, value in figures.items()))
    if "--gate" in sys.argv:
        for figures in result.values():
            for key, limit in LIMITS.items():
                if figures.get(key, 0.0) > limit:
                    sys.exit(f"{key}: {figures[key]:.2f}, at most {limit:g} allowed")


if __name__ == "__main__":
    main()
