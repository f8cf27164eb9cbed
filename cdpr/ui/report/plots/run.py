"""Time histories of a run: the panels of each figure."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import cycle

import numpy as np

from cdpr.base.column import CABLES as ALL_CABLES
from cdpr.base.column import Column
from cdpr.log.run import Run
from cdpr.scenario.events import limits_change
from cdpr.ui.report.plots.histories import PLUGIN, Points, histories
from cdpr.ui.report.plots.panel import Curves, Entry, Limit, Panel
from cdpr.ui.report.plots.sensors import estimate, names_of, sensors
from cdpr.ui.report.style import AXES, CABLES, DARK, DESIRED, INK, LEAST_ERROR, SOFT, cable_looks, shorten, with_unit


def pose(run: Run) -> list[Panel]:
    """Return panels of position and attitude, desired and actual."""
    both = histories(run)["attitude"]
    desired, actual = both.columns(slice(0, 3)), both.columns(slice(3, 6))
    attitude = _desired_actual("attitude", "attitude (°)", desired, actual, 0.1, ("roll", "pitch", "yaw"))
    return [position_panel(run), attitude]


def velocity(run: Run) -> list[Panel]:
    """Return panels of velocity and angular velocity, desired and actual."""
    linear = _both(run, "velocity (m/s)", "velocity", 1e-3)
    angular = _both(run, "angular velocity (rad/s)", "angular_velocity", 1e-3)
    return [linear, angular]


def acceleration(run: Run) -> list[Panel]:
    """Return panels of acceleration and angular acceleration, desired and actual (means over each period)."""
    linear = _both(run, "acceleration (m/s²)", "acceleration", 1e-2)
    angular = _both(run, "angular accel. (rad/s²)", "angular_acceleration", 1e-2)
    return [linear, angular]


def errors(run: Run) -> list[Panel]:
    """Return panels of the position and orientation error: components and norm."""
    known = histories(run)
    return [
        _error("position_error", "position error (mm)", known["position_error"]),
        _error("orientation_error", "orient. error (mrad)", known["orientation_error"]),
    ]


def tensions(run: Run) -> list[Panel]:
    """Return the tensions and their limits; for non-ideal cables also the difference between command and tension."""
    tension = tension_panel(run, height=3.0)
    if run.header.ideal_cables:
        return [tension]
    more = (_per_cable(run, "friction"),)
    return [tension, Panel("command minus tension (N)", more, _cable_entries(run), 1e-3, name="friction")]


def cables(run: Run) -> list[Panel]:
    """Return panels of the cable lengths and their rates."""
    length = Panel("cable length (m)", (_per_cable(run, "length"),), _cable_entries(run), 1e-3, name="length")
    return [length, Panel("length rate (m/s)", (_per_cable(run, "rate"),), least=1e-3, name="rate")]


def distribution(run: Run) -> list[Panel]:
    """Return panels of the distance to the tension limits, and of the residual wrench."""
    margin, residual = (Curves(histories(run)[name], (INK,), names=(name,)) for name in ("margin", "residual"))
    limit = Limit("at a limit (0 N)", (0.0,))
    return [
        Panel("margin (N)", (margin,), least=1.0, limits=(limit,), name="margin"),
        Panel("residual (N)", (residual,), least=2.0, log=True, name="residual"),
    ]


def motors(run: Run) -> list[Panel]:
    """Return panels of the currents and electrical powers of the motors, if these are known."""
    if not run.header.layout.has("electrical"):
        return []
    labels = {"motor_current": "motor current (A)", "electrical_power": "electrical power (W)"}
    return [
        Panel(label, (_per_cable(run, name),), _cable_entries(run), 1e-3, name=name) for name, label in labels.items()
    ]


def energy(run: Run) -> list[Panel]:
    """Return panels of the external wrench (if any), energies and works, powers, and the unexplained energy."""
    known = histories(run)
    names = ["kinetic", "potential (change)", "work of cables", "external work"]
    names += [f"work of {source}" for source in run.header.further_works]
    energies, powers, external = known["energies"], known["powers"], known["external"]
    panels = []
    if np.any(external.values):
        force, moment = (
            Curves(external.columns(part), AXES, names="xyz", group="axis") for part in (slice(0, 3), slice(3, 6))
        )
        panels.append(Panel("external force (N)", (force,), _components("xyz"), 1.0, name="external_force"))
        panels.append(Panel("external moment (N m)", (moment,), _components("xyz"), 1.0, name="external_moment"))
    else:
        names.remove("external work")
        energies, powers = energies.columns([0, 1, 2, *range(4, len(names) + 1)]), powers.columns(slice(0, 1))
    looks: list[Entry] = [(name, {"color": colour}) for name, colour in zip(names, cycle(CABLES), strict=False)]
    stored = Curves(energies, CABLES, names=names)
    unexplained = Curves(known["energy_residual"], (INK,), names=("unexplained",))
    panels += [
        Panel("energy (J)", (stored,), looks, 1.0, name="energy"),
        Panel("power (W)", (Curves(powers, CABLES[2:], names=("of cables", "external")),), least=1.0, name="power"),
        Panel("unexplained (J)", (unexplained,), least=1e-9, name="energy_residual"),
    ]
    return panels


def plugins(run: Run) -> list[Panel]:
    """Return a panel for each column that plugins recorded."""
    return [_column(run, column) for column in run.header.columns if column.owner]


def further(run: Run) -> list[Panel]:
    """Return a panel for each other column that not all runs have."""
    shown = names_of(run)
    return [_column(run, column) for column in run.header.columns if not column.owner and column.name not in shown]


def _column(run: Run, column: Column) -> Panel:
    names = run.header.cables if column.width == ALL_CABLES else column.labels(())
    looks = cable_looks(names)
    colours, dashes = [look["color"] for look in looks], [look["linestyle"] for look in looks]
    legend: list[Entry] = [(shorten(name), look) for name, look in zip(names, looks, strict=True)]
    label = with_unit(shorten(column.name), column.unit)
    group = "cable" if column.width == ALL_CABLES else ""
    lines = Curves(histories(run)[PLUGIN + column.name], colours, dashes, names=names, group=group)
    return Panel(label, (lines,), legend if column.width != 1 else (), name=column.name)


def _components(names: Sequence[str]) -> list[Entry]:
    return [(name, {"color": colour, "linewidth": 1.6}) for name, colour in zip(names, AXES, strict=True)]


def _desired_actual(
    name: str, label: str, desired: Points, actual: Points, least: float, names: Sequence[str] = "xyz"
) -> Panel:
    """Return a panel with desired over actual values: thinner, darker and dashed, so that both remain visible."""
    lines = (
        Curves(actual, AXES, width=1.6, names=names, group="axis"),
        Curves(desired, DARK, (DESIRED,), 0.9, [f"{name} desired" for name in names], "over"),
    )
    how: list[Entry] = [
        ("actual", {"color": SOFT, "linewidth": 1.6}),
        ("desired", {"color": INK, "linewidth": 0.9, "linestyle": DESIRED}),
    ]
    return Panel(label, lines, [*_components(names), *how], least, name=name)


def _both(run: Run, label: str, name: str, least: float) -> Panel:
    known = histories(run)
    return _desired_actual(name, label, known[f"desired_{name}"], known[name], least)


def position_panel(run: Run) -> Panel:
    """Return the panel of the position, desired and actual."""
    return _both(run, "position (m)", "position", 1e-3)


def _error(name: str, label: str, values: Points) -> Panel:
    lines = (
        Curves(values.columns(slice(0, 1)), (INK,), names=("norm",)),
        Curves(values.columns(slice(1, 4)), AXES, names="xyz", group="axis"),
    )
    legend = [*_components("xyz"), ("norm", {"color": INK, "linewidth": 1.2})]
    return Panel(label, lines, legend, LEAST_ERROR, name=name)


def _per_cable(run: Run, name: str) -> Curves:
    looks = cable_looks(run.header.cables)
    colours, dashes = [look["color"] for look in looks], [look["linestyle"] for look in looks]
    return Curves(histories(run)[name], colours, dashes, names=run.header.cables, group="cable")


def _cable_entries(run: Run) -> list[Entry]:
    return [(shorten(name), look) for name, look in zip(run.header.cables, cable_looks(run.header.cables), strict=True)]


def tension_panel(run: Run, height: float) -> Panel:
    """Return the panel of the cable tensions and their limits."""
    lines = (_per_cable(run, "cable_tension"),)
    limits = tension_limits(run, range(len(run.header.cables)))
    return Panel("cable tension (N)", lines, _cable_entries(run), 1.0, limits, height=height, name="tension")


def tension_limits(run: Run, cables: Sequence[int]) -> tuple[Limit, ...]:
    """Return the finite tension limits of these cables, counted from 0."""
    head = run.header
    first = " at first" if limits_change({event.kind for event in run.events}) else ""
    both = (("t_min", head.tension_min), ("t_max", head.tension_max))
    finite = [(name, values, [i for i in cables if math.isfinite(values[i])]) for name, values in both]
    return tuple(_limit(name + first, limited, values) for name, values, limited in finite if limited)


def _limit(name: str, cables: Sequence[int], values: Sequence[float]) -> Limit:
    """Return one grey line if the cables share the limit; otherwise one per value, in the colour of its first cable."""
    first = {values[i]: i for i in reversed(cables)}
    distinct = sorted(first)
    if len(distinct) == 1:
        return Limit(f"{name} {distinct[0]:g} N", distinct)
    colours = [CABLES[first[value] % len(CABLES)] for value in distinct]
    return Limit(f"{name} {distinct[0]:g}–{distinct[-1]:g} N", distinct, colours)


FIGURES = (
    plugins,
    further,
    sensors,
    estimate,
    pose,
    velocity,
    acceleration,
    errors,
    tensions,
    cables,
    distribution,
    motors,
    energy,
)


# Panels of rotations, constant zeros for robots whose platform cannot turn.
ROTATIONS = frozenset(
    (
        "attitude",
        "angular_velocity",
        "angular_acceleration",
        "orientation_error",
        "estimated_orientation",
        "estimated_angular_velocity",
        "estimate_error_attitude",
        "estimate_error_angular_velocity",
    )
)


def without_rotations(panels: Sequence[Panel]) -> list[Panel]:
    """Return the panels that also show something if the platform cannot turn."""
    return [panel for panel in panels if panel.name not in ROTATIONS]


def by_name(run: Run) -> dict[str, Panel]:
    """Return all panels of a run by name."""
    return {panel.name: panel for figure in FIGURES for panel in figure(run)}
