"""Equilibria and compensated lengths, from `cdpr.analysis.equilibrium.figures`, as aligned text."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from cdpr.ui.report.text.aligned import row, table, turned, vector, wrapped

ROUND_OFF = 1e-12  # smaller numbers are written as 0


def lines(figures: dict[str, Any]) -> Iterator[str]:
    """Yield the equilibria of a robot."""
    found = figures["equilibria"]
    count = f"{len(found)} {'equilibrium' if len(found) == 1 else 'equilibria'}"
    yield f"{figures['robot']}, {', '.join(figures['dof'])}: {count} from {figures['start']}"
    for number, one in enumerate(found, start=1):
        if len(found) > 1:
            yield f"{number}:"
        yield from _one(one)
    if figures["friction"]:
        yield from wrapped(figures["friction"], 2)


def _one(one: dict[str, Any]) -> Iterator[str]:
    pose = one["pose"]
    yield row("rest at", f"{vector(pose['position_m'])} m{turned(pose['orientation_wxyz'])}")
    if not one["converged"]:
        yield from wrapped(row("not converged", one["problem"]), 23)
        yield row("misfit of lengths", f"{one['misfit_m']:.4g} m")
    if one["residual_N"] is not None:
        yield row("remaining force", f"{one['residual_N']:.3g} N of {one['load_N']:.6g} N")
    if one["converged"]:
        yield row("stability", _stability(one))
        if one["free_directions"]:
            yield row("free directions", f"{len(one['free_directions'])}: no taut cable resists them to first order")
        known = [value for value in one["frequencies_Hz"] if value is not None]
        if known:
            yield row("frequencies", f"{', '.join(f'{value:.4g}' for value in known)} Hz, drums held")
    heading = ["cable", "tension (N)", "unwound (m)", "length (m)", "dx", "dy", "dz", ""]
    yield from table([heading, *(_cable(cable) for cable in one["cables"])], ruled=True)
    yield "  dx, dy, dz: motion (m) per metre of unwound length, or per newton of a given tension"


def _stability(one: dict[str, Any]) -> str:
    values = one["eigenvalues_N_per_m"]
    least = f"least stiffness {values[0]:.4g} N/m" if values else "the cables permit no motion"
    return f"{one['stability']}: {least}"


def _cable(cable: dict[str, Any]) -> list[str]:
    note = "slack" if cable["slack"] else "above its limit" if cable["above_limit"] else ""
    numbers = [cable["tension_N"], cable["unwound_m"], cable["length_m"], *cable["sensitivity"][:3]]
    return [cable["name"], *map(_number, numbers), note]


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value if abs(value) >= ROUND_OFF else 0.0:.6g}"


def compensation_lines(figures: dict[str, Any]) -> Iterator[str]:
    """Yield the compensated lengths at one pose."""
    pose, held = figures["pose"], figures["uncompensated"]
    yield f"{figures['robot']} at {vector(pose['position_m'])} m{turned(pose['orientation_wxyz'])}"
    if not figures["feasible"]:
        loose = any(cable["length_m"] is None for cable in figures["cables"])
        text = "a cable would get too little tension for its weight" if loose else "no tensions balance the weight"
        yield row("not at rest", f"within the limits, {text} here ({figures['status']})")
    heading = ["cable", "unwound (m)", "path (m)", "shorter by (mm)", "tension (N)"]
    rows = [
        [
            cable["name"],
            "-" if cable["length_m"] is None else f"{cable['length_m']:.6f}",
            f"{cable['path_m']:.6f}",
            "-" if cable["length_m"] is None else f"{1e3 * (cable['path_m'] - cable['length_m']):.3f}",
            _number(cable["tension_N"]),
        ]
        for cable in figures["cables"]
    ]
    yield from table([heading, *rows], ruled=True)
    slack = f", slack: {', '.join(held['slack'])}" if held["slack"] else ""
    rest = f"{1e3 * held['error_m']:.4g} mm away{slack}" if held["converged"] else "no equilibrium found"
    yield row("uncompensated", rest)
    if figures["friction"]:
        yield from wrapped(figures["friction"], 2)
