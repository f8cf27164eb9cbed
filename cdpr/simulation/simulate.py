"""Runs a scenario from start to end and keeps what was computed, however it ends."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from time import perf_counter
from typing import Any

from cdpr.errors import CdprError, Diverged, Infeasible, Interrupted, OutputError, PluginError
from cdpr.log.recorder import Recorder
from cdpr.log.run import Event, Run
from cdpr.log.run_folder import RunFolder
from cdpr.plugins.registry import describe
from cdpr.scenario import Scenario, load_scenario
from cdpr.simulation.build import build, make_header
from cdpr.simulation.events import tension_events
from cdpr.simulation.loop import Loop

STATUS: dict[type[CdprError], str] = {Diverged: "diverged", Infeasible: "infeasible", Interrupted: "interrupted"}


def simulate(
    scenario: str | os.PathLike[str] | Scenario,
    *,
    backend: str | None = None,
    solver: str | None = None,
    controller: str | None = None,
    overrides: Mapping[str, Any] | None = None,
    out: str | os.PathLike[str] | RunFolder | None = None,
    real_time: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> Run:
    """Simulate a scenario and return the run.

    Args:
        scenario: a scenario file, or what `load_scenario` returned.
        backend: which to use instead of the scenario's; likewise `solver` and `controller`.
        overrides: values by dotted key, such as {"simulation.duration": 2.0}, checked like the file.
        out: folder, new or empty, for log, resolved scenario and run.json; nothing is written unless it is given.
        real_time: no faster than the wall clock.
        progress: called now and then, at least every half second or step, with the number of samples done and their
            total; it may raise Interrupted to end the run.

    Raises:
        ScenarioError: the scenario is wrong.
        PluginError: a plugin is missing or broken.
        OutputError: `out` cannot be written.
        SimulationStopped: the run ended early: Infeasible, Diverged or Interrupted.

    The `run` of an error that came up while the simulation ran holds all samples up to there.
    """
    changes = overrides or {}
    if isinstance(scenario, Scenario):
        scenario = scenario.with_changes(changes, backend=backend, solver=solver, controller=controller)
    else:
        scenario = load_scenario(scenario, overrides=changes, backend=backend, solver=solver, controller=controller)
    begun = perf_counter()
    header = make_header(scenario)
    parts = build(scenario)
    loop = Loop(parts)
    loop.warm_up(scenario.initial.state())
    steps = scenario.simulation.steps
    folder = RunFolder(Path(out), header) if isinstance(out, (str, os.PathLike)) else out
    started = perf_counter()
    recorder = Recorder(header, steps, None if folder is None else folder.path)

    def flush(k: int) -> None:
        recorder.flush(k)
        if progress is not None:
            progress(k, steps + 1)  # may raise Interrupted; the rows up to here are on disk

    error: CdprError | None = None
    try:
        loop.run(recorder.rows, flush, real_time=real_time)
    except CdprError as stop:
        error = stop
    except KeyboardInterrupt:
        error = Interrupted(f"t = {loop.time:.6g} s: interrupted")
    except Exception as foreign:
        error = PluginError(f"t = {loop.time:.6g} s: a plugin raised {describe(foreign)} in {_origin(foreign)}")
    finally:
        parts.backend.close()
    looped = perf_counter()
    try:
        recorder.close(loop.count)
    except OutputError as unwritable:
        error = unwritable
    rows = recorder.rows[: loop.count]
    status = rows[:, header.layout.columns["status"]][:, 0]
    events = tension_events(status, header.control_step, parts.respects_limits, parts.output)
    outcome = "finished"
    if error is not None:
        outcome = STATUS.get(type(error), "failed")
        events.append(Event(loop.time, outcome, str(error)))
    run = Run(
        header=header,
        rows=rows,
        status=outcome,
        message="" if error is None else str(error),
        events=tuple(events),
        timings={"setup_s": started - begun, "loop_s": looped - started},
        unused=scenario.unused,
        folder=None if folder is None else str(folder.path),
    )
    if error is not None:
        error.run = run
    if folder is not None:
        try:
            folder.finish(run)
        except OutputError as unwritable:
            unwritable.run = run
            error = error or unwritable
    if error is not None:
        raise error
    return run


def _origin(error: BaseException) -> str:
    """Function, file and line where foreign code raised."""
    trace = error.__traceback__
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    if trace is None:
        return "unknown code"
    code = trace.tb_frame.f_code
    return f"{code.co_name} ({Path(code.co_filename).name}:{trace.tb_lineno})"
