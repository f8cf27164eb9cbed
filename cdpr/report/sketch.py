"""The robot in space: frame, cables, platform and path in an orthographic view, drawn with lines in the plane."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np

from cdpr.log.run import Run
from cdpr.model import rotations
from cdpr.model.robot import Array
from cdpr.report.canvas import INK, SOFT, Axes, Chart, Line2D, Path, PathPatch, styled
from cdpr.report.decimate import extrema
from cdpr.report.panels import TOP, WIDTH, Entry, legend, legend_width, shorten
from cdpr.report.plots import AXES, DESIRED, cable_looks

HEIGHT = 4.3  # in
AZIMUTH, ELEVATION = np.radians(-62.0), np.radians(18.0)  # of the eye; a true isometric view hides corners behind others
GRID = "#c9c9c9"
DESIRED_PATH = "#00803f"
CUBE = np.array(list(product((-0.5, 0.5), repeat=3)))
EDGES = [(i, j) for i in range(8) for j in range(i) if np.abs(CUBE[i] - CUBE[j]).sum() == 1.0]
FACES = ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5))


@styled
def robot(run: Run) -> Chart:
    """Draw the frame's anchors, the cables and the platform at start and end, and the way between them."""
    anchors = np.array(run.header.anchors)
    A, B = anchors[:, :3], anchors[:, 3:]
    size = float(np.linalg.norm(np.ptp(A, axis=0))) or 1.0
    near = np.linalg.norm(run.position - A.mean(axis=0), axis=1) < 2.0 * size  # false where not finite
    rows = np.flatnonzero(near & np.isfinite(run.orientation).all(axis=1))
    path = run.position[rows]
    low, high = (edge(np.concatenate([A, path]), axis=0) for edge in (np.min, np.max))
    view = _projection(high - low)
    chart = Chart(figsize=(WIDTH, HEIGHT))
    right = legend_width(run)
    room = (WIDTH - right - 0.2, HEIGHT - 0.3)
    axes = chart.add_axes((0.1 / WIDTH, 0.15 / HEIGHT, room[0] / WIDTH, room[1] / HEIGHT))
    axes.set_axis_off()

    entries: list[Entry] = []
    box = (low + high) / 2 + CUBE * (high - low)
    _fit(axes, np.concatenate([box, A + 0.04 * size, A - 0.04 * size]) @ view[:2].T, room)
    _segments(axes, view, [(box[i], box[j]) for i, j in EDGES], color=GRID, linewidth=0.7)
    entries.append(_triad(axes, view, low, size))
    if len(rows):
        entries += _motion(axes, run, view, rows, A, B)
    short = all(len(name) <= 8 for name in run.header.cables)
    names = list(run.header.cables) if short else [str(i + 1) for i in range(len(A))]
    _anchor_names(axes, A @ view[:2].T, names, 0.035 * size)
    if not short:
        entries += [(f"{i}: {shorten(name)}", look) for i, (name, look) in enumerate(cable_looks(run), 1)]
    legend(chart, entries, (WIDTH - right + 0.12, HEIGHT - TOP))
    return chart


def _projection(extent: Array) -> Array:
    """Rows: rightwards, upwards and towards the eye, world axes, (3, 3). A planar robot is seen square on."""
    flat = np.flatnonzero(extent < 1e-6 * max(float(extent.max()), 1e-9))
    if len(flat) == 1:
        x, y, z = np.eye(3)
        return np.array([(y, z, x), (x, z, -y), (x, y, z)][flat[0]])
    ca, sa, ce, se = np.cos(AZIMUTH), np.sin(AZIMUTH), np.cos(ELEVATION), np.sin(ELEVATION)
    return np.array([(-sa, ca, 0.0), (-se * ca, -se * sa, ce), (ce * ca, ce * sa, se)])


def _fit(axes: Axes, points: Array, room: tuple[float, float]) -> None:
    """Set limits that show all points with one scale in both directions."""
    low, high = points.min(axis=0), points.max(axis=0)
    scale = 1.03 * float(np.max((high - low) / room)) or 1.0  # m per inch
    for k, (middle, set_limits) in enumerate(zip((low + high) / 2, (axes.set_xlim, axes.set_ylim), strict=True)):
        set_limits(middle - scale * room[k] / 2, middle + scale * room[k] / 2)


def _segments(axes: Axes, view: Array, pairs: Any, **look: Any) -> None:
    """Draw many segments in space as one line with gaps."""
    points = np.full((len(pairs), 3, 2), np.nan)
    points[:, :2] = np.array(pairs) @ view[:2].T
    x, y = points.reshape(-1, 2).T
    axes.add_artist(Line2D(x, y, **{"solid_capstyle": "round", **look}))


