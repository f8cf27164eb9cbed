"""Saving and checking of baselines; each scenario runs in its own process."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np

from cdpr.analysis.compare import baseline, baseline_file
from cdpr.analysis.compare.baseline import FIELDS, STATE, SUFFIX, Baseline, machine
from cdpr.analysis.compare.differences import QUANTITIES
from cdpr.analysis.compare.runs import Progress, RunResult, read
from cdpr.analysis.compare.scenarios import changes
from cdpr.analysis.jobs.pool import Case, Outcome, run_cases
from cdpr.base.errors import CdprError, ScenarioError
from cdpr.base.temporary import TemporaryFolder
from cdpr.log.files import NAME_OR_FORCE_IN_PYTHON, replace_all, require_new
from cdpr.log.run import Run
from cdpr.scenario import Scenario, load_scenario
from cdpr.scenario.repeatable import check_repeatable

Result = TypeVar("Result")


@dataclass(frozen=True)
class Checked:
    """Result of checking one baseline; `outcome` is "bit-equal", "within bounds" or "differs"."""

    name: str
    outcome: str
    detail: str = ""

    @property
    def agrees(self) -> bool:
        """True if the run reproduces the baseline."""
        return self.outcome != "differs"


def save(
    paths: Sequence[str],
    folder: Path,
    *,
    backends: Sequence[str] | None = None,
    overrides: Sequence[str] = (),
    jobs: int = 1,
    progress: Progress = lambda done, total: None,
    force: bool = False,
    remedy: str = NAME_OR_FORCE_IN_PYTHON,
) -> list[Path]:
    """Run scenarios and write their baselines into `folder`; return the files.

    Args:
        paths: scenario files.
        folder: folder of the baselines; created if necessary.
        backends: backends to use instead of each scenario's own.
        overrides: changes of the scenarios, `key=value`.
        jobs: number of processes.
        progress: called with the number of finished runs and the total.
        force: replace existing baselines.
        remedy: remedy in the message about an existing file.

    Raises:
        ScenarioError: if a scenario is invalid.
        PluginError: if a plugin is missing.
        OutputError: if a file exists without `force`, before the runs, or cannot be written.
        CdprError: if a run fails, or two baselines have one name; nothing is written then.
    """
    chosen: Sequence[str | None] = backends or [None]
    scenarios = [load_scenario(path, overrides=overrides, backend=backend) for path in paths for backend in chosen]
    for scenario in scenarios:
        check_repeatable(scenario, "a baseline")
    names = [baseline.file_name(scenario.name, scenario.simulation.backend) for scenario in scenarios]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise CdprError(f"two baselines would have the name {', '.join(twice)}: give each scenario a unique name")
    for name in names:
        require_new(folder / name, force, remedy)

    def keep(k: int, result: RunResult) -> Baseline | CdprError:
        if result.run is None or not result.complete:
            return CdprError(f"{scenarios[k].source}: no baseline of a run that {result.reason}")
        return baseline.make(result.run, scenarios[k], overrides, folder)

    kept = []
    for each in _run(scenarios, jobs, progress, keep):
        if isinstance(each, CdprError):
            raise each
        kept.append(each)
    replace_all(folder, {each.name: baseline_file.text_of(each) for each in kept}, force)
    return [folder / each.name for each in kept]


def check(folder: Path, *, jobs: int = 1, progress: Progress = lambda done, total: None) -> list[Checked]:
    """Repeat the run of every baseline in `folder` and return the results.

    Raises:
        CdprError: if there is no baseline or one cannot be read.
    """
    paths = sorted(folder.glob(f"*{SUFFIX}")) if folder.is_dir() else [folder]
    if not paths:
        raise CdprError(f"{folder}: contains no baseline (*{SUFFIX}); create baselines by `cdpr baseline save`")
    found: dict[str, Checked] = {}
    to_run: dict[str, tuple[Baseline, Scenario]] = {}
    for path in paths:
        kept = baseline_file.read(path)
        name = path.name.removesuffix(SUFFIX)
        try:
            scenario = _load(path.parent, kept)
        except CdprError as error:
            reason = str(error).partition("\n")[0]
            found[name] = Checked(name, "differs", f"the scenario cannot be loaded: {reason}")
            continue
        if changed := _changed(path.parent / kept.source, kept, scenario):
            found[name] = Checked(name, "differs", changed)
        else:
            to_run[name] = kept, scenario
    names = list(to_run)

    def judge(k: int, result: RunResult) -> Checked:
        return _judge(names[k], to_run[names[k]][0], result)

    found |= {one.name: one for one in _run([scenario for _, scenario in to_run.values()], jobs, progress, judge)}
    return [found[name] for name in sorted(found)]


def _load(folder: Path, kept: Baseline) -> Scenario:
    """Return the stored scenario; its relative file names refer to the folder of the original file."""
    scenario = load_scenario(folder / kept.source, text=kept.scenario_yaml)
    cables = kept.samples["tension"].shape[1]
    if len(scenario.robot.cables) != cables:
        raise CdprError(f"it has {len(scenario.robot.cables)} cables, the samples have {cables}")
    return scenario


def _changed(source: Path, kept: Baseline, before: Scenario) -> str:
    """Return the differences between the scenario file and the baseline; "" if none, or if the file is missing."""
    if not source.is_file():
        return ""
    try:
        now = load_scenario(source, overrides=kept.changes, backend=kept.backend)
    except ScenarioError as error:
        return f"the scenario {source} has changed and is now invalid: {error.problems[0]}"
    found = changes(before.resolved_yaml(), now.resolved_yaml())
    if not found:
        return ""
    described = ", ".join(f"{key} was {old}, is {new}" for key, old, new in found[:3])
    more = f" and {len(found) - 3} more" if len(found) > 3 else ""
    remedy = "if the change is intended, save the baseline again (--force)"
    return f"the scenario {source} has changed: {described}{more}; {remedy}"


def _run(
    scenarios: Sequence[Scenario], jobs: int, progress: Progress, take: Callable[[int, RunResult], Result]
) -> list[Result]:
    """Return the values of `take(index, run)` for all scenarios; the runs are not kept."""
    found: dict[str, Result] = {}
    progress(0, len(scenarios))
    with TemporaryFolder("cdpr-baseline-") as temporary:

        def done(outcome: Outcome) -> None:
            found[outcome.key] = take(int(outcome.key), read(outcome))
            progress(len(found), len(scenarios))

        cases = [
            Case(str(k), scenario.origin, {}, str(Path(temporary.path) / str(k)), scenario.resolved_yaml())
            for k, scenario in enumerate(scenarios)
        ]
        run_cases(cases, jobs=jobs, timeout=None, done=done)
    return [found[case.key] for case in cases]


def _judge(name: str, kept: Baseline, result: RunResult) -> Checked:
    run = result.run
    if run is None or run.status != kept.status:
        return Checked(name, "differs", f"the run was {kept.status} and is {result.reason}")
    if len(run.rows) != kept.count:
        return Checked(name, "differs", f"the run had {kept.count} samples and has {len(run.rows)}")
    if baseline.digest(run) == kept.digest:
        return Checked(name, "bit-equal")
    other = _others(kept, run)
    beyond, largest = _measure(kept, run)
    if beyond:
        return Checked(name, "differs", f"{beyond}{f' ({other})' if other else ''}")
    if not other:
        return Checked(name, "differs", f"not bit-equal, though versions and machine are the same; {largest}")
    return Checked(name, "within bounds", f"{largest} ({other})")


def _others(kept: Baseline, run: Run) -> str:
    """Return the versions and machine properties that differ."""
    pairs = [(kept.versions, run.header.versions), (kept.machine, machine())]
    return ", ".join(
        f"{key} {before.get(key, '-')} -> {now.get(key, '-')}"
        for before, now in pairs
        for key in sorted({*before, *now})
        if before.get(key) != now.get(key)
    )


def _measure(kept: Baseline, run: Run) -> tuple[str, str]:
    """Return the first quantity out of bounds ("" if none) and the largest difference of each quantity."""
    now = Run(run.header, run.rows[kept.indices])
    rows, columns = np.array(now.rows), now.header.layout.columns
    for field in FIELDS:
        rows[:, columns[field]] = kept.samples[field].reshape(len(rows), -1)
    before = dataclasses.replace(now, rows=rows)
    beyond, largest = "", []
    for name in STATE:
        quantity = QUANTITIES[name]
        with np.errstate(all="ignore"):
            values = quantity.apart(before, now)
        worst = float(values.max())
        if worst > 0.0:
            largest.append(f"{quantity.title} {worst:.1e} {quantity.unit}")
        bound = kept.bounds.get(name)
        if not beyond and bound is not None and not worst <= bound:
            first = int(np.argmax(~(values <= bound)))
            which = _cable(before, now, first) if name == "tension" else quantity.title
            beyond = (
                f"{which} differs first at t = {now.time[first]:.6g} s, by {values[first]:.2e} {quantity.unit} "
                f"(allowed {bound:.0e}), most at {now.time[int(values.argmax())]:.6g} s, by {worst:.2e} {quantity.unit}"
            )
    return beyond, "largest differences: " + (", ".join(largest) or "none in the samples kept in digits")


def _cable(before: Run, now: Run, sample: int) -> str:
    worst = int(np.abs(before.tension[sample] - now.tension[sample]).argmax())
    return f"tension of {now.header.cables[worst]}"
