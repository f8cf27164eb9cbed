"""Verbs of the Python interface for sizing, designs, studies and comparisons: one call from input to result."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from cdpr.analysis.compare.finished import compare_finished
from cdpr.analysis.compare.job import Comparison, compare_scenario
from cdpr.analysis.design import Design, Designed, load_design, run_design
from cdpr.analysis.sizing import Duty, Sizing, sizing, with_one_broken
from cdpr.analysis.sizing.sizes import SAFETY
from cdpr.analysis.study import Results, Study, load_study, run_study
from cdpr.base.errors import CdprError
from cdpr.base.problems import shown
from cdpr.log.reader import load_run
from cdpr.log.run import Run
from cdpr.model import Robot
from cdpr.scenario import load_scenario
from cdpr.scenario.examples import is_run
from cdpr.scenario.loader import AnyScenario, Source


def size(
    what: AnyScenario | Run | Sequence[AnyScenario | Run],
    *,
    safety: float = SAFETY,
    broken: bool = False,
    overrides: Mapping[str, Any] | None = None,
) -> Sizing:
    """Size cables, drums and motors for scenarios and runs of a robot.

    A scenario's motion is evaluated by inverse kinematics and dynamics, with tensions of minimum 2-norm.

    Args:
        what: one or several of: Scenario, scenario file, name of an example, dict, Run, or folder of a run.
        safety: ratio of a cable's breaking load to its largest tension.
        broken: repeat the analysis with each cable broken in turn.
        overrides: values of the scenarios by dotted key.

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
    several = isinstance(what, Sequence) and not isinstance(what, str)
    items: Sequence[Any] = what if several else [what]  # type: ignore[assignment]
    duties = [_duty(each, i if several else None, overrides) for i, each in enumerate(items)]
    if broken:
        duties += [other for duty in duties for other in with_one_broken(duty)]
    return sizing(duties, safety)


def _duty(what: Any, i: int | None, overrides: Mapping[str, Any] | None) -> Duty:
    stored = is_run(what)
    if stored or isinstance(what, Run):
        if overrides:
            raise CdprError("size(overrides=): applies to scenarios, not to finished runs")
        run = what if isinstance(what, Run) else load_run(os.fspath(what))
        return Duty.of_run(run, os.fspath(what) if stored else run.header.scenario)
    scenario = load_scenario(what, overrides={} if overrides is None else overrides)
    if isinstance(what, str | os.PathLike):
        return Duty.of_scenario(scenario, os.fspath(what))
    return Duty.of_scenario(scenario, scenario.name if i is None else f"{scenario.name} [{i}]")


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
    overrides: Mapping[str, Any] | None = None,
    jobs: int = 1,
    timeout: float | None = None,
    progress: Callable[[int, int, Mapping[str, int]], None] = lambda done, total, counts: None,
) -> Results:
    """Run a scenario with changed keys, each case in a worker process, and write the table of results.

    Args:
        what: study file, name of an example, dict with the keys of a study file, or result of `load_study`. The
            scenario in a dict may be a Scenario or a dict; file names are absolute or relative to the working folder.
        out: its folder; finished cases in it are not run again.
        overrides: values of the scenario by dotted key, in all cases.
        jobs: number of worker processes.
        timeout: time limit of a case, s.
        progress: called with the number of ended cases, their total, and their number by status.

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
    _check_jobs(jobs, "study")
    if not isinstance(what, Study):
        what = load_study(what, overrides={} if overrides is None else overrides)
    elif overrides:
        raise CdprError("study(overrides=): a loaded study cannot be changed; give its file")
    return run_study(what, out, jobs=jobs, timeout=timeout, progress=progress)


def _check_jobs(jobs: object, verb: str) -> None:
    if not isinstance(jobs, int) or isinstance(jobs, bool) or jobs < 1:
        raise CdprError(f"{verb}(jobs=): expected a whole number from 1 on, got {shown(jobs)}")


def compare(
    what: AnyScenario | Sequence[str],
    *,
    overrides: Mapping[str, Any] | None = None,
    backends: Sequence[str] | None = None,
    solvers: Sequence[str] | None = None,
    refine: bool = False,
    out: str | os.PathLike[str] | None = None,
    jobs: int | None = None,
    timeout: float | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Comparison:
    """Run a scenario on several engines and judge them; or compare finished runs.

    Args:
        what: a Scenario, a file, the name of an example, or a dict; or a list of folders of finished runs.
        overrides: values of the scenario by dotted key.
        backends: engines; all installed ones by default.
        solvers: tension solvers instead of the scenario's.
        refine: also measure the orders of convergence.
        out: new or empty folder for the runs.
        jobs: number of processes; one per core by default.
        timeout: time limit of a run, s.
        progress: called with the number of finished runs and the total.

    Returns:
        The results of all engines or runs, and the verdict in `figures["agrees"]`.

    Raises:
        CdprError: if the scenario or an argument is wrong, or there is nothing to compare.

    Example:
        >>> import cdpr
        >>> cdpr.compare("remote_plant", overrides={"simulation.duration": 0.02}, backends=["remote"])
        <Comparison of remote_plant: differences not judged>
    """
    for name, names in {"backends": backends, "solvers": solvers}.items():
        if names is not None and not (isinstance(names, list | tuple) and all(isinstance(each, str) for each in names)):
            raise CdprError(f"compare({name}=): expected a list of names, got {shown(names)}")
    if isinstance(what, Sequence) and not isinstance(what, str | bytes):
        options = {"overrides": overrides, "backends": backends, "solvers": solvers, "out": out, "jobs": jobs}
        for name, value in {**options, "timeout": timeout, "refine": refine or None}.items():
            if value is not None:
                raise CdprError(f"compare({name}=): applies to a scenario, not to finished runs")
        return compare_finished(list(what))
    if isinstance(what, Robot):
        raise CdprError("compare(what=): expected a scenario or a list of runs, got a Robot")
    return compare_scenario(
        what,
        changes={} if overrides is None else overrides,
        backends=backends,
        solvers=solvers,
        refine=refine,
        out=out,
        jobs=jobs,
        timeout=timeout,
        progress=progress,
    )
