"""Runs of a comparison: each is computed once, and engines never share a process."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from cdpr.analysis.jobs.pool import Case, Outcome, run_cases
from cdpr.base.errors import ExitCode, OutputError
from cdpr.log.reader import load_run
from cdpr.log.run import FORESEEN, Run
from cdpr.log.run_folder import safe_name
from cdpr.scenario import Scenario

Progress = Callable[[int, int], None]  # finished runs and total


@dataclass(frozen=True)
class RunSpec:
    """One run: backend and solver, optionally with another scheme, step or control period."""

    backend: str
    solver: str
    scheme: str = ""  # "" for the scenario's
    divide: int = 0  # physics steps per control period; 0 for the scenario's
    stretch: int = 1  # factor of the control period

    @property
    def key(self) -> str:
        """Name of the run and of its folder."""
        parts = [self.backend, self.solver, self.scheme]
        parts += [f"stretch{self.stretch}"] if self.stretch > 1 else []
        parts += [f"divide{self.divide}"] if self.divide else []
        return safe_name("_".join(part for part in parts if part))

    def changes(self, scenario: Scenario) -> dict[str, Any]:
        """Return the changes of the scenario by dotted key."""
        given = scenario.simulation
        control = given.control_step * self.stretch
        changes: dict[str, Any] = {"simulation.backend": self.backend, "solver.type": self.solver}
        if scenario.sections.log is not None:  # compare every sample, not only the logged ones
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
class RunResult:
    """Result of one run: its log, if any, and its final status."""

    run: Run | None
    status: str
    message: str
    begun: bool = True  # False if there is no first sample

    @property
    def complete(self) -> bool:
        """True if the run reached its end, or an end that the scenario foresees."""
        return self.run is not None and self.status in FORESEEN

    @property
    def reason(self) -> str:
        """Final status and the first line of the message."""
        first = self.message.partition("\n")[0]
        return f"{self.status}: {first}" if first else self.status


class Runs:
    """Runs of one scenario, kept in a folder.

    Args:
        scenario: scenario to run.
        folder: parent of the run folders.
        jobs: number of processes.
        timeout: time after which a run counts as hung, s; None for no limit.
        progress: called when a run has ended.
    """

    def __init__(self, scenario: Scenario, folder: Path, jobs: int, timeout: float | None, progress: Progress) -> None:
        self.scenario = scenario
        self._text = scenario.resolved_yaml()
        self._folder, self._jobs, self._timeout, self._progress = folder, jobs, timeout, progress
        self._ended: dict[RunSpec, Outcome] = {}
        self._requested = 0

    def __getitem__(self, wanted: RunSpec) -> RunResult:
        """Load a finished run; it is not cached."""
        return read(self._ended[self._canonical(wanted)])

    def make(self, wanted: Sequence[RunSpec]) -> None:
        """Compute the missing runs; each engine has its own processes."""
        fresh = {one.key: one for one in map(self._canonical, wanted) if one not in self._ended}
        self._requested += len(fresh)
        self._progress(len(self._ended), self._requested)

        def done(outcome: Outcome) -> None:
            self._ended[fresh[outcome.key]] = outcome
            self._progress(len(self._ended), self._requested)

        for backend in dict.fromkeys(one.backend for one in fresh.values()):
            cases = [
                Case(key, self.scenario.origin, one.changes(self.scenario), str(self._folder / key), self._text)
                for key, one in fresh.items()
                if one.backend == backend
            ]
            run_cases(cases, jobs=self._jobs, timeout=self._timeout, done=done)

    def _canonical(self, wanted: RunSpec) -> RunSpec:
        """Return the run in its unique form: the scenario's own step is written as `divide=0`."""
        own = wanted.stretch == 1 and wanted.divide == self.scenario.simulation.substeps
        return replace(wanted, divide=0) if own else wanted


def read(outcome: Outcome) -> RunResult:
    """Load the run of a finished case, whatever its status.

    Raises:
        OutputError: if it could not be written; a full disk is no fault of the engine.
    """
    if outcome.code == ExitCode.NOT_WRITABLE:
        raise OutputError(outcome.reason)
    complete = outcome.status in (*FORESEEN, "diverged")
    run = load_run(outcome.folder) if complete else None
    return RunResult(run, outcome.status, outcome.message, bool(outcome.summary.get("samples")))
