"""Evaluations of a design: each is computed once and immediately recorded in the folder's ledger."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from threading import Lock

import numpy as np

from cdpr.analysis.design.evaluate import Value
from cdpr.analysis.design.plan import Design
from cdpr.analysis.design.rank import Score, score
from cdpr.analysis.jobs.cases import Outcome
from cdpr.analysis.jobs.folder import LEDGER_NAME, JobFolder
from cdpr.base.errors import CdprError, LogError
from cdpr.model.robot import Array

FIRST = 1  # number of the first candidate; 0 is the unchanged robot


class SpentError(Exception):
    """Exhausted budget of evaluations."""


@dataclass(frozen=True, eq=False)
class Row:
    """One evaluation.

    Attributes:
        number: index in the order of the search; 0 for the unchanged robot.
        values: (n,), values of the variables; None for the unchanged robot.
        figures: figures by name; None if the robot is invalid.
        refused: reason why the robot is invalid.
        score: score of the candidate.
    """

    number: int
    values: Array | None
    figures: dict[str, Value] | None
    refused: str
    score: Score


class Evaluations:
    """Evaluator of candidates, in threads or from the ledger.

    Attributes:
        rows: evaluations in the order of their numbers.
    """

    def __init__(self, design: Design, folder: JobFolder, jobs: int, progress: Callable[[int, int], None]) -> None:
        self._design, self._folder, self._progress = design, folder, progress
        self._most = design.section.optimizer.evaluations
        self._lock, self._pool = Lock(), ThreadPoolExecutor(jobs, "cdpr-design")
        self._known = len(folder.rows)
        self.rows = [self._one(0, None)]

    def close(self) -> None:
        """Wait for running evaluations and start no others."""
        self._pool.shutdown(cancel_futures=True)

    def __call__(self, shares: Array) -> list[Score]:
        """Return the scores of candidates (k, n), given as shares of the range from lower to upper bounds.

        Raises:
            SpentError: if the budget is exhausted; candidates within the budget are evaluated first.
        """
        first = len(self.rows)
        room = self._most - first + FIRST
        low, high = self._design.bounds
        values = np.clip(low + np.asarray(shares) * (high - low), low, high)[:room]
        found = list(self._pool.map(self._one, range(first, first + len(values)), values))
        self.rows += found
        if len(shares) >= room:
            raise SpentError
        return [row.score for row in found]

    def _one(self, number: int, values: Array | None) -> Row:
        known = self._folder.rows.get(str(number))
        if known is None:
            known = self._evaluated(number, values)
            with self._lock:
                self._folder.record(known)
                self._known = max(self._known, len(self._folder.rows))
                self._progress(self._known - FIRST, self._most)
        try:
            return self._row(number, values, known)
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            path = self._folder.path / LEDGER_NAME
            raise LogError(f"{path}: evaluation {number} cannot be read ({error}); choose another folder") from error

    def _evaluated(self, number: int, values: Array | None) -> Outcome:
        given = None if values is None else values.tolist()
        try:
            found = self._design.measure(values)
        except CdprError as error:
            return Outcome(str(number), "failed", str(error), "", {"values": given})
        figures = {name: [each.value, each.missing] for name, each in found.items()}
        return Outcome(str(number), "finished", "", "", {"values": given, "figures": figures})

    def _row(self, number: int, values: Array | None, known: Outcome) -> Row:
        """Return an evaluation from its ledger entry only, so that replayed and new evaluations are identical."""
        if known.summary["values"] != (None if values is None else values.tolist()):
            path = self._folder.path / LEDGER_NAME
            raise LogError(f"{path}: evaluation {number} belongs to a different candidate than the search requests")
        if known.status == "failed":
            return Row(number, values, None, known.reason, score(self._design.section, None))
        figures = {}
        for name in self._design.figures:
            value, missing = known.summary["figures"][name]
            figures[name] = Value(None if value is None else float(value), float(missing))
        return Row(number, values, figures, "", score(self._design.section, figures))
