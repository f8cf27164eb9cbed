"""JSON block of a page: scenes, panels and events. Equal runs give equal bytes."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from itertools import cycle
from typing import Any

import numpy as np

from cdpr.log.run import Run
from cdpr.scene import State, colours
from cdpr.ui.report.player.arrays import Arrays
from cdpr.ui.report.plots.overlay import FEW, Shade, span
from cdpr.ui.report.plots.overlay import shades as shades_of
from cdpr.ui.report.plots.panel import Curves, Panel, calm_until, shown, view
from cdpr.ui.report.style import events

MOST_EVENTS = 200

# Dark-mode replacement of each light-mode colour.
DARKER = {
    pair.light: pair.dark for pair in (colours.INK, colours.SOFT, *colours.AXES, *colours.DESIRED_AXES, *colours.CABLES)
}
PAIRS = {
    "ink": colours.INK,
    "soft": colours.SOFT,
    "slack": colours.SLACK,
    "limit": colours.LIMIT,
    "desired": colours.DESIRED,
    "force": colours.FORCE,
    "sensor": colours.SENSOR,
    "ground": colours.GROUND,
    "grid": colours.GRID,
    "body": colours.BODY,
}


def page_data(
    run: Run | None,
    scenes: Sequence[dict[str, Any]],
    figures: Mapping[str, Sequence[Panel]],
    arrays: Arrays,
    span_of: tuple[float, float] = (0.0, 0.0),
    shades: Sequence[Shade] = (),
) -> dict[str, Any]:
    """Return the data for the player script.

    Args:
        run: source of events and shaded intervals; None if nothing was simulated.
        scenes: scenes that are drawn in one 3D view.
        figures: panels by the id of their figure on the page.
        arrays: arrays of the scenes; the panels' arrays are added.
        span_of: first and last time (s) if there is no run.
        shades: shaded intervals if there is no run.
    """
    start, stop = span_of if run is None else span(run)
    return {
        "span": [start, stop],
        "events": [] if run is None else list(_events(run)),
        "shades": [_shade(shade) for shade in (shades if run is None else shades_of(run))],
        "colours": {name: list(pair) for name, pair in PAIRS.items()},
        "axes": [list(pair) for pair in colours.AXES],
        "cables": [list(pair) for pair in colours.CABLES],
        "states": {state.name.lower(): int(state) for state in State},
        "ramp": [colours.tension_steps("light"), colours.tension_steps("dark")],
        "scenes": list(scenes),
        "figures": {key: [_panel(panel, run, arrays) for panel in panels] for key, panels in figures.items()},
        "bytes": arrays.text(),
    }


def block(data: Mapping[str, Any]) -> str:
    """Return the data as an HTML block; special characters are escaped, so that no text can close the element."""
    text = json.dumps(data, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    for sign in "<>&":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return f'<script type="application/json" id="data">{text}</script>'


def _events(run: Run) -> Iterable[dict[str, Any]]:
    for event in events(run)[:MOST_EVENTS]:
        until = {} if event.until in (None, event.time) else {"until": event.until}
        yield {"time": event.time, "text": event.text, **until}


def _shade(shade: Shade) -> dict[str, Any]:
    return {"name": shade.name, "colour": list(shade.colour), "intervals": shade.intervals}


def _panel(panel: Panel, run: Run | None, arrays: Arrays) -> dict[str, Any]:
    calm = None if run is None else calm_until(run)
    low, high, note = view(panel, calm)
    return {
        "label": panel.label,
        "note": note,
        "range": [low, high],
        "least": panel.least,
        "log": panel.log,
        "tall": panel.height,
        "dots": run is not None and len(run.rows) <= FEW,
        "dashed": [
            {"label": limit.label, "values": [float(value) for value in limit.values]} for limit in panel.limits
        ],
        "series": [line for curves in panel.curves for line in _lines(panel, curves, arrays, exact=calm is not None)],
    }


def _lines(panel: Panel, curves: Curves, arrays: Arrays, *, exact: bool) -> Iterable[dict[str, Any]]:
    columns = zip(curves.points.time.T, shown(panel, curves).T, strict=True)
    names = [*curves.names, *([""] * curves.points.time.shape[1])]
    looks = zip(names, cycle(curves.colours), cycle(curves.dashes), strict=False)
    for (time, values), (name, colour, dashes) in zip(columns, looks, strict=False):
        # A diverging run has values of many magnitudes; 65535 steps would resolve only the largest.
        keep = arrays.fine if exact else arrays.coarse
        yield {
            "name": " ".join(str(name).split()),
            "group": curves.group,
            **curves.thing(str(name)),
            "colour": [colour, DARKER.get(colour, colour)],
            "dash": [] if isinstance(dashes, str) else list(np.asarray(dashes[1], float)),
            "width": curves.width,
            "time": arrays.coarse(time) if len(time) else arrays.coarse([]),
            "value": keep(values),
        }
