"""Parallel projection of the robot: frame, cables, platform and path."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from cdpr.model import rotations
from cdpr.model.robot import Array
from cdpr.scene import Pictures, Subject, colours, solid
from cdpr.scene.pictures import FINEST
from cdpr.scene.shapes import CUBE, EDGES, radius_around, world_origin
from cdpr.ui.report.figures.legend import LETTER, LINE, legend_width, write_legend
from cdpr.ui.report.figures.panels import TOP, WIDTH
from cdpr.ui.report.figures.solid_region import Surface, draw_surface
from cdpr.ui.report.figures.surface import Frame
from cdpr.ui.report.figures.svg import OnPage
from cdpr.ui.report.plots.decimate import extrema
from cdpr.ui.report.plots.panel import Entry
from cdpr.ui.report.style import AXES, DESIRED, INK, PALE, SOFT, cable_looks, shorten

LOWEST, HIGHEST = 2.4, 4.8  # in, height of the figure
# Viewing direction. In a truly isometric view, corners of a symmetric frame would coincide.
AZIMUTH, ELEVATION = np.radians(-62.0), np.radians(18.0)
VERTICAL = 0.3  # in, margin above and below
FAR = 1e8  # m: larger positions are ignored

BOX: dict[str, Any] = {"color": colours.GRID.light, "linewidth": 1.0}  # around the anchors, if the frame is unknown
FRAME: dict[str, Any] = {"color": PALE, "linewidth": 1.2}
START: dict[str, Any] = {"color": PALE, "linewidth": 0.7}
PATH: dict[str, Any] = {"color": INK, "linewidth": 1.7}
DESIRED_PATH: dict[str, Any] = {"color": colours.DESIRED.light, "linewidth": 1.0, "linestyle": DESIRED}


@np.errstate(all="ignore")  # a diverged run ends in inf and NaN
def draw(scene: Pictures, region: Surface | None = None) -> OnPage:
    """Draw the robot in its first and last frame and the path in between; `region` is drawn behind it."""
    subject = scene.subject
    A = subject.anchors[:, :3]
    wanted = scene.way if scene.desired_way is None else scene.desired_way
    sane = np.concatenate([A, wanted[(np.abs(wanted) < FAR).all(axis=1)]])  # excludes NaN
    size = float(np.linalg.norm(np.ptp(sane, axis=0))) or 1.0
    middle = (sane.min(axis=0) + sane.max(axis=0)) / 2
    shown = np.linalg.norm(scene.position - middle, axis=1) < size  # False also if not finite
    rows = [int(k) for k in np.flatnonzero(shown & np.isfinite(scene.orientation).all(axis=1))]
    ends_of_frame = subject.frame.reshape(-1, 3)
    fixed = np.concatenate([A, ends_of_frame])
    inside = np.concatenate([fixed, scene.position[rows]])
    low, high = inside.min(axis=0), inside.max(axis=0)
    view = _projection(high - low)
    box = (low + high) / 2 + CUBE * (high - low)
    short = all(len(name) <= 4 for name in subject.cables)
    names = [name if short else str(i) for i, name in enumerate(subject.cables, 1)]

    ends = scene.position[rows[:1] + rows[-1:]]
    far = radius_around(subject.shape, subject.anchors[:, 3:])
    corners = np.concatenate([box, world_origin(fixed), *([] if region is None else [region[0]])])
    hull = np.concatenate([corners @ view[:2].T, *(ends @ view[:2].T + s * far for s in (-1.0, 1.0))])
    labels = _anchor_labels(A @ view[:2].T, names, 0.04 * size)
    right, sides = legend_width(subject.cables), 0.25 + LETTER * max(len(text) for _, text in labels)
    height = max(_height(hull, WIDTH - right - 2.0 * sides), TOP + LINE * (6 + len(A)))
    sheet = OnPage(WIDTH, height)
    frame = sheet.frame((0.0, 0.0, WIDTH - right, height))
    frame.bare()
    reach = _fit(frame, hull, np.array((WIDTH - right, height)), np.array((sides, VERTICAL)))
    if len(subject.frame):
        colour = {"color": subject.colours.get("frame", FRAME["color"])}
        _segments(frame, view, [(edge[:3], edge[3:]) for edge in subject.frame], **FRAME | colour)
    else:
        _segments(frame, view, [(box[i], box[j]) for i, j in EDGES], **BOX)
    if region is not None:
        draw_surface(frame, view, region)
    entries = [_world_axes(frame, view, size)]
    if rows:
        entries += _motion(frame, scene, view, rows)
    _write_labels(frame, labels, hull.mean(axis=0), reach)
    if not short:
        broken = subject.broken_by(float(scene.time[-1]) if len(scene.time) else 0.0)
        named = zip(names, subject.cables, cable_looks(subject.cables), strict=True)
        entries += [(f"{i}: {shorten(name, 23)}" + " (broken)" * (name in broken), look) for i, name, look in named]
    write_legend(sheet, entries, (WIDTH - right, height - TOP))
    return sheet


def _projection(extent: Array) -> Array:
    """Return the projection (3, 3) with rows right, up and towards the viewer; planar robots are viewed face-on."""
    flat = np.flatnonzero(extent < 1e-6 * max(float(extent.max()), 1e-9))
    if len(flat) == 1:
        x, y, z = np.eye(3)
        return np.array([(y, z, x), (x, z, -y), (x, y, z)][flat[0]])
    ca, sa, ce, se = np.cos(AZIMUTH), np.sin(AZIMUTH), np.cos(ELEVATION), np.sin(ELEVATION)
    return np.array([(-sa, ca, 0.0), (-se * ca, -se * sa, ce), (ce * ca, ce * sa, se)])


def _height(points: Array, width: float) -> float:
    """Return the height (in) of a figure whose drawing fills `width` (in)."""
    across, up = np.ptp(points, axis=0)
    return float(np.clip(2.0 * VERTICAL + width * up / max(across, 1e-9), LOWEST, HIGHEST))


def _fit(frame: Frame, points: Array, room: Array, margin: Array) -> float:
    """Set one scale for both directions so that all points are visible; return the length of 0.15 in on paper, m."""
    low, high = points.min(axis=0), points.max(axis=0)
    scale = float(np.max((high - low) / (room - 2.0 * margin))) or 1.0  # m per inch
    start, stop = (low + high - scale * room) / 2, (low + high + scale * room) / 2
    frame.scale(x=(start[0], stop[0]), y=(start[1], stop[1]))
    return 0.15 * scale


def _segments(frame: Frame, view: Array, pairs: Sequence[tuple[Array, Array]], **look: Any) -> None:
    """Draw segments in space as one line with gaps."""
    points = np.full((len(pairs), 3, 2), np.nan)
    points[:, :2] = np.array(pairs) @ view[:2].T
    x, y = points.reshape(-1, 2).T
    frame.line(x, y, {"solid_capstyle": "round", **look})


def _line(frame: Frame, view: Array, points: Array, **look: Any) -> None:
    """Draw points (k, 3) in space as one line."""
    x, y = np.concatenate([points @ view[:2].T, np.full((1, 2), np.nan)]).T
    frame.line(x, y, {"solid_capstyle": "round", **look})


def _world_axes(frame: Frame, view: Array, size: float) -> Entry:
    """Draw the world axes at the origin; they also serve as the scale."""
    power = 10.0 ** np.floor(np.log10(0.12 * size))
    length = float(power * max(step for step in (1, 2, 5) if step * power <= 0.12 * size))
    for name, colour, direction in zip("xyz", AXES, np.eye(3), strict=True):
        if np.linalg.norm(view[:2] @ direction) > 1e-9:
            _segments(frame, view, [(np.zeros(3), length * direction)], color=colour, linewidth=2.2, zorder=2)
            x, y = view[:2] @ ((length + 0.025 * size) * direction)
            bold = {"color": colour, "ha": "center", "va": "center", "fontweight": "bold", "zorder": 6}
            frame.text(x, y, name, bold)
    return f"axes, {length:g} m long", {"color": AXES[0], "linewidth": 2.2}


def _motion(frame: Frame, scene: Pictures, view: Array, rows: list[int]) -> list[Entry]:
    """Draw cables and platform in the first and the last of `rows`, and the path in between."""
    subject, start, end = scene.subject, rows[0], rows[-1]
    lines = scene.cable_lines(FINEST)
    moves = len(scene.time) > 1
    if moves:
        p, R = scene.position[start], rotations.matrix(scene.orientation[start])
        _segments(frame, view, [pair for line in lines[start] for pair in pairwise(line)], **START, zorder=1.5)
        _platform(frame, subject, view, p, R, {"edgecolor": START["color"], "facecolor": "none", "zorder": 1.6})
    p, R = scene.position[end], rotations.matrix(scene.orientation[end])
    face = subject.colours.get("platform", colours.BODY.light)
    _platform(frame, subject, view, p, R, {"edgecolor": INK, "facecolor": face, "zorder": 2.5})
    ends = scene.ends[end]
    broken = subject.broken_by(float(scene.time[-1]))
    for line in subject.exit_lines(ends):
        _segments(frame, view, list(pairwise(line)), color=INK, linewidth=0.8, zorder=3.2)
    for name, line, look in zip(subject.cables, lines[end], cable_looks(subject.cables), strict=True):
        if name not in broken:
            _line(frame, view, line, **look, linewidth=1.3, zorder=3)
    x, y = view[:2] @ ends.reshape(-1, 3).T
    frame.line(x, y, {"linestyle": "", "marker": "o", "markersize": 2.6, "color": INK, "zorder": 3.5})
    if not moves:
        return []
    paths = [("path", scene.way, PATH)]
    if scene.desired_way is not None:
        paths.append(("desired path", scene.desired_way, DESIRED_PATH))
    for _, path, look in paths:
        _, points = extrema(scene.time[rows], path[rows] @ view[:2].T, bins=150)
        frame.line(points[:, 0], points[:, 1], {"zorder": 4, **look})
    last = "end" if end == len(scene.time) - 1 else "last shown"
    return [
        (f"start, {scene.time[start]:.4g} s", START),
        (f"{last}, {scene.time[end]:.4g} s", {"color": INK, "linewidth": 0.8}),
        *((name, look) for name, _, look in paths),
    ]


def _platform(frame: Frame, subject: Subject, view: Array, p: Array, R: Array, look: dict[str, Any]) -> None:
    """Draw the platform's shape, or lines to its anchors if the shape is unknown."""
    outline = {**look, "linewidth": 0.8}
    body = solid(subject.shape)
    if body is None:
        spokes = [(p, p + R @ B) for B in subject.anchors[:, 3:]]
        _segments(frame, view, spokes, color=look["edgecolor"], linewidth=1.6, zorder=look["zorder"])
        return
    corners = p + body.vertices @ R.T
    if body.curved:
        frame.area([_hull(corners @ view[:2].T)], outline)
    for face in body.faces:
        ring = corners[list(face)]
        outwards = np.cross(ring[1] - ring[0], ring[2] - ring[1]) @ view[2] > 0.0
        if outwards or (look["facecolor"] == "none" and not body.curved):  # other faces are hidden
            frame.area([ring @ view[:2].T], outline)


