"""Complete comparison: from a scenario file to figures, with the runs for plotting."""

from __future__ import annotations

import contextlib
import os
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cdpr.analysis.compare.comparison import Group, compare
from cdpr.analysis.compare.engines import field
from cdpr.analysis.compare.refinement import Measured
from cdpr.analysis.compare.refinement import refine as measure_orders
from cdpr.analysis.compare.runs import Progress, Runs
from cdpr.base.temporary import TemporaryFolder
from cdpr.config.overrides import Overrides
from cdpr.config.problems import judged
from cdpr.log.run_folder import claim, folder_name
from cdpr.log.run_json import to_json
from cdpr.scenario.loader import AnyScenario, load_scenario
from cdpr.scenario.repeatable import check_repeatable
from cdpr.simulation.needs import require

RUNS = "runs"
RESERVED = "compare.json.tmp"  # reserves a folder until compare.json is written


@dataclass(frozen=True)
class Comparison:
    """Result of a comparison.

    Attributes:
        figures: all results as plain data for JSON.
        groups: the same with the runs, for plotting.
    """

    figures: dict[str, Any]
    groups: tuple[Group, ...]

    def __repr__(self) -> str:
        verdict = {True: "the engines agree", False: "the engines disagree", None: "differences not judged"}
        return f"<Comparison of {self.figures['scenario']}: {verdict[self.figures['agrees']]}>"


def compare_scenario(
    path: AnyScenario,
    *,
    changes: Overrides = (),
    strict: bool = False,
    backends: Sequence[str] | None = None,
    solvers: Sequence[str] | None = None,
    refine: bool = False,
    out: str | os.PathLike[str] | None = None,
    jobs: int | None = None,
    timeout: float | None = None,
    progress: Progress = lambda done, total: None,
    say: Callable[[str], None] = lambda text: None,
) -> Comparison:
    """Run a scenario on several engines and judge them.

    Args:
        path: scenario file, name of an example, dict or Scenario.
        changes: overrides, as in `load_scenario`.
        strict: treat warnings as errors, before anything runs.
        backends: engines; all installed ones by default. The judge always runs.
        solvers: tension solvers instead of the scenario's; engines are compared with each of them.
        refine: also measure the orders of convergence.
        out: new or empty folder; runs are kept in its subfolder `runs`. It is restored if the comparison does not
            finish.
        jobs: number of processes; one per core by default.
        timeout: time limit of a run, s.
        progress: called with the number of finished runs and the total.
        say: called with each note and warning of the scenario.

    Returns:
        The results of all engines, and the verdict in `figures["agrees"]`: True, False, or None if nothing was
        judged.

    Raises:
        ScenarioError, PluginError, OutputError: as `cdpr.simulate` does.
        CdprError: if only one engine is left.

    Example:
        >>> from cdpr.analysis.compare.job import compare_scenario
        >>> compare_scenario("remote_plant", changes=["simulation.duration=0.02"], backends=["remote"])
        <Comparison of remote_plant: differences not judged>
    """
    scenario = load_scenario(path, overrides=changes)
    for note in (*scenario.notes, *judged(scenario.warnings, strict=strict)):
        say(note)
    check_repeatable(scenario, "a comparison")
    require(scenario, "compare")
    chosen = field(scenario, backends)
    names = list(dict.fromkeys(solvers or [scenario.solver.type]))
    for name in names:
        # report problems of a solver before anything runs
        for note in scenario.with_changes(solver=name).notes[len(scenario.notes) :]:
            say(note)
    with TemporaryFolder("cdpr-compare-") as temporary:
        folder = Path(temporary.path) if out is None else folder_name(out)
        with _claimed(folder):
            runs = Runs(scenario, folder / RUNS, jobs or os.cpu_count() or 1, timeout, progress)
            groups = compare(runs, chosen, names, named=backends is not None)
            orders = {name: measure_orders(runs, chosen, name) for name in names} if refine else {}
    simulation = scenario.simulation
    figures = {
        "scenario": scenario.name,
        "robot": scenario.robot.name,
        "duration_s": simulation.duration,
        "control_step_s": simulation.control_step,
        "physics_step_s": simulation.physics_step,
        "judge": {"backend": chosen.judge.name, "order": chosen.judge.order},
        "absent": chosen.absent,
    }
    return summarise(figures, groups, orders)


@contextlib.contextmanager
def _claimed(folder: Path) -> Iterator[None]:
    """Claim a folder, and remove its new content if the comparison is interrupted or fails."""
    new = not folder.exists()
    claim(folder, RESERVED)
    try:
        yield
    except BaseException:
        shutil.rmtree(folder / RUNS, ignore_errors=True)
        with contextlib.suppress(OSError):
            (folder / RESERVED).unlink()
            if new:
                folder.rmdir()
        raise


def summarise(
    facts: Mapping[str, Any], groups: Sequence[Group], orders: Mapping[str, Sequence[Measured]]
) -> Comparison:
    """Return the complete result; `facts` describe the compared scenario."""
    tables = []
    for group in groups:
        measured = orders.get(group.solver, ())
        lost = any(each.failed for each in measured)
        agrees = False if lost else group.agrees
        tables.append({**group.to_dict(), "agrees": agrees, "orders": [each.to_dict() for each in measured]})
    verdicts = [table["agrees"] for table in tables]
    agrees = False if False in verdicts else True if True in verdicts else None
    figures = {"agrees": agrees, **facts, "groups": tables, "versions": _versions(groups)}
    return Comparison(to_json(figures), tuple(groups))


def _versions(groups: Sequence[Group]) -> dict[str, str]:
    """Return the versions of all software used."""
    versions: dict[str, str] = {}
    for group in groups:
        for run in (group.judge, *(row.run for row in group.rows)):
            versions |= {} if run is None else run.header.versions
    return versions
