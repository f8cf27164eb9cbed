"""Verbs of the Python interface for sizing, designs, studies and comparisons: one call from input to result."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cdpr.base.defaults import SAFETY
from cdpr.base.errors import CdprError
from cdpr.base.problems import shown
from cdpr.config.overrides import Overrides
from cdpr.config.problems import judged
from cdpr.model import Robot
from cdpr.scenario import load_scenario
from cdpr.scenario.examples import is_run
from cdpr.scenario.loader import AnyScenario, Source

if TYPE_CHECKING:  # each verb imports only its own analysis
    from cdpr.analysis.compare.job import Comparison
    from cdpr.analysis.design import Design, Designed
    from cdpr.analysis.sizing import Duty, Sizing
    from cdpr.analysis.study import Results, Study
    from cdpr.analysis.workspace import Region, Required
    from cdpr.log.run import Run

CELLS = 10  # cells of `size` along the longest side of a workspace


def size(
    what: AnyScenario | Run | Sequence[AnyScenario | Run],
    *,
    safety: float = SAFETY,
    broken: bool = False,
    required: Required | None = None,
    region: Region | None = None,
    lower: ArrayLike | None = None,
    upper: ArrayLike | None = None,
    cells: int | Sequence[int] | None = None,
    overrides: Overrides | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
    say: Callable[[str], None] = lambda text: None,
) -> Sizing:
    """Size cables, drums and motors for scenarios and runs of a robot.

    A scenario's motion is evaluated by inverse kinematics and dynamics, with tensions of minimum 2-norm.

    Args:
        what: one or several of: Scenario, scenario file, name of an example, dict, Run, or folder of a run.
        safety: ratio of a cable's breaking load to its largest tension.
        broken: repeat the analysis with each cable broken in turn.
        required: wrenches at rest in addition to the weight, all over a region, such as
            `cdpr.analysis.workspace.box([50, 50, 50, 5, 5, 5])`. Robot and gravity are those of the first of `what`.
        region: positions and attitudes for `required`; made from the next three by default.
        lower: lowest corner, (3,), m; that of the frame by default.
        upper: highest corner, likewise.
        cells: cells along x, y, z, or along the longest side; 10 by default.
        overrides: values of the scenarios by dotted key.
        progress: called with the number of finished duties and their total.
        say: called with each note and warning of the scenarios.

    Returns:
        The worst figures of each cable; `to_dict()` returns them as plain data.

    Raises:
        CdprError: if an argument is wrong, or the robots differ.

    Example:
        >>> import cdpr
        >>> found = cdpr.size("caroca", overrides={"simulation.duration": 0.5})
        >>> found.worst.tension.shape
        (8,)
    """
    from cdpr.analysis.sizing import sizing, with_one_broken

    several = isinstance(what, Sequence) and not isinstance(what, str)
    items: Sequence[Any] = what if several else [what]  # type: ignore[assignment]
    place = {"region": region, "lower": lower, "upper": upper, "cells": cells}
    if required is None and any(value is not None for value in place.values()):
        raise CdprError("size(region=, lower=, upper=, cells=): only with required=, the wrenches")
    duties, gravity, total = [], None, len(items) + (required is not None)
    for i, each in enumerate(items):
        duty, own = _duty(each, i if several else None, overrides, say)
        gravity = own if gravity is None else gravity
        duties.append(duty)
        progress(len(duties), total)
    if required is not None and gravity is not None:
        duties.append(_duty_over(duties[0].robot, gravity, required, place))
        progress(len(duties), total)
    if broken:
        total += sum(duty.robot.m for duty in duties)
        for duty in list(duties):
            for other in with_one_broken(duty):
                duties.append(other)
                progress(len(duties), total)
    return sizing(duties, safety)


def _duty(
    what: Any, i: int | None, overrides: Overrides | None, say: Callable[[str], None]
) -> tuple[Duty, NDArray[np.float64]]:
    """Return the duty of a scenario or run, item `i` of several, and its gravity, (3,), m/s^2."""
    from cdpr.analysis.distribution.motion import assumed_tensions
    from cdpr.analysis.sizing import Duty
    from cdpr.log.reader import load_run
    from cdpr.log.run import Run

    stored = is_run(what)
    if stored or isinstance(what, Run):
        if overrides:
            raise CdprError("size(overrides=): applies to scenarios, not to finished runs")
        run = what if isinstance(what, Run) else load_run(os.fspath(what))
        duty = Duty.of_run(run, os.fspath(what) if stored else run.header.scenario)
        return duty, np.array(run.header.gravity)
    scenario = load_scenario(what, overrides={} if overrides is None else overrides)
    for text in (*scenario.notes, *judged(scenario.warnings, strict=False)):
        say(text)
    if text := assumed_tensions(scenario):
        say(f"tensions: {text}; size the run instead")
    gravity = np.array(scenario.world.gravity)
    if isinstance(what, str | os.PathLike):
        return Duty.of_scenario(scenario, os.fspath(what)), gravity
    return Duty.of_scenario(scenario, scenario.name if i is None else f"{scenario.name} [{i}]"), gravity


def _duty_over(robot: Robot, gravity: NDArray[np.float64], required: object, place: dict[str, Any]) -> Duty:
    """Return the static duty of `size(required=)`."""
    from cdpr.analysis.sizing import over_workspace
    from cdpr.analysis.workspace import Region, Required
    from cdpr.analysis.workspace import region as region_of

    if not isinstance(required, Required):
        raise CdprError(f"size(required=): expected a cdpr.analysis.workspace.Required, got {shown(required)}")
    region = place.pop("region")
    if region is None:
        region = region_of(robot, **place | {"cells": CELLS if place["cells"] is None else place["cells"]})
    elif not isinstance(region, Region):
        raise CdprError(f"size(region=): expected a cdpr.analysis.workspace.Region, got {shown(region)}")
    elif any(value is not None for value in place.values()):
        raise CdprError("size(region=): give either a region, or lower, upper and cells")
    return over_workspace(robot, region, required, gravity)


def design(
    what: Source | Design,
    out: str | os.PathLike[str],
    *,
    evaluations: int | None = None,
    jobs: int = 1,
    resume: bool = False,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Designed:
    """Optimise a robot: evaluate candidates of its varied keys, and write the result.

    Args:
        what: file of a design, name of an example, dict with the keys of such a file, or result of `load_design`. File
            names in a dict are absolute or relative to the working folder.
        out: folder; new, empty, or with a part of this design if `resume` is set.
        evaluations: number of evaluations instead of the file's.
        jobs: number of threads; the result does not depend on it.
        resume: replay the evaluations in `out` and continue.
        progress: called with the number of evaluated candidates and their total.

    Returns:
        All candidates in their order, and the best of them; its files are in `out`.

    Raises:
        CdprError: if the design is wrong, or `out` cannot be written.

    Example:
        >>> import tempfile
        >>> import cdpr
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     print(cdpr.design("design_box", f"{folder}/out", evaluations=2))
        <Designed design_box: 2 candidates, 1 feasible>
    """
    from cdpr.analysis.design import Design, load_design, run_design

    _check_jobs(jobs, "design")
    if not isinstance(what, Design):
        what = load_design(what, evaluations=evaluations)
    elif evaluations is not None:
        raise CdprError("design(evaluations=): a loaded design already has its number of evaluations")
    return run_design(what, out, jobs=jobs, resume=resume, progress=progress)


def study(
    what: Source | Study,
    out: str | os.PathLike[str],
    *,
    overrides: Overrides | None = None,
    jobs: int | None = None,
    timeout: float | None = None,
    scheduler: str | None = None,
    progress: Callable[[int, int, Mapping[str, int]], None] = lambda done, total, counts: None,
    say: Callable[[str], None] = lambda text: None,
) -> Results:
    """Run a scenario with changed keys, each case in a worker process, and write the table of results.

    Args:
        what: study file, name of an example, dict with the keys of a study file, or result of `load_study`. The
            scenario in a dict may be a Scenario or a dict; file names are absolute or relative to the working folder.
        out: its folder; finished cases in it are not run again.
        overrides: values of the scenario by dotted key, in all cases.
        jobs: number of worker processes, 1 by default.
        timeout: time limit of a case, s.
        scheduler: address of a Dask cluster that runs the cases, such as tcp://host:8786.
        progress: called with the number of ended cases, their total, and their number by status.
        say: called with each note and warning of the cases, and with messages of the run.

    Returns:
        The rows of all cases; the tables are in `out`.

    Raises:
        CdprError: if the study is wrong, or `out` cannot be written.

    Example:
        >>> import tempfile
        >>> import cdpr
        >>> gains = {"scenario": "planar", "axes": [{"key": "controller.kp", "values": [50, 100]}]}
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     print(cdpr.study(gains, f"{folder}/out", overrides={"simulation.duration": 0.02}))
        <Results of study: 2 finished>
    """
    from cdpr.analysis.study import Study, load_study, run_study

    _check_jobs(1 if jobs is None else jobs, "study")
    if jobs is not None and scheduler is not None:
        raise CdprError("study(jobs=): not with scheduler=, whose workers run a case for each thread")
    if not isinstance(what, Study):
        what = load_study(what, overrides={} if overrides is None else overrides)
        for note in what.notes:
            say(note)
    elif overrides:
        raise CdprError("study(overrides=): a loaded study cannot be changed; give its file")
    executor = None
    if scheduler is not None:
        from cdpr.analysis.jobs.cluster import executor as on_cluster

        executor = on_cluster(scheduler)
    return run_study(what, out, jobs=jobs or 1, timeout=timeout, executor=executor, progress=progress, say=say)


def _check_jobs(jobs: object, verb: str) -> None:
    if not isinstance(jobs, int) or isinstance(jobs, bool) or jobs < 1:
        raise CdprError(f"{verb}(jobs=): expected a whole number from 1 on, got {shown(jobs)}")


def compare(
    what: AnyScenario | Sequence[str],
    *,
    overrides: Overrides | None = None,
    strict: bool = False,
    backends: Sequence[str] | None = None,
    solvers: Sequence[str] | None = None,
    refine: bool = False,
    out: str | os.PathLike[str] | None = None,
    jobs: int | None = None,
    timeout: float | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
    say: Callable[[str], None] = lambda text: None,
) -> Comparison:
    """Run a scenario on several engines and judge them; or compare finished runs.

    Args:
        what: a Scenario, a file, the name of an example, or a dict; or a list of folders of finished runs.
        overrides: values of the scenario by dotted key.
        strict: treat warnings as errors, before anything runs.
        backends: engines; all installed ones by default.
        solvers: tension solvers instead of the scenario's.
        refine: also measure the orders of convergence.
        out: new or empty folder for the runs.
        jobs: number of processes; one per core by default.
        timeout: time limit of a run, s.
        progress: called with the number of finished runs and the total.
        say: called with each note and warning of the scenario.

    Returns:
        The results of all engines or runs, and the verdict in `figures["agrees"]`.

    Raises:
        CdprError: if the scenario or an argument is wrong, or there is nothing to compare.

    Example:
        >>> import cdpr
        >>> cdpr.compare("remote_plant", overrides={"simulation.duration": 0.02}, backends=["remote"])
        <Comparison of remote_plant: differences not judged>
    """
    from cdpr.analysis.compare.finished import compare_finished
    from cdpr.analysis.compare.job import compare_scenario

    for name, names in {"backends": backends, "solvers": solvers}.items():
        if names is not None and not (isinstance(names, list | tuple) and all(isinstance(each, str) for each in names)):
            raise CdprError(f"compare({name}=): expected a list of names, got {shown(names)}")
    if isinstance(what, Sequence) and not isinstance(what, str | bytes):
        options = {"overrides": overrides, "backends": backends, "solvers": solvers, "out": out, "jobs": jobs}
        for name, value in {**options, "timeout": timeout, "refine": refine or None, "strict": strict or None}.items():
            if value is not None:
                raise CdprError(f"compare({name}=): applies to a scenario, not to finished runs")
        return compare_finished(list(what))
    if isinstance(what, Robot):
        raise CdprError("compare(what=): expected a scenario or a list of runs, got a Robot")
    return compare_scenario(
        what,
        changes={} if overrides is None else overrides,
        strict=strict,
        backends=backends,
        solvers=solvers,
        refine=refine,
        out=out,
        jobs=jobs,
        timeout=timeout,
        progress=progress,
        say=say,
    )