def _hull(points: Array) -> Array:
    """Return the corners of the convex hull of points (k, 2), counter-clockwise."""
    ordered = sorted(map(tuple, points.tolist()))
    halves = []
    for chain in (ordered, ordered[::-1]):
        half: list[tuple[float, ...]] = []
        for x, y in chain:
            while len(half) > 1 and _left(half[-2], half[-1], (x, y)) <= 0.0:
                half.pop()
            half.append((x, y))
        halves += half[:-1]
    return np.array(halves)


def _left(a: tuple[float, ...], b: tuple[float, ...], c: tuple[float, ...]) -> float:
    """Return twice the signed area of a triangle, positive if c is left of the line from a to b."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _anchor_labels(points: Array, names: list[str], near: float) -> list[tuple[Array, str]]:
    """Return positions and texts of anchor labels; anchors less than `near` apart in the view share a label."""
    labels: list[tuple[Array, str]] = []
    left = list(range(len(points)))
    while left:
        group = [i for i in left if np.linalg.norm(points[i] - points[left[0]]) < near]
        left = [i for i in left if i not in group]
        labels.append((points[group[0]], ", ".join(names[i] for i in group)))
    return labels


def _write_labels(frame: Frame, labels: list[tuple[Array, str]], middle: Array, reach: float) -> None:
    """Write labels slightly farther from `middle` than their points."""
    for point, name in labels:
        away = point - middle
        x, y = point + reach * away / (float(np.linalg.norm(away)) or 1.0)
        side = "left" if away[0] > 0.0 else "right"
        frame.text(x, y, name, {"ha": side, "va": "center", "color": SOFT, "zorder": 5}, halo=True)
