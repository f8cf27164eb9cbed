"""Poles of a closed loop, from `cdpr.simulation.poles.closed_loop`, as aligned text."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from cdpr.simulation.poles import REPEATED
from cdpr.ui.report.text.aligned import row, table, wrapped

VERDICTS = {
    "stable": "stable: all modes decay",
    "unstable": "UNSTABLE: a mode grows",
    "undamped": "undamped: a mode neither grows nor decays",
    "undecided": "undecided: tensions have a corner at this pose, and the loop differs on its two sides",
}
MOST = 12  # poles that are printed, the slowest first
ROUND_OFF = 1e-6  # of |s|: smaller imaginary parts are not printed
OFFSET = 1e-6  # m and rad: smaller distances at rest are not printed


def closed_loop_lines(figures: dict[str, Any]) -> Iterator[str]:
    """Yield the lines of the figures of a closed loop."""
    step = figures["control_step_s"]
    yield f"closed loop: {figures['controller']}, every {1e3 * step:g} ms, linearised at rest at this pose"
    if figures["problem"]:
        first, *more = wrapped(f"  {'poles':<21}not computed: {figures['problem']}", 23)
        yield "  " + first.lstrip()
        yield from more
        return
    yield row("verdict", VERDICTS[figures["verdict"]])
    moved, turned = figures["rest_offset_m"], figures["rest_turn_rad"]
    if moved > OFFSET or turned > OFFSET:
        yield row("rests", f"{1e3 * moved:.4g} mm and {1e3 * turned:.4g} mrad from the desired pose")
    bands = figures["bandwidth_Hz"].items()
    yield row("bandwidth (Hz)", ", ".join(f"{name} {f'{band:.3g}' if band else 'none'}" for name, band in bands))
    for text in figures["notes"]:
        yield row("note", text)
    merged = _merged(figures["poles"])
    rows = [
        [
            _pole(pole),
            str(count),
            f"{pole['damping_ratio']:.3g}",
            f"{pole['frequency_Hz']:.4g}",
            _time(pole["real_per_s"]),
            ", ".join(pole["moves"]),
        ]
        for pole, count in merged[:MOST]
    ]
    heading = ["pole (1/s)", "number", "damping", "frequency (Hz)", "time constant (s)", "moves"]
    yield from table([heading, *rows])
    if len(merged) > MOST:
        yield f"  and {len(merged) - MOST} more, which decay faster (--json prints all)"
    for text in figures["warnings"]:
        yield row("warning", text)


def _merged(poles: list[dict[str, Any]]) -> list[tuple[dict[str, Any], int]]:
    """Return poles with their numbers: a conjugate pair counts as one pole, and so do equal ones."""
    found: list[tuple[dict[str, Any], int]] = []
    for pole in poles:
        if pole["imaginary_rad_per_s"] < 0.0:
            continue
        for k, (other, count) in enumerate(found):
            if _distance(pole, other) <= REPEATED * 2.0 * math.pi * pole["frequency_Hz"]:
                moves = list(dict.fromkeys([*other["moves"], *pole["moves"]]))
                found[k] = {**other, "moves": moves}, count + 1
                break
        else:
            found.append((pole, 1))
    return found


def _distance(one: dict[str, Any], other: dict[str, Any]) -> float:
    keys = "real_per_s", "imaginary_rad_per_s"
    return math.hypot(*(one[key] - other[key] for key in keys))


def _pole(pole: dict[str, Any]) -> str:
    turning = pole["imaginary_rad_per_s"]
    vibrates = turning > ROUND_OFF * 2.0 * math.pi * pole["frequency_Hz"]
    return f"{pole['real_per_s']:.4g}" + (f" +- {turning:.4g}i" if vibrates else "")


def _time(real: float) -> str:
    return f"{-1.0 / real:.3g}" if real < 0.0 else "grows" if real > 0.0 else "none"
