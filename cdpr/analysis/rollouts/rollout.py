"""Function that runs the cases of a rollout in threads or on a cluster, and collects their results."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from functools import partial
from typing import Any

import numpy as np

from cdpr.analysis.jobs.cases import Outcome
from cdpr.analysis.jobs.cluster import spread
from cdpr.analysis.jobs.folder import JobFolder
from cdpr.analysis.jobs.threads import beside
from cdpr.analysis.rollouts.case import Plan, layout_of
from cdpr.analysis.rollouts.chunk import Chunk, run_chunk
from cdpr.analysis.rollouts.kept import THINNER, RowsInFolder, RowsInMemory
from cdpr.analysis.rollouts.result import Rollouts
from cdpr.analysis.rollouts.vary import check_count, values_of
from cdpr.base import tolerances
from cdpr.base.errors import CdprError
from cdpr.base.nearest import did_you_mean
from cdpr.base.problems import shown
from cdpr.config.overrides import plain_value
from cdpr.log.run_folder import folder_name
from cdpr.model.robot import Array, read_only
from cdpr.plugins import Backend, Controller, Estimator, TensionSolver
from cdpr.plugins.classes import PluginFile
from cdpr.plugins.registry import plugin_files, use_files
from cdpr.scenario import Scenario
from cdpr.scenario.loader import AnyScenario
from cdpr.scenario.repeatable import check_repeatable
from cdpr.simulation.build import build
from cdpr.simulation.columns import chosen_plugins
from cdpr.simulation.header import plugins_of, versions_of
from cdpr.simulation.loop import Loop
from cdpr.simulation.loop_parts import check_entries, entries
from cdpr.simulation.needs import require, supported
from cdpr.simulation.start import Chosen, chosen_scenario

KIND = "rollout"

COLUMNS = ("position", "orientation", "tension")  # columns kept by default
SAMPLES = 100  # approximate number of kept samples by default

# A chunk has at most this number of cases or samples, and fewer if their rows exceed this number of bytes: the work
# lost by an interrupt.
CASES, CHUNK, BYTES = 16, 1 << 18, 1 << 25
MEMORY = 0.5  # largest share of the memory for rows: more require a folder

Progress = Callable[[int, int], None]


def rollout(
    scenario: AnyScenario,
    n: int,
    *,
    vary: Mapping[str, Any],
    seed: int = 0,
    overrides: Mapping[str, Any] | None = None,
    backend: str | type[Backend] | None = None,
    solver: str | type[TensionSolver] | None = None,
    controller: str | type[Controller] | None = None,
    estimator: str | type[Estimator] | None = None,
    every: float | None = None,
    columns: Sequence[str] = COLUMNS,
    threads: int | None = None,
    scheduler: str | None = None,
    out: str | os.PathLike[str] | None = None,
    progress: Progress = lambda done, total: None,
) -> Rollouts:
    """Run a scenario n times with some keys varied; on `reference` each case has the bits of `simulate`.

    Args:
        scenario: a Scenario, a file, the name of an example, or a dict with the keys of a scenario file.
        n: number of cases.
        vary: by dotted key, an array (n, ...) or a list of n values, or a distribution: {"uniform": [lowest, highest]},
            {"normal": [mean, standard deviation]}, {"log_uniform": [lowest, highest]}, as a study's `random`.
        seed: seed of the distributions. The same seed gives the same values, and a larger n only adds cases.
        overrides: values by dotted key, in all cases.
        backend: backend by name or class, as for `simulate`.
        solver: tension solver, likewise.
        controller: controller, likewise.
        estimator: estimator, likewise.
        every: distance of the kept samples: an int in samples, a float in s. The last sample is kept, too. The default
            keeps about a hundred.
        columns: names of the kept columns of a run.
        threads: number of threads; by default one per core if backend, controller and solver are compiled, else one.
        scheduler: address of a Dask cluster that runs the cases instead, such as tcp://host:8786.
        out: folder of the results; the same call continues an unfinished rollout. Damaged cases are computed again,
            with a warning.
        progress: callback with the number of ended cases, and their total.

    A case that ends early (diverged, infeasible, ...) is a result. A case with values that the scenario rejects has the
    status "failed", with its message; if that is the first case, its error is raised.

    Returns:
        Arrays of all cases, (cases, samples, ...), with the status and the message of each case; see `Rollouts`.

    Raises:
        ScenarioError: if the scenario is wrong.
        CdprError: if an argument is wrong.
        PluginError: if a plugin is missing or broken.
        OutputError: if `out` contains something else or cannot be written. After a KeyboardInterrupt, `out` contains
            the ended cases.

    Example:
        >>> import cdpr
        >>> gains = {"controller.kp": [80.0, 120.0, 160.0]}
        >>> cases = cdpr.rollout("caroca", 3, vary=gains, overrides={"simulation.duration": 0.1}, every=50)
        >>> cases.position.shape
        (3, 3, 3)
    """
    n = check_count(n)
    chosen: Chosen = {"backend": backend, "solver": solver, "controller": controller, "estimator": estimator}
    values = values_of(vary, n, seed, overrides, chosen)
    if scheduler is not None and not isinstance(scheduler, str):
        raise CdprError(f"rollout: scheduler: expected an address such as tcp://host:8786, got {shown(scheduler)}")
    if scheduler is not None and not all(each is None or isinstance(each, str) for each in chosen.values()):
        raise CdprError("rollout: a class does not go with scheduler: put it into a file for --plugin, or install it")
    base = chosen_scenario(scenario, chosen, overrides)
    check_repeatable(base, "a rollout")
    require(base, "rollout")
    plan = Plan(base, tuple(values), _every(every, base), _columns(columns, base))
    compiled = _compiled(plan, [given[0] for given in values.values()])
    if threads is not None and (isinstance(threads, bool) or not isinstance(threads, int) or threads < 1):
        raise CdprError(f"rollout: threads: expected a whole number from 1 on, got {shown(threads)}")
    if not callable(progress):
        raise CdprError(f"rollout: progress: expected a function, got {shown(progress)}")
    if threads is not None and threads > 1 and not compiled:
        raise CdprError(
            f"rollout: threads: {threads} threads have no effect: backend, controller or solver of this scenario "
            "needs Python "
            "in each step, or the backend does not declare that its instances can step in parallel; omit it"
        )
    if threads is not None and scheduler is not None:
        raise CdprError(
            "rollout: threads does not go with scheduler: the cluster's workers run a chunk for each thread"
        )
    with ExitStack() as opened:
        folder = None if out is None else JobFolder(folder_name(out), KIND, _about(plan, values, n))
        if folder is not None:
            opened.callback(folder.close)
        kept = _kept_in_memory(plan, n) if folder is None else RowsInFolder(folder, _shape(plan, n))
        opened.callback(kept.close)
        ended = kept.ended
        progress(len(ended), n)

        def done(found: list[Outcome], computed: Array) -> None:
            for outcome, row in zip(found, computed, strict=True):
                kept.keep(outcome, row)
            progress(len(ended), n)

        several = min(threads or (len(os.sched_getaffinity(0)) if compiled else 1), n)
        chunks = _chunks(plan, values, [i for i in range(n) if str(i) not in ended], several)
        if scheduler is None:
            beside(chunks, run_chunk, several, lambda found: done(*found), KIND)
        else:
            _on_cluster(chunks, scheduler, done)
        rows = kept.rows()
    layout = plan.layout
    return Rollouts(
        name=base.name,
        time=read_only(plan.kept * base.simulation.control_step),
        values=values,
        rows=read_only(rows),
        columns=tuple(layout.fields[name] for name in plan.columns),
        cables=tuple(cable.name for cable in base.robot.cables),
        outcomes=tuple(ended[str(i)] for i in range(n)),
    )


def _every(every: object, scenario: Scenario) -> int:
    """Return the distance of the kept samples."""
    steps, step = scenario.simulation.steps, scenario.simulation.control_step
    if every is None:
        return max(1, steps // SAMPLES)
    number = isinstance(every, int | float | np.integer) and not isinstance(every, bool)
    ratio = (float(every) / step if isinstance(every, float) else float(every)) if number else 0.0  # type: ignore[arg-type]
    if not 1.0 - tolerances.TIME <= ratio < np.inf:
        raise CdprError(
            "rollout: every: expected a whole number of samples, at least 1, or seconds as a float, at least the "
            "control "
            f"step, {step:g} s, got {shown(every)}"
        )
    if abs(ratio - round(ratio)) > tolerances.TIME * ratio:
        raise CdprError(f"rollout: every: expected a multiple of the control step, {step:g} s, got {every} s")
    return min(round(ratio), steps)


def _columns(columns: object, scenario: Scenario) -> tuple[str, ...]:
    known = [name for name in layout_of(scenario).fields if name != "time"]
    if not isinstance(columns, list | tuple) or not columns:
        raise CdprError(f"rollout: columns: expected a list of names, got {shown(columns)}")
    names = ["status" if name == "solver_status" else name for name in columns]  # as the attribute of a run
    for name in names:
        if name not in known:
            hint = did_you_mean(name, known) if isinstance(name, str) else ""
            raise CdprError(f"rollout: columns: unknown column {shown(name)}: {hint}allowed: {', '.join(known)}")
    return tuple(dict.fromkeys(names))


def _compiled(plan: Plan, first: Sequence[Any]) -> bool:
    """Return whether cases may run in parallel; raise the error of the first case."""
    scenario = plan.changed(0, first)
    parts = build(scenario)
    try:
        interpreted = Loop(parts).pipeline.interpreted
    finally:
        parts.controller.close()
        parts.backend.close()
    entry = chosen_plugins(scenario)["backend"]
    options = scenario.backend_options(scenario.simulation.backend)
    return not interpreted and bool(entry.properties(options).get("threads")) and supported(scenario, "threads")  # type: ignore[arg-type]


def _about(plan: Plan, values: Mapping[str, Sequence[Any]], n: int) -> dict[str, Any]:
    """Return the metadata of the rollout for its folder, and its identity."""
    scenario = plan.scenario
    given = {key: plain_value(found) for key, found in values.items()}
    what = [scenario.resolved_yaml(), given, n, plan.every, plan.columns]
    digest = hashlib.sha256(json.dumps(what, sort_keys=True).encode()).hexdigest()
    shape = {"every": plan.every, "columns": plan.columns, "vary": list(plan.keys)}
    versions = versions_of(scenario.plugins, plugins_of(scenario))
    return {"name": scenario.name, "cases": n, "digest": digest, **shape, "versions": versions}


def _shape(plan: Plan, n: int) -> tuple[int, int, int]:
    return n, len(plan.kept), len(plan.places)


def _kept_in_memory(plan: Plan, n: int) -> RowsInMemory:
    shape = _shape(plan, n)
    need = 8 * int(np.prod(shape, dtype=object))
    have = MEMORY * os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    if need > have:
        raise CdprError(f"rollout: the rows need {need / 2**30:.3g} GiB of memory: give a folder, out=, {THINNER}")
    return RowsInMemory(shape)


def _chunks(plan: Plan, values: Mapping[str, Sequence[Any]], waiting: Sequence[int], several: int) -> Iterator[Chunk]:
    most = max(CASES, min(CHUNK // plan.steps, -(-len(waiting) // several)))
    size = max(1, min(most, BYTES // (8 * len(plan.kept) * len(plan.places))))
    for first in range(0, len(waiting), size):
        numbers = tuple(waiting[first : first + size])
        yield Chunk(plan, numbers, tuple(tuple(given[i] for given in values.values()) for i in numbers))


def _on_cluster(chunks: Iterator[Chunk], address: str, done: Callable[[list[Outcome], Array], None]) -> None:
    jobs = {str(chunk.numbers[0]): chunk for chunk in chunks}

    def end(key: str, found: tuple[list[Outcome], Array] | None, lost: str) -> None:
        if found is None:
            raise CdprError(f"rollout: the cases from {key} on were {lost}; with out= the same call continues")
        done(*found)

    spread(address, partial(_run_on_worker, plugin_files(), entries()), jobs, end)


def _run_on_worker(files: tuple[PluginFile, ...], parts: tuple[str, ...], chunk: Chunk) -> tuple[list[Outcome], Array]:
    """Run a chunk on a cluster's worker, with the same plugins and parts of the loop as here."""
    use_files(files)
    check_entries(parts)
    return run_chunk(chunk)
