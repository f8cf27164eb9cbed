"""Runs a scenario from start to end and keeps what was computed, however it ends."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from typing import Any

from cdpr.log.run import Run
from cdpr.log.run_folder import RunFolder
from cdpr.plugins import Backend, Controller, TensionSolver
from cdpr.scenario import Scenario
from cdpr.simulation.start import attempt


def simulate(
    scenario: str | os.PathLike[str] | Scenario,
    *,
    backend: str | type[Backend] | None = None,
    solver: str | type[TensionSolver] | None = None,
    controller: str | type[Controller] | None = None,
    overrides: Mapping[str, Any] | None = None,
    out: str | os.PathLike[str] | RunFolder | None = None,
    real_time: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> Run:
    """Simulate a scenario and return the run.

    Args:
        scenario: a scenario file, or what `load_scenario` returned.
        backend: which to use instead of the scenario's, by its name or as a class that need not be installed;
            likewise `solver` and `controller`. A class may hold `Options`, the model of its options, and `properties`.
        overrides: values by dotted key, such as {"simulation.duration": 2.0}, checked like the file.
        out: folder, new or empty, for log, resolved scenario and run.json; nothing is written unless it is given.
        real_time: no faster than the wall clock.
        progress: called now and then, at least every half second or step, with the number of samples done and their
            total; it may raise Interrupted to end the run.

    Raises:
        ScenarioError: the scenario is wrong.
        PluginError: a plugin is missing or broken.
        OutputError: `out` cannot be written.
        SimulationStopped: the run ended early: Infeasible (BeyondLimits where cables left theirs, Touched where they
            came too near to something, Unanswered where the solver gave no valid answer), Diverged or (from
            `progress`) Interrupted.

    The attribute `run` of the error, also of a KeyboardInterrupt, holds all samples up to there.
    """
    made = attempt(scenario, backend, solver, controller, overrides, out)
    error: BaseException | None = None
    try:
        loop, recorder = made.begin()
        total = made.scenario.simulation.steps + 1
        tell = progress or (lambda done, total: None)
        tell(0, total)

        def flush(k: int) -> None:
            recorder.flush(k)
            tell(k, total)  # may raise Interrupted; the rows up to here are on disk

        loop.run(recorder.rows, flush, steps=total - 1, real_time=real_time)
    except BaseException as stop:
        error = made.told(stop)
    return made.end(error)
