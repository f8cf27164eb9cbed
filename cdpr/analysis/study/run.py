"""Execution of the remaining cases of a study."""

from __future__ import annotations

import os
import shutil
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from cdpr.analysis.jobs.folder import LEDGER_NAME, RESULTS
from cdpr.analysis.jobs.pool import Case, Executor, Outcome, run_cases
from cdpr.analysis.study.folder import StudyFolder
from cdpr.analysis.study.plan import Study, StudyCase
from cdpr.analysis.study.spread import Spread, spread_table, spreads
from cdpr.analysis.study.table import Table, make_table, times, to_csv, to_parquet
from cdpr.base.errors import ExitCode, OutputError, PluginError
from cdpr.log.files import replace as write
from cdpr.log.run_folder import folder_name


@dataclass(frozen=True)
class Results:
    """Result of a study; `rows` are the ledger's entries by case id."""

    study: Study
    folder: Path
    rows: Mapping[str, Outcome]
    table: Table

    def __repr__(self) -> str:
        return f"<Results of {self.study.name}: {self.summary_text}>"

    @property
    def counts(self) -> dict[str, int]:
        """Number of cases by status."""
        status = self.table.columns.index("status")
        return dict(Counter(str(row[status]) for row in self.table.rows))

    @property
    def summary_text(self) -> str:
        """Summary of the outcomes in words."""
        text = ", ".join(f"{count} {status}" for status, count in self.counts.items())
        return text + (f"; {self.strained} with samples without valid tensions" if self.strained else "")

    @property
    def spreads(self) -> list[Spread]:
        """Mean and spread over the seeds for each combination of the other axes; empty without an axis of seeds."""
        return spreads(self.study, self.table)

    @property
    def spread(self) -> Table | None:
        """The same as a table, the content of spread.csv; None without an axis of seeds."""
        return spread_table(self.study, self.table)

    @property
    def strained(self) -> int:
        """Number of finished cases with infeasible samples or solver failures."""
        rows = [self.rows[case.id] for case in self.study.cases]
        figures = ("infeasible_steps", "unanswered_steps")
        return sum(row.status == "finished" and any(row.summary.get(figure) for figure in figures) for row in rows)

    @property
    def exit_code(self) -> ExitCode:
        """OK if every case has a result, of whatever kind."""
        lost = [self.rows[case.id] for case in self.study.cases if self.rows[case.id].status not in RESULTS]
        if any(row.status != "failed" for row in lost):
            return ExitCode.BACKEND_DIED
        return lost[0].code if lost else ExitCode.OK


def run_study(
    study: Study,
    out: str | os.PathLike[str],
    *,
    jobs: int = 1,
    timeout: float | None = None,
    executor: Executor | None = None,
    progress: Callable[[int, int, Mapping[str, int]], None] = lambda done, total, counts: None,
    say: Callable[[str], None] = lambda text: None,
) -> Results:
    """Run the remaining cases of a study and write the tables.

    Failed, died and hung cases are run again. A case that dies is retried once before it counts as died. The results do
    not depend on `jobs`, the executor or interruptions. KeyboardInterrupt ends the workers; finished cases are kept.

    Args:
        study: the study.
        out: its folder.
        jobs: number of worker processes.
        timeout: time limit of a case, s.
        executor: replacement of the worker pool, such as a cluster.
        progress: called with the number of ended cases, their total, and their number by status.
        say: called with messages for the user.

    Returns:
        The rows of all cases; the tables are in `out`.

    Raises:
        OutputError: if `out` contains another study or cannot be written.

    Example:
        >>> import pathlib
        >>> import tempfile
        >>> from cdpr.analysis.study import load_study, run_study
        >>> text = "{scenario: planar, axes: [{key: controller.kp, values: [50, 100]}]}"
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     _ = pathlib.Path(folder, "study.yaml").write_text(text)
        ...     study = load_study(f"{folder}/study.yaml", overrides={"simulation.duration": 0.02})
        ...     results = run_study(study, f"{folder}/out")
        ...     print(results)
        <Results of study: 2 finished>
    """
    out = folder_name(out)
    folder = StudyFolder(out, study)
    try:
        before = other_versions(study, folder.rows)
        if before:
            say(f"{out}: its cases were computed by other versions: {before}")
        ended = {key for key, row in folder.rows.items() if row.status in RESULTS}
        waiting = [case for case in study.cases if case.id not in ended]
        if any(not case.text for case in waiting):
            raise OutputError(f"{out}: its {LEDGER_NAME} lost results since it was read; the same command continues")
        counts = Counter(folder.rows[key].status for key in ended)
        execute = executor or (lambda cases, **options: run_cases(cases, jobs=jobs, **options))

        def done(outcome: Outcome) -> None:
            if study.keep == "failed" and outcome.status == "finished":
                shutil.rmtree(outcome.folder, ignore_errors=True)
                outcome = replace(outcome, folder="")
            if outcome.key in ended:  # second attempt
                counts["died"] -= 1
            folder.record(outcome)
            ended.add(outcome.key)
            counts[outcome.status] += 1
            progress(len(ended), len(study.cases), counts)

        try:
            progress(len(ended), len(study.cases), counts)
            execute([_case(case, study, folder) for case in waiting], timeout=timeout, done=done)
            again = [case for case in waiting if folder.rows[case.id].status == "died"]
            if again:
                say(f"{len(again)} case{'s' * (len(again) != 1)} died; trying again")
                execute([_case(case, study, folder) for case in again], timeout=timeout, done=done)
            after = other_versions(study, folder.rows)
            if after not in ("", before):
                say(f"computed by other versions than those here: {after}")
        finally:
            table = make_table(study, folder.rows)
            _write(out, table, spread_table(study, table), times(study, folder.rows), say)
        return Results(study, out, folder.rows, table)
    finally:
        folder.close()


def other_versions(study: Study, rows: Mapping[str, Outcome]) -> str:
    """Return which cases were computed by versions other than those here, in words; "" if none."""
    found: Counter[str] = Counter()
    for case in study.cases:
        theirs = rows[case.id].versions if case.id in rows else {}
        for name, version in theirs.items():
            here = case.versions.get(name, "none")
            if version != here:
                found[f"{name} {version}, here {here}"] += 1
    return "; ".join(f"{text} ({count} case{'s' * (count != 1)})" for text, count in sorted(found.items()))


def _case(case: StudyCase, study: Study, folder: StudyFolder) -> Case:
    out = None if study.keep == "none" else str(folder.run_folder(case.id).absolute())
    return Case(case.id, case.scenario, out=out, text=case.text)


def _write(out: Path, table: Table, spread: Table | None, wall_clock: Table, say: Callable[[str], None]) -> None:
    write(out / "table.csv", to_csv(table))
    if spread is not None:
        write(out / "spread.csv", to_csv(spread))
    write(out / "times.csv", to_csv(wall_clock))
    try:
        write(out / "table.parquet", to_parquet(table))
    except PluginError as error:
        say(f"no table.parquet: {error}")
