"""Table of a study as text, for terminal and page."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from cdpr.analysis.study.points import Label
from cdpr.analysis.study.table import Cell
from cdpr.ui.report.style import LEAST_ERROR
from cdpr.ui.report.text.aligned import digits

Record = Mapping[str, Cell]


@dataclass(frozen=True)
class Figure:
    """Column of the table in a readable unit.

    Values below `least`, in that unit, are round-off; figures do not zoom into them.
    """

    column: str
    title: str
    heading: str  # short
    scale: float = 1.0
    least: float = 0.0


LEAST_FORCE = 1e-3  # N: typical accuracy of iterative solvers at tensions of a kilonewton

FIGURES = (
    Figure("position_error_max_m", "Largest position error (mm)", "max mm", 1e3, LEAST_ERROR),
    Figure("position_error_rms_m", "Position error, rms (mm)", "rms mm", 1e3, LEAST_ERROR),
    Figure("orientation_error_max_rad", "Largest orientation error (mrad)", "max mrad", 1e3, LEAST_ERROR),
    Figure("tension_max_N", "Largest tension (N)", "max N", 1.0, LEAST_FORCE),
    Figure("tension_min_N", "Smallest tension (N)", "min N", 1.0, LEAST_FORCE),
    Figure("tension_largest_step_N", "Largest tension step (N)", "step N", 1.0, LEAST_FORCE),
    Figure("infeasible_steps", "Samples without admissible tensions", "infeasible", 1.0, 1.0),
    Figure("unanswered_steps", "Samples without a valid solution", "unanswered", 1.0, 1.0),
)
# Of scenarios with an estimator.
ESTIMATE = (
    Figure("estimate_position_error_rms_m", "Error of the estimated position, rms (mm)", "est mm", 1e3, LEAST_ERROR),
    Figure("estimate_nis_mean_per_value", "NIS, mean per value", "NIS"),
    Figure("estimate_nees_mean_per_value", "NEES, mean per value", "NEES"),
)


def figures_of(records: Sequence[Record]) -> tuple[Figure, ...]:
    """Return the figures of these cases: those of estimates only if a case has one."""
    return (*FIGURES, *(each for each in ESTIMATE if any(record.get(each.column) is not None for record in records)))


def value(record: Record, figure: Figure) -> float | None:
    """Return the value of a case in the unit of the figure; None if it has none."""
    cell = record.get(figure.column)
    return None if cell is None or isinstance(cell, str) else figure.scale * cell


def cells(axes: Iterable[str], record: Record, figures: Sequence[Figure]) -> tuple[list[str], list[str]]:
    """Return the cells of a case: axis values and status, and its figures."""
    values = [value(record, figure) for figure in figures]
    labels = [label_text(record[axis]) for axis in axes]
    return [*labels, str(record["status"])], ["-" if cell is None else digits(cell) for cell in values]


def label_text(label: Label) -> str:
    """Return an axis value as text."""
    if label is None:
        return "-"
    return f"{label:.6g}" if isinstance(label, float) else str(label)
