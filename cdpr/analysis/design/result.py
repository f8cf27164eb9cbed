"""Result of a design: evaluations, best candidate, and output files."""

from __future__ import annotations

import csv
import io
import json
import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from cdpr.analysis.design.evaluations import FIRST, Row
from cdpr.analysis.design.plan import Design, keys_text
from cdpr.analysis.design.rank import best, dominance, front, missed
from cdpr.base.checksums import sealed
from cdpr.base.errors import ExitCode
from cdpr.log.files import make_folder, replace
from cdpr.model import Robot

FORMAT = "cdpr design 1"
KIND, NAME, TABLE, BEST, FRONT = "design", "design.json", "evaluations.csv", "best.yaml", "front"


@dataclass(frozen=True, eq=False)
class Designed:
    """Result of a design.

    Attributes:
        design: the design.
        folder: its folder.
        rows: evaluations in order; the first is the unchanged robot.
        versions: versions of the software that computed it.
    """

    design: Design
    folder: Path
    rows: tuple[Row, ...]
    versions: Mapping[str, str]

    def __repr__(self) -> str:
        return f"<Designed {self.design.name}: {len(self.rows) - FIRST} candidates, {self.feasible} feasible>"

    @property
    def before(self) -> Row:
        """Evaluation of the unchanged robot."""
        return self.rows[0]

    @cached_property
    def best(self) -> Row:
        """Best candidate; with several goals a compromise, see `cdpr.analysis.design.rank.best`."""
        return self.rows[FIRST + best([row.score for row in self.rows[FIRST:]])]

    @cached_property
    def front(self) -> list[Row]:
        """Feasible non-dominated candidates with several goals; empty with one goal."""
        if len(self.design.section.wanted) < 2:
            return []
        return [self.rows[FIRST + i] for i in front([row.score for row in self.rows[FIRST:]])]

    @property
    def feasible(self) -> int:
        """Number of candidates that satisfy all constraints."""
        return sum(row.score.feasible for row in self.rows[FIRST:])

    @property
    def improved(self) -> bool:
        """True if a candidate is better than the unchanged robot; with several goals, if one dominates it."""
        scores = [self.before.score, *(row.score for row in self.front or [self.best])]
        return bool(dominance(scores)[:, 0].any())

    @property
    def refused(self) -> list[Row]:
        """Candidates with invalid robots."""
        return [row for row in self.rows[FIRST:] if row.figures is None]

    @property
    def exit_code(self) -> ExitCode:
        """OK if a candidate satisfies all constraints."""
        return ExitCode.OK if self.feasible else ExitCode.INFEASIBLE

    def robot(self, row: Row) -> Robot:
        """Return the robot of an evaluation.

        Raises:
            ScenarioError: if it is invalid.
        """
        return self.design.candidate(row.values)

    def goals(self, row: Row) -> list[float | None]:
        """Return the values of the goals, without the sign change of maximised goals; None for a missing value."""
        found = []
        for goal in self.design.section.wanted:
            parts = [None if row.figures is None else row.figures[term.figure].value for term in goal.terms]
            known = [part for part in parts if part is not None]
            terms = zip(known, goal.terms, strict=False)
            total = sum(term.weight * value / term.scale for value, term in terms)
            found.append(total if len(known) == len(parts) else None)
        return found

    def to_dict(self) -> dict[str, Any]:
        """Return the result as plain data, independent of the folder and the number of jobs."""
        design, section = self.design, self.design.section
        variables = zip(section.vary, design.targets, design.start.tolist(), strict=True)
        return {
            "format": FORMAT,
            "name": design.name,
            "cases": section.optimizer.evaluations,
            "digest": design.digest,
            "robot": section.robot,
            "optimizer": section.optimizer.model_dump(exclude_none=True) | {"type": design.search},
            "versions": dict(self.versions),
            "variables": [
                {"name": variable.label, "keys": keys_text(targets), "bounds": list(variable.bounds), "start": start}
                for variable, targets, start in variables
            ],
            "goals": [goal.label for goal in section.wanted],
            "constraints": [limit.label for limit in section.constraints],
            "units": {name: self._unit(name) for name in design.figures},
            "candidates": len(self.rows) - FIRST,
            "feasible": self.feasible,
            "refused": len(self.refused),
            "improved": self.improved,
            "before": self._row_dict(self.before),
            "best": self._row_dict(self.best),
            "front": [self._row_dict(row) for row in self.front],
        }

    def write(self) -> None:
        """Write design.json, the table and the robot files.

        Raises:
            OutputError: if a file cannot be written.
        """
        folder = self.folder
        replace(folder / TABLE, self._csv())
        self._robot(self.best, folder / BEST)
        shutil.rmtree(folder / FRONT, ignore_errors=True)
        if self.front:
            make_folder(folder / FRONT)
        for row in self.front:
            self._robot(row, folder / FRONT / f"{row.number}.yaml")
        replace(folder / NAME, json.dumps(sealed(self.to_dict()), indent=1, allow_nan=False) + "\n")

    def _robot(self, row: Row, path: Path) -> None:
        comment = f"Evaluation {row.number} of the design {self.design.name}, by cdpr design."
        replace(path, self.design.robot_yaml(row.values, str(path.parent), comment))

    def _unit(self, name: str) -> str:
        figure, region = self.design.figures[name], self.design.place.region
        return region.unit if figure.section.volume and region is not None else figure.unit

    def _row_dict(self, row: Row) -> dict[str, Any]:
        labels, limits = self.design.labels, self.design.section.constraints
        values = None if row.values is None else dict(zip(labels, row.values.tolist(), strict=True))
        figures = row.figures or {}
        return {
            "number": row.number,
            "values": values,
            "figures": {name: figures[name].value if figures else None for name in self.design.figures},
            "missing": {name: found.missing for name, found in figures.items() if found.missing},
            "goals": self.goals(row),
            "feasible": row.score.feasible,
            "violation": row.score.violation,
            "violated": [limit.label for limit in limits if figures and missed(limit, figures[limit.figure]) > 0.0],
            "refused": row.refused,
        }

    def _csv(self) -> bytes:
        """Return the table; cells of missing figures are empty."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        labels, names = self.design.labels, list(self.design.figures)
        goals = ["goal", *(f"goal {k}" for k in range(2, len(self.design.section.wanted) + 1))]
        writer.writerow(["number", *labels, *names, *goals, "feasible", "violation", "refused"])
        for row in self.rows:
            values = [""] * len(labels) if row.values is None else map(repr, row.values.tolist())
            figures = [None if row.figures is None else row.figures[name].value for name in names]
            numbers = ["" if each is None else repr(each) for each in (*figures, *self.goals(row))]
            known = ("true" if row.score.feasible else "false", repr(row.score.violation), row.refused)
            writer.writerow([row.number, *values, *numbers, *known])
        return text.getvalue().encode()
