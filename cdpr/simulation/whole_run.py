"""Function that simulates a scenario and always keeps the computed samples."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from typing import Any, cast

from cdpr.base.errors import CdprError
from cdpr.base.problems import shown
from cdpr.log.run import Run
from cdpr.log.run_folder import RunFolder
from cdpr.plugins import Backend, Controller, Estimator, TensionSolver
from cdpr.scenario.loader import AnyScenario
from cdpr.simulation.start import Chosen, attempt


def simulate(
    scenario: AnyScenario,
    *,
    backend: str | type[Backend] | None = None,
    solver: str | type[TensionSolver] | None = None,
    controller: str | type[Controller] | None = None,
    estimator: str | type[Estimator] | None = None,
    overrides: Mapping[str, Any] | None = None,
    out: str | os.PathLike[str] | RunFolder | None = None,
    real_time: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> Run:
    """Simulate a scenario and return the run.

    Args:
        scenario: a Scenario, a file, the name of an example, or a dict with the keys of a scenario file.
        backend: name or class of the backend that replaces the scenario's; a class need not be installed, and may hold
            `Options`, the model of its options, and `properties`.
        solver: tension solver, likewise.
        controller: controller, likewise.
        estimator: estimator, likewise.
        overrides: values by dotted key, such as {"simulation.duration": 2.0}, checked like the file.
        out: folder, new or empty, for log, resolved scenario and run.json; by default nothing is written.
        real_time: True for a run no faster than the wall clock. It makes up for delays of less than half a second.
        progress: callback with the number of complete samples and their total, called at least every half second or
            step; it may raise Interrupted to end the run.

    Returns:
        The run, with all samples.

    Raises:
        ScenarioError: if the scenario is wrong.
        PluginError: if a plugin is missing or broken.
        OutputError: if `out` cannot be written.
        SimulationStopped: if the run ends early: Infeasible (LimitViolation for limit violations of cables,
            CollisionDetected for too small clearance, SolverFailed for an invalid answer of the solver), Diverged or
            (by `progress`) Interrupted.

    The attribute `run` of the error, also of a KeyboardInterrupt, holds all samples up to the end.

    Example:
        >>> import cdpr
        >>> run = cdpr.simulate("caroca", overrides={"simulation.duration": 0.1})
        >>> run.status, run.time.shape, run.position.shape, run.tension.shape
        ('finished', (101,), (101, 3), (101, 8))
    """
    if not isinstance(real_time, bool):
        raise CdprError(f"simulate(real_time=): expected True or False, got {shown(real_time)}")
    if progress is not None and not callable(progress):
        raise CdprError(f"simulate(progress=): expected a function, got {shown(progress)}")
    chosen: dict[str, Any] = {"backend": backend, "solver": solver, "controller": controller, "estimator": estimator}
    if real_time:
        from cdpr.simulation.driver import Driver
        from cdpr.simulation.simulation import Simulation

        return Driver(Simulation(scenario, **chosen, overrides=overrides, out=out)).run(progress)
    runner = attempt(scenario, cast("Chosen", chosen), overrides, out)
    error: BaseException | None = None
    try:
        loop, recorder = runner.begin()
        total = runner.scenario.simulation.steps + 1
        report = progress or (lambda done, total: None)
        report(0, total)

        def flush(k: int) -> None:
            recorder.flush(k)
            report(k, total)  # may raise Interrupted; the rows up to here are on disk

        loop.run(recorder.rows, flush, steps=total - 1)
    except BaseException as stop:
        error = runner.as_cdpr_error(stop)
    return runner.end(error)
