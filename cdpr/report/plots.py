"""The figures of a run. Each function takes a `Run` and returns a matplotlib figure; none needs pyplot."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import cycle
from typing import Any

import numpy as np

from cdpr.log.run import Run
from cdpr.model.robot import Array
from cdpr.report.canvas import INK, SOFT, Chart
from cdpr.report.panels import Curves, Entry, Limit, Panel, shorten, stack

# Red, green and blue for x, y and z, in tones that colour-blind readers can tell apart; the desired motion darker.
AXES = ("#d1402a", "#00a06e", "#2f7fd1")
DARK = ("#6b1204", "#00452f", "#0b2f5c")
# Petroff (2021), arXiv:2107.02270: eight colours made to be told apart by all; then the dashes change.
CABLES = ("#1845fb", "#ff5e02", "#c91f16", "#c849a9", "#adad7d", "#86c8dd", "#578dff", "#656364")
DASHES: tuple[Any, ...] = ("-", (0, (7.0, 1.5, 1.2, 1.5)), (0, (1.2, 1.2)), (0, (3.0, 1.0)))
DESIRED = (0, (3.5, 2.5))


def overview(run: Run) -> Chart:
    """Draw position, errors and tensions with their limits on one page, for notebooks."""
    head = run.header
    title = " · ".join((head.scenario, head.robot, head.backend, head.controller, head.solver))
    notes = [f"{i} {event.kind} at {event.time:.4g} s" for i, event in enumerate(run.events[:4], 1)]
    if len(run.events) > 4:
        notes.append(f"and {len(run.events) - 4} more")
    return stack(run, (_position(run), *_errors(run), _tension(run, height=1.9)), title, ";  ".join(notes))


def pose(run: Run) -> Chart:
    """Draw position and attitude, desired and actual."""
    desired, actual = attitude_angles(run)
    angles = _desired_actual("attitude (°)", np.degrees(desired), np.degrees(actual), 0.1, ("roll", "pitch", "yaw"))
    return stack(run, (_position(run), angles))


def velocity(run: Run) -> Chart:
    """Draw velocity and angular velocity, desired and actual."""
    panels = (
        _desired_actual("velocity (m/s)", run.desired_velocity, run.velocity, least=1e-3),
        _desired_actual("angular velocity (rad/s)", run.desired_angular_velocity, run.angular_velocity, least=1e-3),
    )
    return stack(run, panels)


def acceleration(run: Run) -> Chart:
    """Draw acceleration and angular acceleration, desired and actual (means over each control period)."""
    a, b = run.desired_acceleration, run.desired_angular_acceleration
    panels = (
        _desired_actual("acceleration (m/s²)", a, run.acceleration, least=1e-2),
        _desired_actual("angular accel. (rad/s²)", b, run.angular_acceleration, least=1e-2),
    )
    return stack(run, panels)


def errors(run: Run) -> Chart:
    """Draw position and orientation error: components and norm."""
    return stack(run, _errors(run))


def tensions(run: Run) -> Chart:
    """Draw the tension of each cable and its limits."""
    return stack(run, (_tension(run, height=3.0),))


def cables(run: Run) -> Chart:
    """Draw the cables' lengths and their rates."""
    panels = (
        Panel("cable length (m)", (_per_cable(run.length),), _cable_entries(run), least=1e-3),
        Panel("length rate (m/s)", (_per_cable(run.rate),), least=1e-3),
    )
    return stack(run, panels)


def distribution(run: Run) -> Chart:
    """Draw how far the tensions stay from their limits, and how well they balance the wanted wrench."""
    margin = Curves(run.margin[:, None], (INK,))
    residual = Curves(run.residual[:, None], (INK,))
    panels = (
        Panel("margin (N)", (margin,), least=1e-3, limits=(Limit("at a limit (0 N)", (0.0,)),)),
        Panel("residual (N)", (residual,), least=1.0, log=True),
    )
    return stack(run, panels)


def attitude_angles(run: Run) -> tuple[Array, Array]:
    """Return roll, pitch, yaw of the desired and of the actual attitude, each (K, 3), rad, without jumps of a turn."""
    desired = np.unwrap(_rpy(run.desired_orientation), axis=0)
    apart = _rpy(run.orientation) - desired
    return desired, desired + (apart + np.pi) % (2.0 * np.pi) - np.pi


def _rpy(q: Array) -> Array:
    """Roll, pitch, yaw (K, 3), R = Rz(yaw) Ry(pitch) Rx(roll), of unit quaternions (K, 4)."""
    w, x, y, z = q.T
    roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2 * (w * y - z * x), -1.0, 1.0))
    yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return np.stack([roll, pitch, yaw], axis=1)


def _components(names: Sequence[str]) -> list[Entry]:
    return [(name, {"color": colour, "linewidth": 1.6}) for name, colour in zip(names, AXES, strict=True)]


def _desired_actual(
    label: str, desired: Array, actual: Array, least: float, names: Sequence[str] = ("x", "y", "z")
) -> Panel:
    """Desired over actual, thinner, darker and dashed: where they agree both can be seen."""
    lines = (Curves(actual, AXES, width=1.6), Curves(desired, DARK, (DESIRED,), width=0.9))
    how: list[Entry] = [
        ("actual", {"color": SOFT, "linewidth": 1.6}),
        ("desired", {"color": INK, "linewidth": 0.9, "linestyle": DESIRED}),
    ]
    return Panel(label, lines, [*_components(names), *how], least)


def _position(run: Run) -> Panel:
    return _desired_actual("position (m)", run.desired_position, run.position, least=1e-3)


def _errors(run: Run) -> tuple[Panel, Panel]:
    return (
        _error("position error (mm)", 1e3 * run.position_error),
        _error("orientation error (mrad)", 1e3 * run.orientation_error),
    )


def _error(label: str, components: Array) -> Panel:
    norm = np.linalg.norm(components, axis=1, keepdims=True)
    legend = [*_components("xyz"), ("norm", {"color": INK, "linewidth": 1.2})]
    return Panel(label, (Curves(norm, (INK,)), Curves(components, AXES)), legend)


def _per_cable(values: Array) -> Curves:
    return Curves(values, CABLES * len(DASHES), [dashes for dashes in DASHES for _ in CABLES], width=1.1)


def cable_looks(run: Run) -> list[tuple[str, dict[str, Any]]]:
    """Return name, and colour and dashes, of each cable."""
    looks = [{"color": colour, "linestyle": dashes} for dashes in DASHES for colour in CABLES]
    return list(zip(run.header.cables, cycle(looks), strict=False))


def _cable_entries(run: Run) -> list[Entry]:
    return [(shorten(name), look) for name, look in cable_looks(run)]


def _tension(run: Run, height: float) -> Panel:
    limits = (_limit("t_min", run.header.tension_min), _limit("t_max", run.header.tension_max))
    return Panel("cable tension (N)", (_per_cable(run.tension),), _cable_entries(run), 1.0, limits, height=height)


def _limit(name: str, values: Sequence[float]) -> Limit:
    """One grey line where all cables share the limit, else one for each value in the colour of its first cable."""
    distinct = sorted(set(values))
    if len(distinct) == 1:
        return Limit(f"{name} {distinct[0]:g} N", distinct)
    colours = [CABLES[values.index(value) % len(CABLES)] for value in distinct]
    return Limit(f"{name} {distinct[0]:g} to {distinct[-1]:g} N", distinct, colours)
