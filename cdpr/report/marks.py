"""What stands for what, in figures and tables alike: colours, dashes, names and the numbers of events."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import cycle
from typing import Any

from cdpr.log.event import Event
from cdpr.log.run import Run
from cdpr.view import colours

INK, SOFT, PALE = colours.INK.light, colours.SOFT.light, colours.PALE.light

# Red, green and blue for x, y and z in tones that colour-blind readers tell apart; desired is darker.
AXES = tuple(pair.light for pair in colours.AXES)
DARK = tuple(pair.light for pair in colours.DESIRED_AXES)
DESIRED = (0, (3.5, 2.5))

# The ninth cable is dashed.
CABLES = tuple(pair.light for pair in colours.CABLES)
DASHES: tuple[Any, ...] = ("-", (0, (7.0, 1.5, 1.2, 1.5)), (0, (1.2, 1.2)), (0, (3.0, 1.0)))

# Looks of several runs over one another: where lines coincide, each is seen below the next, narrower or broken one.
# The widest is less than three times the narrowest, so that none seems to matter more.
OVERLAID: tuple[tuple[float, Any], ...] = (
    (2.6, "-"),
    (2.0, (0, (4.0, 2.0))),
    (1.6, (0, (1.4, 2.0))),
    (1.0, "-"),
    (1.0, (0, (7.0, 2.0, 1.4, 2.0))),
)

# What a status is called where it is shaded.
SHADES = {status: status.name.lower().replace("_", " ") for status in colours.SHADES}

# Stands in the files of figures, by which they are told from what others draw with the same library.
DRAWN_BY = "cdpr, by Matplotlib"

# The least range of errors of the pose, mm and mrad: a nanometre, which nobody can measure on a robot with cables.
LEAST_ERROR = 1e-6


def paired(pair: colours.Pair) -> str:
    """A colour for each ground, as the style of an element of the class "paired"."""
    return f"--light:{pair.light};--dark:{pair.dark}"


def cable_looks(cables: Sequence[str]) -> list[dict[str, Any]]:
    """Return colour and dashes of each cable, given their names."""
    looks = cycle((colour, dashes) for dashes in DASHES for colour in CABLES)
    return [
        {"color": colour, "linestyle": dashes, "thing": f"cable:{name}"}
        for name, (colour, dashes) in zip(cables, looks, strict=False)
    ]


def overlaid_looks(kind: str, names: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Return colour, dashes and width of each of several runs, by name; `kind` tells what the names are of."""
    looks = zip(names, cycle(CABLES), cycle(OVERLAID), strict=False)
    return {
        name: {"color": colour, "linewidth": width, "linestyle": dashes, "thing": f"{kind}:{name}"}
        for name, colour, (width, dashes) in looks
    }


def shorten(name: str, length: int = 26) -> str:
    """Cut the middle out of a long name: the ends tell cables apart."""
    name = " ".join(name.split())
    if len(name) <= length:
        return name
    half = (length - 1) // 2
    return f"{name[: length - 1 - half]}…{name[-half:]}"


def events(run: Run) -> list[Event]:
    """Return the events in the order of time; the first has number 1."""
    return sorted(run.events, key=lambda event: event.time)
