"""Common style of figures and tables: colours, dashes, short names and event numbers."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import cycle
from typing import Any

from cdpr.log.event import Event
from cdpr.log.run import Run
from cdpr.scene import colours

INK, SOFT, PALE = colours.INK.light, colours.SOFT.light, colours.PALE.light

# Red, green and blue for x, y and z in tones that colour-blind readers can distinguish; desired axes are darker.
AXES = tuple(pair.light for pair in colours.AXES)
DARK = tuple(pair.light for pair in colours.DESIRED_AXES)
DESIRED = (0, (3.5, 2.5))

# Line style of cables: colours repeat from the ninth cable on, with the next dash pattern.
CABLES = tuple(pair.light for pair in colours.CABLES)
DASHES: tuple[Any, ...] = ("-", (0, (7.0, 1.5, 1.2, 1.5)), (0, (1.2, 1.2)), (0, (3.0, 1.0)))

# Line width and dashes of overlaid runs. Where lines coincide, each remains visible under the next, narrower or dashed
# one. The widest line is less than three times the narrowest, so that no run looks more important.
OVERLAID: tuple[tuple[float, Any], ...] = (
    (2.6, "-"),
    (2.0, (0, (4.0, 2.0))),
    (1.6, (0, (1.4, 2.0))),
    (1.0, "-"),
    (1.0, (0, (7.0, 2.0, 1.4, 2.0))),
)

# Labels of the shaded states.
SHADES = {status: status.name.lower().replace("_", " ") for status in colours.SHADES}

# Creator entry of figure files; it distinguishes them from other matplotlib files.
DRAWN_BY = "cdpr, by Matplotlib"

# Smallest range of the pose error axes, mm and mrad: 1 nm, far below the accuracy of any cable robot.
LEAST_ERROR = 1e-6


def paired(pair: colours.Pair) -> str:
    """Return the light and dark colour as CSS variables for an element of class "paired"."""
    return f"--light:{pair.light};--dark:{pair.dark}"


def cable_looks(cables: Sequence[str]) -> list[dict[str, Any]]:
    """Return the colour and dashes of each cable."""
    looks = cycle((colour, dashes) for dashes in DASHES for colour in CABLES)
    return [
        {"color": colour, "linestyle": dashes, "thing": f"cable:{name}"}
        for name, (colour, dashes) in zip(cables, looks, strict=False)
    ]


def overlaid_looks(kind: str, names: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Return the colour, dashes and width of each run, by name.

    Args:
        kind: kind of the named things, the first part of `thing` ("kind:name").
        names: names of the runs.
    """
    looks = zip(names, cycle(CABLES), cycle(OVERLAID), strict=False)
    return {
        name: {"color": colour, "linewidth": width, "linestyle": dashes, "thing": f"{kind}:{name}"}
        for name, colour, (width, dashes) in looks
    }


def shorten(name: str, length: int = 26) -> str:
    """Shorten a long name in the middle; the ends usually distinguish cables."""
    name = " ".join(name.split())
    if len(name) <= length:
        return name
    half = (length - 1) // 2
    return f"{name[: length - 1 - half]}…{name[-half:]}"


def with_unit(text: str, unit: str) -> str:
    """Return the label of an axis."""
    return f"{text} ({typeset(unit)})" if unit else text


def typeset(unit: str) -> str:
    """Return a unit of a column, such as m/s^2, with superscripts."""
    return unit.replace("^2", "²")


def events(run: Run) -> list[Event]:
    """Return the events sorted by time; the first has number 1."""
    return sorted(run.events, key=lambda event: event.time)
