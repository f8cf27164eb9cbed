"""Robots of printer firmware: a nozzle on lines whose drives hold lengths.

The effector is a point: its parallel lines keep it upright. Printers measure in mm, with the origin of the nozzle's
coordinates as the home pose. Numbers that a firmware does not need are assumed, with a warning.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from cdpr.base.problems import Path as Key
from cdpr.cables import ACTUATED
from cdpr.formats.read.imported import Imported

MM = 1e-3  # m

# Assumed values: a light effector on thin lines.
MASS = 2.0  # kg
STIFFNESS = 2.0e4  # N; default of RepRapFirmware for a line of 1.1 mm
DAMPING = 20.0  # N s/m
TAUT = 5.0  # N, of a usual Hangprinter
LIMITS = (0.0, 70.0)  # N; defaults of RepRapFirmware


@dataclass
class Line:
    """Line between an anchor and the nozzle.

    Attributes:
        name: name of its motor.
        anchor: (3,) m, coordinates of the nozzle.
        at: source of the anchor.
        radius: radius of the drum with the nozzle at the home pose, m; None if unknown.
        transmission: other keys of its winch: gear, growth of the drum, lines, reeving.
    """

    name: str
    anchor: list[float]
    at: str
    radius: float | None = None
    transmission: dict[str, float] = field(default_factory=dict)


@dataclass
class Printer:
    """Numbers of a configuration, with the place of each; None if it has none.

    Attributes:
        lines: the lines.
        winch_at: source of the numbers of the winches.
        mass: kg, and its source.
        stiffness: N, and its source.
        low: N, lowest tension of each line, and its source.
        high: N, highest tension of each line, and its source.
        assumed: keys of the file for missing values, by name of the value.
    """

    lines: list[Line]
    winch_at: str = ""
    mass: tuple[float, str] | None = None
    stiffness: tuple[float, str] | None = None
    low: tuple[list[float], str] | None = None
    high: tuple[list[float], str] | None = None
    assumed: dict[str, str] = field(default_factory=dict)


def complete(found: Imported, printer: Printer, file: str, given: tuple[float, float] | None) -> None:
    """Add the robot of a printer to an import.

    Args:
        found: the import, with its name.
        printer: numbers of the file.
        file: name of the file, for warnings.
        given: lowest and highest tension of lines without limits, N.
    """
    stiffness = _value(found, printer.stiffness, STIFFNESS, ("cable", "axial_stiffness"), "N")
    mass = _value(found, printer.mass, MASS, ("platform", "mass"), "kg")
    found.comments["cable", "damping"] = "N s/m, assumed"
    found.robot |= {
        "dof": ["x", "y", "z"],
        "platform": {"mass": mass},
        "tension": _tension(found, printer, given),
        "home": {"position": [0.0, 0.0, 0.0]},
        "cable": {"model": ACTUATED, "axial_stiffness": stiffness, "damping": DAMPING},
    }
    assumed = [
        text
        for text, missing in (
            (f"the mass of the effector, {MASS:g} kg", printer.mass is None),
            (f"the axial stiffness of the lines, {STIFFNESS:g} N", printer.stiffness is None),
            (f"the damping of the lines, {DAMPING:g} N s/m", True),
        )
        if missing
    ]
    found.warnings.append(f"{file}: assumed, because the file does not define them: {'; '.join(assumed)}")
    if given is None and (printer.low is None or printer.high is None):
        low, high = found.robot["tension"]["min"], found.robot["tension"]["max"]
        taut = f", recommended with MIN above 0, such as {TAUT:g}, so that the lines stay taut"
        others = f"--tension MIN,MAX sets others{taut if printer.low is None else ''}"
        found.warnings.append(f"{file}: assumed tension limits: {low} to {high} N; {others}")
    winches: list[dict[str, Any]] = [
        {"type": "position"} | ({} if line.radius is None else {"drum_radius": line.radius}) | line.transmission
        for line in printer.lines
    ]
    rows: list[dict[str, Any]] = [
        {"name": line.name, "frame": line.anchor, "platform": [0.0, 0.0, 0.0]} for line in printer.lines
    ]
    if all(winch == winches[0] for winch in winches):
        found.robot["winch"] = winches[0]
    else:
        found.robot["winch"] = {"type": "position"}
        for row, winch in zip(rows, winches, strict=True):
            row["winch"] = winch
    found.comments["winch",] = "; ".join(["the drives hold lengths", *([printer.winch_at] if printer.winch_at else [])])
    found.robot["cables"] = rows
    found.comments["home",] = "origin of the nozzle's coordinates"
    found.comments["dof",] = "the effector is a point: its parallel lines keep it upright"
    if "drum_radius" not in winches[0]:
        found.left_out.append(f"{file}: the file has no radii of spools: the winches have no drum_radius")
    found.comments["cables",] = "m: anchors, of mm"
    found.comments |= {("cables", k): line.at for k, line in enumerate(printer.lines)}


def _value(found: Imported, given: tuple[float, str] | None, otherwise: float, key: Key, unit: str) -> float:
    value, at = (otherwise, "assumed") if given is None else given
    found.comments[key] = f"{unit}, {at}"
    return value


def _tension(found: Imported, printer: Printer, given: tuple[float, float] | None) -> dict[str, Any]:
    """Return the section of tension limits; limits of the file come before given ones."""
    limits: dict[str, Any] = {}
    for k, (key, own) in enumerate((("min", printer.low), ("max", printer.high))):
        count = len(printer.lines)
        values, at = own or ([LIMITS[k] if given is None else given[k]] * count, "assumed")
        if own is None and given is not None:
            at = "given to the import"
        limits[key] = _common(values)
        found.comments["tension", key] = f"N, {at}"
    return limits


def _common(values: Sequence[float]) -> Any:
    return values[0] if len(set(values)) == 1 else list(values)
