"""The time histories of a run. Each function returns a matplotlib figure; none needs pyplot."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cdpr import columns
from cdpr.log.run import Run
from cdpr.report.figures.canvas import Chart, styled
from cdpr.report.figures.legend import Entry
from cdpr.report.figures.panels import Curves, Limit, Panel, stack
from cdpr.report.marks import AXES, CABLES, DARK, DESIRED, INK, SOFT, cable_looks, events, shorten
from cdpr.report.plots.histories import PLUGIN, Points, histories
from cdpr.scenario.events import limits_change


@styled
def overview(run: Run) -> Chart:
    """Draw position, errors and tensions with their limits on one page, for notebooks."""
    head = run.header
    title = " · ".join((head.scenario, head.robot, head.backend, head.controller, head.solver))
    notes = [f"{i} {event.kind} at {event.time:.4g} s" for i, event in enumerate(events(run)[:4], 1)]
    if len(run.events) > 4:
        notes.append(f"and {len(run.events) - 4} more")
    return stack(run, (_position(run), *_errors(run), _tension(run, height=1.9)), title, ";  ".join(notes))


@styled
def pose(run: Run) -> Chart:
    """Draw position and attitude, desired and actual."""
    both = histories(run)["attitude"]
    desired, actual = both.columns(slice(0, 3)), both.columns(slice(3, 6))
    attitude = _desired_actual("attitude (°)", desired, actual, 0.1, ("roll", "pitch", "yaw"))
    return stack(run, (_position(run), attitude))


@styled
def velocity(run: Run) -> Chart:
    """Draw velocity and angular velocity, desired and actual."""
    linear = _both(run, "velocity (m/s)", "velocity", 1e-3)
    angular = _both(run, "angular velocity (rad/s)", "angular_velocity", 1e-3)
    return stack(run, (linear, angular))


@styled
def acceleration(run: Run) -> Chart:
    """Draw acceleration and angular acceleration, desired and actual (means over each period)."""
    linear = _both(run, "acceleration (m/s²)", "acceleration", 1e-2)
    angular = _both(run, "angular accel. (rad/s²)", "angular_acceleration", 1e-2)
    return stack(run, (linear, angular))


@styled
def errors(run: Run) -> Chart:
    """Draw position and orientation error: components and norm."""
    return stack(run, _errors(run))


@styled
def tensions(run: Run) -> Chart:
    """Draw the tension of each cable, and the limits; where cables are not ideal, also how commands differ."""
    tension = _tension(run, height=3.0)
    if run.header.ideal_cables:
        return stack(run, (tension,))
    more = (_per_cable(run, "friction"),)
    return stack(run, (tension, Panel("command minus tension (N)", more, _cable_entries(run), 1e-3)))


@styled
def cables(run: Run) -> Chart:
    """Draw the cables' lengths and their rates."""
    length = Panel("cable length (m)", (_per_cable(run, "length"),), _cable_entries(run), 1e-3)
    return stack(run, (length, Panel("length rate (m/s)", (_per_cable(run, "rate"),), least=1e-3)))


@styled
def distribution(run: Run) -> Chart:
    """Draw how far the tensions stay from their limits, and how well they balance the wanted wrench."""
    margin, residual = (Curves(histories(run)[name], (INK,)) for name in ("margin", "residual"))
    limit = Limit("at a limit (0 N)", (0.0,))
    panels = (
        Panel("margin (N)", (margin,), least=1.0, limits=(limit,)),
        Panel("residual (N)", (residual,), least=2.0, log=True),
    )
    return stack(run, panels)


@styled
def energy(run: Run) -> Chart:
    """Draw the external wrench, if there is one, energies and works, powers, and what no work explains."""
    known = histories(run)
    energies, powers, external = known["energies"], known["powers"], known["external"]
    panels = []
    if np.any(external.values):
        force, moment = (Curves(external.columns(part), AXES) for part in (slice(0, 3), slice(3, 6)))
        panels.append(Panel("external force (N)", (force,), _components("xyz"), 1.0))
        panels.append(Panel("external moment (N m)", (moment,), _components("xyz"), 1.0))
    else:
        energies, powers = energies.columns(slice(0, 3)), powers.columns(slice(0, 1))
    names = ("kinetic", "potential (change)", "work of cables", "external work")
    looks: list[Entry] = [(name, {"color": colour}) for name, colour in zip(names, CABLES, strict=False)]
    panels += [
        Panel("energy (J)", (Curves(energies, CABLES),), looks[: energies.values.shape[1]], 1.0),
        Panel("power (W)", (Curves(powers, CABLES[2:]),), least=1.0),
        Panel("unexplained (J)", (Curves(known["energy_residual"], (INK,)),), least=1e-9),
    ]
    return stack(run, panels)


