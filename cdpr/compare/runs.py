"""The runs of a comparison: each made once, those of each engine in processes of its own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from cdpr.errors import ExitCode, OutputError
from cdpr.jobs.pool import Case, Outcome, run_cases
from cdpr.log.reader import load_run
from cdpr.log.run import FORESEEN, Run
from cdpr.log.run_folder import safe_name
from cdpr.scenario import Scenario

Progress = Callable[[int, int], None]  # runs done, and runs in all


@dataclass(frozen=True)
class Wanted:
    """One run: a backend with a solver, perhaps with another scheme, another step or another control period."""

    backend: str
    solver: str
    scheme: str = ""  # "" for the scenario's
    divide: int = 0  # the control period holds this many physics steps; 0 for the scenario's
    stretch: int = 1  # the control period is the scenario's times this

    @property
    def key(self) -> str:
        """Name of the run and of its folder."""
        parts = [self.backend, self.solver, self.scheme]
        parts += [f"stretch{self.stretch}"] if self.stretch > 1 else []
        parts += [f"divide{self.divide}"] if self.divide else []
        return safe_name("_".join(part for part in parts if part))

    def changes(self, scenario: Scenario) -> dict[str, Any]:
        """Return what differs from the scenario, by dotted key."""
        given = scenario.simulation
        control = given.control_step * self.stretch
        changes: dict[str, Any] = {"simulation.backend": self.backend, "solver.type": self.solver}
        if scenario.sections.log is not None:  # every sample is compared, not those alone that the log would keep
            changes["log.step"] = control
        if self.scheme:
            changes[f"backend_options.{self.backend}.scheme"] = self.scheme
        if self.stretch > 1:
            changes["simulation.control_step"] = control
            changes["simulation.duration"] = (given.steps // self.stretch) * control
        if self.divide or self.stretch > 1:
            changes["simulation.physics_step"] = control / (self.divide or given.substeps)
        return changes


@dataclass(frozen=True)
class Made:
    """What came of one: the run where there is one, and how its process ended."""

    run: Run | None
    status: str
    message: str
    begun: bool = True  # whether there was a first sample

    @property
    def complete(self) -> bool:
        """Whether there is a run to its end, or to where the scenario says that it ends."""
        return self.run is not None and self.status in FORESEEN

    @property
    def reason(self) -> str:
        """How it ended, and the first line of why."""
        first = self.message.partition("\n")[0]
        return f"{self.status}: {first}" if first else self.status


class Runs:
    """Makes runs of one scenario and keeps them in a folder.

    Args:
        scenario: what to run.
        folder: where the run folders go.
        jobs: how many processes at a time.
        timeout: s of a run after which it counts as hung, None for no limit.
        progress: called when a run has ended.
    """

    def __init__(self, scenario: Scenario, folder: Path, jobs: int, timeout: float | None, progress: Progress) -> None:
        self.scenario = scenario
        self._text = scenario.resolved_yaml()
        self._folder, self._jobs, self._timeout, self._progress = folder, jobs, timeout, progress
        self._ended: dict[Wanted, Outcome] = {}
        self._asked = 0

    def __getitem__(self, wanted: Wanted) -> Made:
        """Read a run that has been made; only its user keeps it in memory."""
        return read(self._ended[self._plain(wanted)])

    def make(self, wanted: Sequence[Wanted]) -> None:
        """Make the runs that have not been made yet, those of each engine in processes that no other engine sees."""
        fresh = {one.key: one for one in map(self._plain, wanted) if one not in self._ended}
        self._asked += len(fresh)
        self._progress(len(self._ended), self._asked)

        def done(outcome: Outcome) -> None:
            self._ended[fresh[outcome.key]] = outcome
            self._progress(len(self._ended), self._asked)

        for backend in dict.fromkeys(one.backend for one in fresh.values()):
            cases = [
                Case(key, self.scenario.source, one.changes(self.scenario), str(self._folder / key), self._text)
                for key, one in fresh.items()
                if one.backend == backend
            ]
            run_cases(cases, jobs=self._jobs, timeout=self._timeout, done=done)

    def _plain(self, wanted: Wanted) -> Wanted:
        """The same run as it is known: with the scenario's own step, where it has that."""
        own = wanted.stretch == 1 and wanted.divide == self.scenario.simulation.substeps
        return replace(wanted, divide=0) if own else wanted


def read(outcome: Outcome) -> Made:
    """Load the run of a case that has ended, however it ended.

    Raises OutputError where it could not be written: a full disk says nothing of an engine.
    """
    if outcome.code == ExitCode.NOT_WRITABLE:
        raise OutputError(outcome.reason)
    complete = outcome.status in (*FORESEEN, "diverged")
    run = load_run(outcome.folder) if complete else None
    return Made(run, outcome.status, outcome.message, bool(outcome.summary.get("samples")))
