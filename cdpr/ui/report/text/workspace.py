"""Workspace as lines of text."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

MOST = 3  # listed causes of cells outside


def lines(figures: Mapping[str, Any]) -> list[str]:
    """Return the result of `Workspace.summary` as lines for a terminal."""
    unit, value = figures["unit"], figures["value"]
    low, high = figures["box"]
    cells = " x ".join(str(n) for n in figures["cells"])
    text = [
        f"{figures['robot']}: {figures['kind']} workspace",
        _line("volume", f"{figures['volume']:.4g} {unit}, {100 * figures['share']:.3g} % of the box"),
    ]
    if figures["found"] is not None:
        text[-1] += f"; at most {figures['found']['at_most']:.4g} {unit}" if "at_most" in figures["found"] else ""
        text.append(FOUND[figures["method"]](figures["found"]))
    if figures["at_least"] is not None:
        text.append(_line("inside from", f"{figures['at_least']:.4g} {value['unit']}".rstrip()))
    if figures["bounds"] is not None:
        text.append(_line("within", _corners(*figures["bounds"])))
        if figures["components"] > 1:
            text.append(_line("in pieces", f"{figures['components']}, no cell of which shares a face with another's"))
        words = ", ".join(f"{name} {value[name]:.4g}" for name in ("min", "mean", "max") if value[name] is not None)
        if words:
            text.append(_line(value["name"], f"{words} {value['unit']}".rstrip()))
        if figures["unlimited"]:
            text.append(_line("" if words else value["name"], f"infinite in {figures['unlimited']} cells"))
    if figures["outside_by"]:
        outside = [f"{name} {count}" for name, count in list(figures["outside_by"].items())[:MOST]]
        text.append(_line("outside, cells by", ", ".join(outside)))
    text.append(_line("evaluated", f"{cells} cells, {_corners(low, high)}{_several(figures['orientations'])}"))
    evaluated, of = figures["evaluated"], math.prod(figures["cells"]) * figures["orientations"]
    if evaluated < of:
        share = f"{100 * evaluated / of:.3g} %"
        text.append(_line("of them evaluated", f"{evaluated}, {share}; the others are interpolated"))
    if (oracle := figures["oracle"]) is not None:
        apart = f"{len(oracle['different'])} different, {oracle['undecided'] + len(oracle['near'])} undecided"
        text.append(_line(f"verified by {oracle['by']}", f"{oracle['poses']} poses: {apart}"))
    text += [f"  {note}" for note in figures["notes"]]
    if figures["on_boundary"] and figures["method"] != "certify":
        why = " or without a proof" if figures["method"] == "combined" else ""
        text.append(_line("on the boundary", f"{figures['on_boundary']} cells, to within round-off{why}"))
    if figures["without_value"]:
        text.append(_line("without a value", f"{figures['without_value']} cells"))
    if "file" in figures:
        text.append(figures["file"])
    return text


def _proved(found: Mapping[str, Any]) -> str:
    percent = ", ".join(
        f"{100 * share:.4g} % {name.removeprefix('proved_')}" for name, share in found["shares"].items()
    )
    return _line("proved", f"{percent}; {found['boxes']} boxes")


def _hull(found: Mapping[str, Any]) -> str:
    centre = ", ".join(f"{value:.4g}" for value in found["centre"])
    seen = f"{100 * found['star_shaped']:.4g} % of what is inside is seen"
    return _line("boundary", f"{found['rays']} rays from {centre} m, from where {seen}; {found['asked']} poses")


def _rays(found: Mapping[str, Any]) -> str:
    return _line("rays", f"{found['rays']} along {found['along']}, {found['stretches']} free stretches")


def _turns(found: Mapping[str, Any]) -> str:
    if found["everywhere"] is None:
        return _line("turns", "nowhere")
    angles = ", ".join(f"{name} {math.degrees(found[name]):.4g}" for name in ("everywhere", "mean", "best"))
    return _line(f"turns about {found['about']}", f"either way: {angles} deg")


FOUND = {"certify": _proved, "hull": _hull, "rays": _rays, "turns": _turns}


def _line(name: str, text: str) -> str:
    return f"  {name:<24}{text}"


def _corners(low: list[float], high: list[float]) -> str:
    pairs = zip("xyz", low, high, strict=True)
    return ", ".join(f"{axis} {a:.4g} to {b:.4g}" if a != b else f"{axis} {a:.4g}" for axis, a, b in pairs) + " m"


def _several(count: int) -> str:
    return "" if count == 1 else f", in {count} attitudes"
