"""Texts of figures for papers: none lies over another, none is cut, whatever the numbers at the ticks."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from report_cases import CASES, make_run
from spread import sampled

pytest.importorskip("matplotlib")

NEAR = 0.5  # px at 100 to an inch: what boxes of texts may share
NAMES = (
    "tension",
    "position",
    "position_error",
    "orientation_error",
    "residual",
    "energy_residual",
    "margin",
    "energy",
)


def texts(figure):
    """Return texts with their boxes, px; ticks that are out of view have none."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.text import Text

    renderer = FigureCanvasAgg(figure).get_renderer()
    figure.draw(renderer)
    unseen = set()
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            room = 1e-9 * (high - low)
            for tick in axis.get_major_ticks():
                if not low - room <= tick.get_loc() <= high + room:
                    unseen |= {tick.label1, tick.label2}
    shown = [each for each in figure.findobj(Text) if each.get_visible() and each.get_text().strip()]
    return [(each.get_text(), each.get_window_extent(renderer)) for each in shown if each not in unseen]


def collisions(figure):
    """Return pairs of texts that lie over one another, and texts that are cut."""
    found = texts(figure)
    apart = lambda a, b: a.x1 - NEAR <= b.x0 or b.x1 - NEAR <= a.x0 or a.y1 - NEAR <= b.y0 or b.y1 - NEAR <= a.y0  # noqa: E731
    over = [(a, b) for (a, x), (b, y) in combinations(found, 2) if not apart(x, y)]
    page = figure.bbox
    cut = [a for a, x in found if x.x0 < -NEAR or x.y0 < -NEAR or x.x1 > page.x1 + NEAR or x.y1 > page.y1 + NEAR]
    return over, cut


@sampled(1, "width", ["ieee", "ieee-wide", "60 mm"])
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.usual("tension-*", "energy-*", "pose-*")
def test_no_text_lies_over_another(name, width):
    assert collisions(make_run().plot(name, width=width)) == ([], [])


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_nor_in_odd_runs(case):
    run = CASES[case]()
    for width in ("ieee", "ieee-wide", "60 mm", "88 mm", 5.0):
        for name in NAMES:
            with np.errstate(all="ignore"):
                assert collisions(run.plot(name, width=width)) == ([], []), (name, width)


def test_occluding_elements_are_found():
    figure = make_run().plot("position_error", width="ieee")
    figure.axes[0].yaxis.set_label_coords(-0.02, 0.5)
    assert collisions(figure)[0]