def _triad(axes: Axes, view: Array, corner: Array, size: float) -> Entry:
    """Draw the world's axes, which are the scale too."""
    length = _round_length(0.12 * size)
    for name, colour, direction in zip("xyz", AXES, np.eye(3), strict=True):
        if np.linalg.norm(view[:2] @ direction) < 1e-9:
            continue
        tip = corner + length * direction
        _segments(axes, view, [(corner, tip)], color=colour, linewidth=2.2, zorder=2)
        x, y = view[:2] @ (corner + (length + 0.03 * size) * direction)
        axes.text(x, y, name, color=colour, ha="center", va="center", fontweight="bold")
    return f"world axes, {length:g} m long", {"color": AXES[0], "linewidth": 2.2}


def _round_length(length: float) -> float:
    """Return the largest 1, 2 or 5 times a power of ten below `length`."""
    power = 10.0 ** np.floor(np.log10(length))
    return float(power * max(step for step in (1, 2, 5) if step * power <= length))


def _motion(axes: Axes, run: Run, view: Array, rows: Array, A: Array, B: Array) -> list[Entry]:
    """Draw cables and platform in the first and the last of `rows`, and the path in between."""
    start, end = rows[0], rows[-1]
    poses = [(run.position[k], rotations.matrix(run.orientation[k])) for k in (start, end)]
    (p, R), (p_end, R_end) = poses
    grey = {"color": "#a5a5a5", "linewidth": 0.8}
    _segments(axes, view, list(zip(A, p + B @ R.T, strict=True)), zorder=1.5, **grey)
    _platform(axes, run, view, p, R, B, edge="#a5a5a5", face="none", zorder=1.6)
    _platform(axes, run, view, p_end, R_end, B, edge=INK, face="#e9eef4", zorder=2.5)
    for a, b, (_, look) in zip(A, p_end + B @ R_end.T, cable_looks(run), strict=True):
        _segments(axes, view, [(a, b)], linewidth=1.3, zorder=3, **look)
    dots = np.concatenate([A, p_end + B @ R_end.T]) @ view[:2].T
    axes.add_artist(Line2D(*dots.T, linestyle="", marker="o", markersize=2.6, color=INK, zorder=3.5))
    desired = {"color": DESIRED_PATH, "linestyle": DESIRED, "linewidth": 1.0}
    actual = {"color": INK, "linewidth": 1.6}
    for points, look in ((run.position[rows], actual), (run.desired_position[rows], desired)):
        _, line = extrema(rows.astype(float), points @ view[:2].T, bins=150)
        axes.add_artist(Line2D(*line.T, zorder=4, **look))
    last = "end" if end == len(run.time) - 1 else "last sane sample"
    return [
        (f"start, {run.time[start]:.4g} s", grey),
        (f"{last}, {run.time[end]:.4g} s", {"color": INK, "linewidth": 0.8}),
        ("path", actual),
        ("desired path", desired),
    ]


def _platform(
    axes: Axes, run: Run, view: Array, p: Array, R: Array, B: Array, edge: str, face: str, zorder: float
) -> None:
    """Draw the platform's shape, or spokes to its anchors where no shape is known."""
    shape = run.header.shape or {}
    look = {"edgecolor": edge, "facecolor": face, "linewidth": 0.8, "zorder": zorder, "joinstyle": "round"}
    if "box" in shape:
        corners = p + (CUBE * np.array(shape["box"])) @ R.T
        for ring in FACES:
            outward = (corners[list(ring)].mean(axis=0) - p) @ view[2]
            if face == "none" or outward > 0.0:  # hidden faces stay hidden
                axes.add_artist(PathPatch(_ring(corners[list(ring)] @ view[:2].T), **look))
    elif "sphere" in shape:
        around = np.linspace(0.0, 2.0 * np.pi, 49)[:-1]
        circle = float(shape["sphere"]) * np.stack([np.cos(around), np.sin(around)], axis=1)
        axes.add_artist(PathPatch(_ring(view[:2] @ p + circle), **look))
    else:
        _segments(axes, view, [(p, point) for point in p + B @ R.T], color=edge, linewidth=0.8, zorder=zorder)


def _ring(points: Array) -> Path:
    return Path(np.concatenate([points, points[:1]]), closed=True)


def _anchor_names(axes: Axes, points: Array, names: list[str], reach: float) -> None:
    """Write the cables' names outside the frame; anchors that lie close together in the view share a label."""
    middle = points.mean(axis=0)
    left = list(range(len(points)))
    while left:
        group = [i for i in left if np.linalg.norm(points[i] - points[left[0]]) < reach]
        left = [i for i in left if i not in group]
        spot = points[group].mean(axis=0)
        away = spot - middle
        x, y = spot + reach * away / (float(np.linalg.norm(away)) or 1.0)
        side = "left" if away[0] > 0 else "right"
        axes.text(x, y, ", ".join(names[i] for i in group), ha=side, va="center", fontsize=8.0, color=SOFT)
