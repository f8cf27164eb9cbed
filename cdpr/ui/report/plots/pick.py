"""Selection of a run's panels by name, and of cables by name or number."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from numbers import Integral
from typing import Any

from cdpr.base.errors import CdprError
from cdpr.base.nearest import did_you_mean
from cdpr.base.problems import short_repr
from cdpr.log.run import Run
from cdpr.ui.report.plots.panel import Curves, Panel
from cdpr.ui.report.plots.run import by_name, tension_limits

Cables = str | int | Sequence[str | int]

BY_CABLE = "cable"  # group of curves with one curve per cable


def pick(run: Run, names: Sequence[str], cables: Cables | None = None) -> list[Panel]:
    """Return the panels of these names.

    Args:
        run: run to plot.
        names: names as in `by_name`.
        cables: names, or numbers starting at 1, of the cables to plot; all by default.

    Raises:
        CdprError: if a panel or a cable does not exist.
    """
    known = by_name(run)
    for name in names:
        if not isinstance(name, str) or name not in known:
            hint = did_you_mean(name, known) if isinstance(name, str) else ""
            raise CdprError(f"plot: unknown panel {short_repr(name)}; {hint}allowed: {', '.join(sorted(known))}")
    chosen = [known[name] for name in names]
    if cables is None:
        return chosen
    if not any(curves.group == BY_CABLE for panel in chosen for curves in panel.curves):
        raise CdprError(f"plot: cables: not used by {', '.join(names)}; remove them")
    shown = numbers(run, cables)
    return [_only(run, panel, shown) for panel in chosen]


def numbers(run: Run, cables: Cables) -> list[int]:
    """Return cable indices (starting at 0) of names or numbers (starting at 1).

    Raises:
        CdprError: if a cable does not exist or none is given.
    """
    known = run.header.cables
    given: list[Any] = [cables] if isinstance(cables, str) or not isinstance(cables, Iterable) else list(cables)
    found = []
    for cable in given:
        if isinstance(cable, str) and cable in known:
            found.append(known.index(cable))
        elif (number := _whole(cable)) is not None and 1 <= number <= len(known):
            found.append(number - 1)
        else:
            hint = did_you_mean(cable, known) if isinstance(cable, str) else ""
            allowed = f"numbers from 1 to {len(known)}, and names: {', '.join(known)}"
            raise CdprError(f"plot: unknown cable {short_repr(cable)}; {hint}allowed: {allowed}")
    if not found:
        raise CdprError("plot: cables is empty: name some, or leave it out for all")
    return list(dict.fromkeys(found))


def _whole(cable: Any) -> int | None:
    """Return a whole number, also of NumPy types or as text from the command line; None otherwise."""
    if isinstance(cable, str):
        return int(cable) if cable.isascii() and cable.isdecimal() else None
    return int(cable) if isinstance(cable, Integral) and not isinstance(cable, bool) else None


def _only(run: Run, panel: Panel, cables: Sequence[int]) -> Panel:
    """Return a panel restricted to these cables, with unchanged colours."""
    if all(curves.group != BY_CABLE for curves in panel.curves):
        return panel
    curves = tuple(_columns(each, cables) if each.group == BY_CABLE else each for each in panel.curves)
    legend = [panel.legend[i] for i in cables] if panel.legend else ()
    limits = tension_limits(run, cables) if panel.limits else ()
    return replace(panel, curves=curves, legend=legend, limits=limits)


def _columns(curves: Curves, chosen: Sequence[int]) -> Curves:
    time, values = (array[:, list(chosen)] for array in curves.points)
    looks = ([look[i % len(look)] for i in chosen] for look in (curves.colours, curves.dashes, curves.names))
    colours, dashes, names = looks
    return replace(curves, points=type(curves.points)(time, values), colours=colours, dashes=dashes, names=names)
