"""The panels of a comparison: overlays, and differences on a logarithmic axis."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from cdpr.compare.comparison import Group
from cdpr.compare.differences import QUANTITIES, apart
from cdpr.log.run import Run
from cdpr.model.robot import Array
from cdpr.report.marks import AXES, CABLES, INK, SOFT, cable_looks, shorten
from cdpr.report.plots.histories import Points, points, roll_pitch_yaw
from cdpr.report.plots.panel import Curves, Entry, Limit, Panel

Drawing = tuple[str, Callable[[Group], list[Panel]], str]

# One pattern an engine, thin and dark on the judge's broad line: where all agree, all can be seen.
DASHES: tuple[Any, ...] = ((0, (1.2, 5.0)), (2.0, (1.2, 5.0)), (4.0, (1.2, 5.0)), (0, (4.0, 2.0)), (0, (6.0, 2.0)))
BROAD, THIN = 2.4, 1.0
WIDTHS = (3.6, 2.4, 1.4, 0.8)  # so that lines upon each other show

# That an axis of differences spans at least: with bounds so many that these are in view.
DECADES = {False: 3.0, True: 8.0}


def drawings(group: Group) -> dict[str, Drawing]:
    """Return title, panels and caption of each figure by its name."""
    found: dict[str, Drawing] = {
        "differences": (
            "Differences from the judge",
            differences,
            "Distance of each engine from the judge, powers of ten; of the tensions that of the cable in which they "
            "differ most. Engines of one scheme and one step lie upon each other: this is the error of their scheme, "
            "in proportion to a power of the step.",
        )
    }
    if group.twins:
        found["beyond"] = (
            "Differences beyond the scheme",
            beyond,
            "Distance of each engine from the judge running the engine's own scheme with the same step: round-off, "
            "where all is well. Dashed: what is allowed. Zero is drawn at 10<sup>−16</sup>.",
        )
    found["pose"] = (
        "Pose",
        pose,
        "Position and attitude (roll, pitch, yaw) of all: broad the judge's, on it in dots or dashes the others'.",
    )
    found["tension"] = (
        "Tensions",
        tensions,
        "Tension of each cable: broad the judge's, on it in dots or dashes the others'.",
    )
    return found


def differences(group: Group) -> list[Panel]:
    """The distance of each run from the judge's, one panel a quantity."""
    assert group.judge is not None
    pairs = {label: (run, group.judge) for label, run in _others(group)}
    return list(_distances(group, pairs))


def beyond(group: Group) -> list[Panel]:
    """The distance of each run from the judge's with the same scheme."""
    assert group.judge is not None
    twins = {row.label: group.twins.get(row.engine.scheme) for row in group.rows if row.standard == "scheme"}
    pairs = {label: (run, twin) for label, run in _others(group) if (twin := twins.get(label)) is not None}
    return list(_distances(group, pairs, bounds=True))


def pose(group: Group) -> list[Panel]:
    """The pose of all runs."""
    position = _overlay(group, "position (m)", lambda run: run.position, AXES, _names("xyz"), 1e-3)
    attitude = _overlay(
        group,
        "attitude (°)",
        lambda run: np.degrees(roll_pitch_yaw(run)[1]),
        AXES,
        _names(["roll", "pitch", "yaw"]),
        0.1,
    )
    return [position, attitude]


def tensions(group: Group) -> list[Panel]:
    """The tensions of all runs."""
    cables = _judge(group).header.cables
    looks = cable_looks(cables)
    entries: list[Entry] = [
        (shorten(name), {**look, "linestyle": "-"}) for name, look in zip(cables, looks, strict=True)
    ]
    colours = [look["color"] for look in looks]
    panel = _overlay(group, "cable tension (N)", lambda run: run.tension, colours, entries, 1.0, 3.2)
    return [panel]


def _judge(group: Group) -> Run:
    assert group.judge is not None
    return group.judge


def _others(group: Group) -> Iterator[tuple[str, Run]]:
    for row in group.rows:
        if row.run is not None:
            yield row.label, row.run


def _distances(group: Group, pairs: dict[str, tuple[Run, Run]], *, bounds: bool = False) -> Iterator[Panel]:
    looks: list[dict[str, Any]] = [
        {"color": CABLES[i % len(CABLES)], "linewidth": WIDTHS[i % len(WIDTHS)]} for i in range(len(pairs))
    ]
    legend: list[Entry] = [(shorten(label), look) for label, look in zip(pairs, looks, strict=True)]
    for name, quantity in QUANTITIES.items():
        curves = []
        for look, (label, pair) in zip(looks, pairs.items(), strict=True):
            values = apart(name, *pair)[1][:, None]
            if not bounds:
                values = np.where(values > 0.0, values, np.nan)  # at the start all are one
            curves.append(Curves(_padded(values, group), (look["color"],), width=look["linewidth"], names=(label,)))
        allowed = (Limit("allowed", (float(np.log10(quantity.allowed(_judge(group)))),)),) if bounds else ()
        title = f"{quantity.title} ({quantity.unit})"
        yield Panel(title, tuple(curves), legend, least=DECADES[bounds], limits=allowed, log=True)


def _overlay(
    group: Group,
    label: str,
    values: Callable[[Run], Array],
    colours: Any,
    entries: list[Entry],
    least: float,
    height: float = 1.55,
) -> Panel:
    """The judge's lines broad and in colour, the others' thin and dark on them."""
    judge = _judge(group)
    names = [name for name, _ in entries]
    curves = [Curves(points(judge.time, values(judge)), colours, width=BROAD, names=names)]
    how: list[Entry] = [(shorten(judge.header.backend), {"color": SOFT, "linewidth": BROAD})]
    for i, (name, run) in enumerate(_others(group)):
        dashes = DASHES[i % len(DASHES)]
        theirs = [f"{part} {name}" for part in names]
        curves.append(Curves(_padded(values(run), group), (INK,), (dashes,), THIN, theirs, "over"))
        how.append((shorten(name), {"color": INK, "linewidth": THIN, "linestyle": dashes}))
    return Panel(label, tuple(curves), [*entries, *how], least, height=height)


def _padded(values: Array, group: Group) -> Points:
    """What to draw at the times of the judge's run; nothing where another ended early."""
    time = _judge(group).time
    padded = np.full((len(time), values.shape[1]), np.nan)
    count = min(len(padded), len(values))
    padded[:count] = values[:count]
    return points(time, padded)


def _names(names: Any) -> list[Entry]:
    return [(name, {"color": colour, "linewidth": BROAD}) for name, colour in zip(names, AXES, strict=True)]
