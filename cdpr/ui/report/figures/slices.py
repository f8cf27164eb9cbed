"""Slices through a workspace: cells inside it, coloured by value, together with the robot's frame."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr.analysis.workspace import Workspace
from cdpr.model import Robot
from cdpr.model.robot import DOF_NAMES, Array
from cdpr.scene import colours
from cdpr.ui.report.figures.svg import OnPage
from cdpr.ui.report.style import INK, PALE

WIDTH, LARGEST = 5.2, 4.2  # in, width of the sheet, and longer side of the drawing
LEFT, LOWER, ABOVE = 0.62, 0.55, 0.25  # in, margins
BAR, BESIDE = 0.16, 0.85  # in, width of the colour bar, and its distance from the drawing
SHADES = 9  # number of colours
UNDECIDED: dict[str, Any] = {"facecolor": PALE, "edgecolor": PALE, "linewidth": 0.3, "zorder": 1.5}
FRAME: dict[str, Any] = {"color": PALE, "linewidth": 1.2, "zorder": 3}
ANCHORS: dict[str, Any] = {"color": INK, "linestyle": "", "marker": "s", "markersize": 4, "zorder": 4}


def draw(found: Workspace, robot: Robot, axis: int, place: float) -> OnPage:
    """Draw the cells of the slice `axis` = `place` (m)."""
    region = found.region
    across, up = (i for i in range(3) if i != axis)
    index = int(np.argmin(np.abs(region.axes[axis] - place)))
    inside, value = np.take(found.inside, index, axis), np.take(found.value, index, axis)
    drawn = _lines(robot)
    corners = np.concatenate([drawn.reshape(-1, 3), [region.lower, region.upper]])[:, [across, up]]
    low, high = corners.min(axis=0), corners.max(axis=0)
    margin = 0.03 * float((high - low).max())
    low, high = low - margin, high + margin
    size = (high - low) * (LARGEST / float((high - low).max()))
    size *= min(1.0, (WIDTH - LEFT - BESIDE - 2.5 * BAR) / size[0])
    sheet = OnPage(WIDTH, LOWER + float(size[1]) + ABOVE)
    frame = sheet.frame((LEFT, LOWER, float(size[0]), float(size[1])))
    frame.scale(x=(float(low[0]), float(high[0])), y=(float(low[1]), float(high[1])))
    known = found.value[found.inside & np.isfinite(found.value)]
    least, most = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
    tones = colours.tension_steps("light", SHADES)
    shade = np.clip(SHADES * (value - least) / ((most - least) or 1.0), 0, SHADES - 1)
    shade = np.where(np.isfinite(value), shade, SHADES - 1).astype(np.int64)
    edges = [np.linspace(region.lower[i], region.upper[i], region.shape[i] + 1) for i in (across, up)]
    for k, tone in enumerate(tones):
        rings = _rings(inside & (shade == k), *edges)
        if rings:
            frame.area(rings, {"facecolor": tone, "edgecolor": tone, "linewidth": 0.3, "zorder": 1.5})
    if found.proofs is not None:
        frame.area(_rings(np.take(found.boundary, index, axis), *edges), UNDECIDED)
    for line in drawn:
        frame.line(line[[across, 3 + across]], line[[up, 3 + up]], FRAME)
    frame.line(robot.anchors[:, across], robot.anchors[:, up], ANCHORS)
    frame.time_axis(7)
    frame.label_time(f"{DOF_NAMES[across]} (m)", 0.26)
    frame.value_axis(f"{DOF_NAMES[up]} (m)", 0.45, powers=False)
    if most > least:
        bar = sheet.frame((LEFT + float(size[0]) + BESIDE, LOWER, BAR, float(size[1])))
        bar.scale(x=(0.0, 1.0), y=(least, most))
        steps = np.linspace(least, most, SHADES + 1)
        for tone, a, b in zip(tones, steps[:-1], steps[1:], strict=True):
            ring = np.array([[0.0, a], [1.0, a], [1.0, b], [0.0, b]])
            bar.area([ring], {"facecolor": tone, "edgecolor": tone, "linewidth": 0.3, "zorder": 1.5})
        unit = found.kind.unit_of(found.question)
        bar.value_axis(f"{found.kind.value}{f' ({unit})' if unit else ''}", 0.52, powers=False)
    return sheet


def _lines(robot: Robot) -> Array:
    """Return the edges (k, 6) of the frame, m; empty if the robot has none."""
    return robot.frame.edges if robot.frame is not None else np.empty((0, 6))


def _rings(cells: NDArray[np.bool_], x: Array, y: Array) -> list[Array]:
    """Return rectangles (4, 2) that cover the cells (nx, ny): one for each row of neighbouring cells."""
    rings = []
    padded = np.pad(cells, ((1, 1), (0, 0))).astype(np.int8)
    for j in range(cells.shape[1]):
        steps = np.diff(padded[:, j])
        for first, end in zip(np.flatnonzero(steps == 1), np.flatnonzero(steps == -1), strict=True):
            a, b, c, d = x[first], x[end], y[j], y[j + 1]
            rings.append(np.array([[a, c], [b, c], [b, d], [a, d]]))
    return rings
