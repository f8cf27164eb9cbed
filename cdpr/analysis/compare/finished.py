"""Comparison of finished runs."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from pathlib import Path

from cdpr.analysis.compare.comparison import Group, Row, pairs, step_cost
from cdpr.analysis.compare.engines import OWN_CABLES, Engine, engine_of, is_continuous
from cdpr.analysis.compare.job import Comparison, summarise
from cdpr.analysis.compare.scenarios import ENGINE_KEYS, changes
from cdpr.analysis.compare.verdict import Verdict, against_scheme, unjudged
from cdpr.base.errors import CdprError
from cdpr.base.problems import shown
from cdpr.log.files import is_name
from cdpr.log.header import Header
from cdpr.log.reader import load_run
from cdpr.log.run import Run
from cdpr.log.run_folder import SCENARIO_NAME
from cdpr.scenario import Scenario, load_scenario

# Runs that differ in one of these cannot be subtracted from each other.
SHARED = ("robot", "cables", "anchors", "mass", "gravity", "control_step", "log_step")

UNKNOWN = Engine("", 0, "", (), OWN_CABLES)


def compare_finished(paths: Sequence[str]) -> Comparison:
    """Compare run folders or logs.

    Differences are measured from the run of the highest declared order, the first of several. A run is judged only if
    another has the same scheme, step and scenario except for the engine; the two may differ by round-off.

    Args:
        paths: two or more run folders or logs.

    Raises:
        LogError: if a run cannot be read.
        CdprError: if there are fewer than two runs, or robots or timing differ.
    """
    if isinstance(paths, str | PathLike) or not paths:
        raise CdprError(f"expected a list of two or more run folders or logs, got {shown(paths)}")
    for i, path in enumerate(paths):
        if not isinstance(path, str | PathLike) or not is_name(path):
            raise CdprError(f"[{i}]: expected the folder of a finished run, or its log, got {_given(path)}")
    if len(paths) < 2:
        raise CdprError(f"{paths[0]}: expected two or more runs, got one; or compare the scenario on several engines")
    if len({Path(path).resolve() for path in paths}) < len(paths):
        raise CdprError("the same run is given twice")
    names = [Path(path).name for path in paths]
    labels = names if len(set(names)) == len(names) else paths
    loaded = {label: load_run(path) for label, path in zip(labels, paths, strict=True)}
    _refuse(loaded)
    read = {label: _read(label, run) for label, run in loaded.items()}
    judge = max(loaded, key=lambda label: read[label][0].order)  # first of equal ones
    rows = []
    for label, run in loaded.items():
        if label != judge:
            verdict = _judge(label, judge, loaded, read)
            standard = "scheme" if verdict.checks else "none"
            rows.append(Row(label, read[label][0], standard, verdict, run, step_cost(run)))
    head, scenario = loaded[judge].header, read[judge][1]
    continuous = scenario is not None and is_continuous(scenario)
    solvers = ", ".join(dict.fromkeys(run.header.solver for run in loaded.values()))
    group = Group(solvers, continuous, loaded[judge], "", tuple(rows), {}, pairs(rows))
    facts = {
        "scenario": head.scenario,
        "robot": head.robot,
        "duration_s": loaded[judge].span[1],
        "control_step_s": head.control_step,
        "physics_step_s": head.physics_step,
        "judge": {"backend": judge, "order": read[judge][0].order},
        "absent": {},
    }
    if head.log_every > 1:
        logged = len(loaded[judge].rows)
        facts["compared"] = {"logged_samples": logged, "samples": loaded[judge].summary()["samples"]}
    return summarise(facts, [group], {})


def _given(item: object) -> str:
    return f"a {type(item).__name__}" if isinstance(item, Run | Scenario) else shown(item)


def _refuse(loaded: dict[str, Run]) -> None:
    (first, one), *others = loaded.items()
    for label, run in loaded.items():
        if not len(run.rows):
            raise CdprError(f"{label}: contains no sample ({run.status})")
    for label, run in others:
        other = [name for name in SHARED if getattr(run.header, name) != getattr(one.header, name)]
        if other:
            names = ", ".join(f"{name.replace('_', ' ')}{_values(one.header, run.header, name)}" for name in other)
            raise CdprError(f"{label}: cannot be compared with {first}: other {names}")


def _values(a: Header, b: Header, name: str) -> str:
    one, other = getattr(a, name), getattr(b, name)
    return f" ({other} instead of {one})" if isinstance(one, (str, float)) else ""


def _read(label: str, run: Run) -> tuple[Engine, Scenario | None]:
    """Return the declared properties of the run's backend; UNKNOWN if its plugins are not installed."""
    try:
        there = Path(label) / SCENARIO_NAME  # file names in it are relative to its own folder
        scenario = load_scenario(there) if there.is_file() else load_scenario(label, text=run.header.scenario_yaml)
        return engine_of(scenario, run.header.backend), scenario
    except CdprError:
        return UNKNOWN, None


def _judge(label: str, judge: str, loaded: dict[str, Run], read: dict[str, tuple[Engine, Scenario | None]]) -> Verdict:
    run, (engine, scenario) = loaded[label], read[label]
    others = [judge, *(other for other in loaded if other not in (judge, label))]
    reason = "no other run has the same scheme and steps; run the comparison on the scenario for a verdict"
    for other in others:
        twin = read[other][0]
        same_step = loaded[other].header.physics_step == run.header.physics_step
        if scenario is None or not engine.scheme or (engine.scheme, engine.cables) != (twin.scheme, twin.cables):
            continue
        differing = [
            key
            for key, *_ in changes(loaded[other].header.scenario_yaml, run.header.scenario_yaml)
            if not key.startswith(ENGINE_KEYS)
        ]
        if same_step and not differing:
            return against_scheme(run, loaded[judge], loaded[other], continuous=is_continuous(scenario))
        reason = f"the scenario of {other} differs: {', '.join(differing[:3])}"
    return unjudged(run, loaded[judge], reason)
