"""Summary of a run in one sentence."""

from __future__ import annotations

import math

import numpy as np

from cdpr.log.run import Run
from cdpr.model.robot import Array
from cdpr.ui.report.text.aligned import digits, unit_for

AT_REST = 1e-3  # m, shorter paths count as no motion


def sentence(run: Run, way: Array) -> str:
    """Return a sentence on the path `way` (n, 3), m, the errors, tensions and first event; "" without samples."""
    figures = run.summary()
    if not figures["samples"]:
        return ""
    with np.errstate(all="ignore"):
        length = float(np.linalg.norm(np.diff(way, axis=0), axis=1).sum())
    parts = [f"in {figures['simulated_s']:.4g} s the platform of {run.header.robot} {_moved(length)}"]
    position, turn = figures["position_error_m"]["max"], figures["orientation_error_rad"]["max"]
    if math.isfinite(position) and math.isfinite(turn):
        parts.append(f"with errors up to {_quantity_text(position, 'm')} and {_quantity_text(turn, 'rad')}")
    tension = figures.get("cable_tension_N", figures["tension_N"])
    if math.isfinite(tension["max"]):
        parts.append(f"with tensions from {digits(tension['min'])} to {digits(tension['max'])} N")
    text = ", ".join(parts)
    first = min(run.events, key=lambda event: event.time, default=None)
    if first is not None:
        more = len(run.events) - 1
        others = f", first of {more + 1} events" if more else ""
        text += f"; at {first.time:.4g} s{others}: {first.text}"
    return text


def _moved(length: float) -> str:
    if not math.isfinite(length):
        return "left all bounds"
    return f"moved {length:.3g} m" if length >= AT_REST else "held its place"


def _quantity_text(value: float, unit: str) -> str:
    scale, name = unit_for([value], unit)
    return f"{scale * value:.3g} {name}"
