"""Panels of a comparison: differences on a logarithmic axis, and overlaid poses and tensions.

An engine has the same colour, width and dashes in all panels. Each component of the pose and each cable has its own
panel.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from cdpr.analysis.compare.comparison import Group
from cdpr.analysis.compare.differences import QUANTITIES, apart
from cdpr.log.run import Run
from cdpr.model.robot import Array
from cdpr.ui.report.plots.histories import Points, points, roll_pitch_yaw
from cdpr.ui.report.plots.panel import Curves, Entry, Limit, Panel
from cdpr.ui.report.style import shorten

Looks = Mapping[str, dict[str, Any]]  # styles of engines by label
Drawing = tuple[str, Callable[[Group, str, Looks], list[Panel]], str]

SMALL = 1.0  # in, height of small panels

# Smallest range of an axis of differences, in decades, without and with bounds; the latter keeps the bounds in view.
DECADES = {False: 3.0, True: 8.0}


def drawings(group: Group) -> dict[str, Drawing]:
    """Return the title, panels and caption of each figure, by name."""
    found: dict[str, Drawing] = {
        "differences": (
            "Differences from the reference",
            differences,
            "Distance of each engine from the reference, powers of ten; for tensions that of the cable in which they "
            "differ most. Engines with one scheme and one step coincide: this is the error of their scheme, in "
            "proportion to a power of the step.",
        )
    }
    if group.twins:
        found["beyond"] = (
            "Differences beyond the scheme",
            beyond,
            "Distance of each engine from the judge running the engine's own scheme with the same step: round-off, "
            "where all is well. Dashed grey: the bound. Zero is drawn at 10<sup>−16</sup>.",
        )
    found["pose"] = ("Pose", pose, "Position and attitude (roll, pitch, yaw) in all runs.")
    found["tension"] = ("Tensions", tensions, "Tension of each cable in all runs.")
    return found


def differences(group: Group, judge: str, looks: Looks) -> list[Panel]:
    """Return the distance of each run from the judge's run, one panel per quantity."""
    pairs = {label: (run, _judge(group)) for label, run in _others(group)}
    return list(_distances(group, pairs, looks))


def beyond(group: Group, judge: str, looks: Looks) -> list[Panel]:
    """Return the distance of each run from the judge's run with the same scheme."""
    twins = {row.label: group.twins.get(row.engine.scheme) for row in group.rows if row.standard == "scheme"}
    pairs = {label: (run, twin) for label, run in _others(group) if (twin := twins.get(label)) is not None}
    return list(_distances(group, pairs, looks, bounds=True))


def pose(group: Group, judge: str, looks: Looks) -> list[Panel]:
    """Return the components of the pose, one panel each."""
    names = ("x", "y", "z")
    position = _components(group, judge, looks, "{} (m)", names, lambda run: run.position, 1e-3)
    angles = ("roll", "pitch", "yaw")
    attitude = _components(group, judge, looks, "{} (°)", angles, lambda run: np.degrees(roll_pitch_yaw(run)[1]), 0.1)
    return [*position, *attitude]


def tensions(group: Group, judge: str, looks: Looks) -> list[Panel]:
    """Return the tensions, one panel per cable."""
    cables = _judge(group).header.cables
    return _components(group, judge, looks, "{} (N)", cables, lambda run: run.tension, 1.0)


def _judge(group: Group) -> Run:
    assert group.judge is not None
    return group.judge


def _others(group: Group) -> Iterator[tuple[str, Run]]:
    for row in group.rows:
        if row.run is not None:
            yield row.label, row.run


def _distances(
    group: Group, pairs: dict[str, tuple[Run, Run]], looks: Looks, *, bounds: bool = False
) -> Iterator[Panel]:
    legend = _legend(list(pairs), looks)
    for name, quantity in QUANTITIES.items():
        curves = []
        for label, pair in pairs.items():
            values = apart(name, *pair)[1][:, None]
            if not bounds:
                values = np.where(values > 0.0, values, np.nan)  # all runs are equal at the start
            curves.append(Curves.of(_padded(values, group), label, looks[label]))
        allowed = (Limit("bound", (float(np.log10(quantity.allowed(_judge(group)))),)),) if bounds else ()
        title = f"{quantity.title} ({quantity.unit})"
        yield Panel(title, tuple(curves), legend, least=DECADES[bounds], limits=allowed, log=True)


def _components(
    group: Group,
    judge: str,
    looks: Looks,
    label: str,
    names: Sequence[str],
    values: Callable[[Run], Array],
    least: float,
) -> list[Panel]:
    """Return a panel for each column of a quantity, with one line per run; the judge's line is the first."""
    time = _judge(group).time
    found = {judge: points(time, values(_judge(group)))}
    found |= {name: _padded(values(run), group) for name, run in _others(group)}
    legend = _legend(list(found), looks)
    return [
        Panel(
            label.format(shorten(name)),
            tuple(Curves.of(known.columns(slice(k, k + 1)), who, looks[who]) for who, known in found.items()),
            legend if k == 0 else (),
            least=least,
            height=SMALL,
        )
        for k, name in enumerate(names)
    ]


def _legend(labels: Sequence[str], looks: Looks) -> list[Entry]:
    return [(shorten(label), looks[label]) for label in labels]


def _padded(values: Array, group: Group) -> Points:
    """Return the values at the times of the judge's run, with NaN after the end of a shorter run."""
    time = _judge(group).time
    padded = np.full((len(time), values.shape[1]), np.nan)
    count = min(len(padded), len(values))
    padded[:count] = values[:count]
    return points(time, padded)