@styled
def plugins(run: Run) -> Chart:
    """Draw what the plugins recorded of their own: a panel for each column."""
    return stack(run, [_column(run, column) for column in run.header.columns])


def _column(run: Run, column: columns.Column) -> Panel:
    names = run.header.cables if column.width == columns.CABLES else column.labels(())
    looks = cable_looks(names)
    colours, dashes = [look["color"] for look in looks], [look["linestyle"] for look in looks]
    legend: list[Entry] = [(shorten(name), look) for name, look in zip(names, looks, strict=True)]
    label = f"{shorten(column.name)} ({column.unit})" if column.unit else shorten(column.name)
    lines = Curves(histories(run)[PLUGIN + column.name], colours, dashes)
    return Panel(label, (lines,), legend if column.width != 1 else ())


def _components(names: Sequence[str]) -> list[Entry]:
    return [(name, {"color": colour, "linewidth": 1.6}) for name, colour in zip(names, AXES, strict=True)]


def _desired_actual(
    label: str, desired: Points, actual: Points, least: float, names: Sequence[str] = ("x", "y", "z")
) -> Panel:
    """Desired over actual, thinner, darker and dashed: where they agree both can be seen."""
    lines = (Curves(actual, AXES, width=1.6), Curves(desired, DARK, (DESIRED,), width=0.9))
    how: list[Entry] = [
        ("actual", {"color": SOFT, "linewidth": 1.6}),
        ("desired", {"color": INK, "linewidth": 0.9, "linestyle": DESIRED}),
    ]
    return Panel(label, lines, [*_components(names), *how], least)


def _both(run: Run, label: str, name: str, least: float) -> Panel:
    known = histories(run)
    return _desired_actual(label, known[f"desired_{name}"], known[name], least)


def _position(run: Run) -> Panel:
    return _both(run, "position (m)", "position", 1e-3)


def _errors(run: Run) -> tuple[Panel, Panel]:
    position = _error("position error (mm)", histories(run)["position_error"])
    return position, _error("orient. error (mrad)", histories(run)["orientation_error"])


def _error(label: str, values: Points) -> Panel:
    lines = (Curves(values.columns(slice(0, 1)), (INK,)), Curves(values.columns(slice(1, 4)), AXES))
    return Panel(label, lines, [*_components("xyz"), ("norm", {"color": INK, "linewidth": 1.2})])


def _per_cable(run: Run, name: str) -> Curves:
    looks = cable_looks(run.header.cables)
    return Curves(histories(run)[name], [look["color"] for look in looks], [look["linestyle"] for look in looks])


def _cable_entries(run: Run) -> list[Entry]:
    return [(shorten(name), look) for name, look in zip(run.header.cables, cable_looks(run.header.cables), strict=True)]


def _tension(run: Run, height: float) -> Panel:
    first = " at first" if limits_change({event.kind for event in run.events}) else ""
    limits = tuple(
        _limit(name + first, values)
        for name, values in (("t_min", run.header.tension_min), ("t_max", run.header.tension_max))
    )
    lines = (_per_cable(run, "cable_tension"),)
    return Panel("cable tension (N)", lines, _cable_entries(run), 1.0, limits, height=height)


def _limit(name: str, values: Sequence[float]) -> Limit:
    """One grey line if all cables share the limit, else one for each value, coloured as its first cable."""
    distinct = sorted(set(values))
    if len(distinct) == 1:
        return Limit(f"{name} {distinct[0]:g} N", distinct)
    colours = [CABLES[values.index(value) % len(CABLES)] for value in distinct]
    return Limit(f"{name} {distinct[0]:g}–{distinct[-1]:g} N", distinct, colours)
