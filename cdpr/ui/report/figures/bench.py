"""Benchmark figure: solution time, coverage and jumps of all solvers on one robot."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from cdpr.ui.report.figures.canvas import Axes, Chart, Line2D, styled
from cdpr.ui.report.style import CABLES, INK, SOFT, shorten
from cdpr.ui.report.text.bench import jumps, percent

Row = Mapping[str, Any]

# Lengths in inches.
WIDTH, LEFT, TOP, BOTTOM, LINE = 8.0, 1.55, 0.32, 0.42, 0.2
PANELS = {"time": (0.0, 2.55), "coverage": (2.75, 1.6), "jumps": (4.6, 1.6)}  # offset from LEFT, and width

BLUE, RED = CABLES[0], CABLES[2]


@styled
def robot(found: Row) -> Chart:
    """Draw one line for each solver in `found`, one of the robots that `cdpr.analysis.bench.run` returns."""
    rows = list(found["results"])
    inner = LINE * max(len(rows), 1)
    height = TOP + inner + BOTTOM
    chart = Chart(figsize=(WIDTH, height))
    for name, draw in (("time", _times), ("coverage", _coverage), ("jumps", _jumps)):
        left, width = PANELS[name]
        axes = chart.add_axes(((LEFT + left) / WIDTH, BOTTOM / height, width / WIDTH, inner / height))
        axes.set_ylim(len(rows) - 0.5, -0.5)
        axes.set_yticks(range(len(rows)), [shorten(row["solver"], 20) for row in rows])
        axes.tick_params(labelleft=name == "time")
        draw(axes, rows)
    return chart


def _times(axes: Axes, rows: Sequence[Row]) -> None:
    axes.set_title("time of a call: median, 99th percentile", fontsize=8.5, loc="left", pad=5)
    axes.set_xlabel("microseconds")
    measured = [(k, row["time"]) for k, row in enumerate(rows) if row["outcome"] == "measured"]
    known = [(k, time) for k, time in measured if time["median_us"] is not None]
    axes.set_xscale("log")
    ends = [time[key] for _, time in known for key in ("median_us", "p99_us")] or [1.0]
    axes.set_xlim(min(ends) / 1.5, max(ends) * 1.5)
    axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.minorticks_off()
    for k, time in known:
        x = [time["median_us"], time["p99_us"]]
        axes.add_artist(Line2D(x, [k, k], color=BLUE, linewidth=1.4))
        axes.add_artist(Line2D(x[:1], [k], marker="o", markersize=5.0, color=BLUE, linestyle=""))
        axes.add_artist(Line2D(x[1:], [k], marker="|", markersize=7.0, color=BLUE, linestyle=""))
    for k, row in enumerate(rows):
        if row["outcome"] != "measured":
            axes.text(0.02, k, row["outcome"], transform=axes.get_yaxis_transform(), va="center", color=SOFT)


def _coverage(axes: Axes, rows: Sequence[Row]) -> None:
    axes.set_title("coverage", fontsize=8.5, loc="left", pad=5)
    axes.set_xlabel("%")
    _bars(axes, rows, BLUE, lambda row: row["coverage"], lambda row: percent(row["coverage"]))


def _jumps(axes: Axes, rows: Sequence[Row]) -> None:
    axes.set_title("paths with a jump", fontsize=8.5, loc="left", pad=5)
    axes.set_xlabel("%")

    def share(row: Row) -> float | None:
        found = row["jumps"]
        return found["with_jump"] / found["paths"] if found["paths"] else None

    _bars(axes, rows, RED, share, lambda row: jumps(row["jumps"]))


def _bars(
    axes: Axes, rows: Sequence[Row], colour: str, share: Callable[[Row], float | None], label: Callable[[Row], str]
) -> None:
    """Draw bars from 0 to 100 % with their values at the right end."""
    axes.set_xlim(0.0, 100.0)
    axes.set_xticks([0, 25, 50, 75, 100])
    for k, row in enumerate(rows):
        if row["outcome"] != "measured":
            continue
        value = share(row)
        if value:
            axes.barh(k, 100.0 * value, height=0.62, color=colour, alpha=0.45, linewidth=0)
        axes.text(98.0, k, label(row), ha="right", va="center", color=INK if value is not None else SOFT)
