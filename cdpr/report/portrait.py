"""Robot, pose and motion, as `cdpr.tension.portrait` describes them, in aligned text."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

CONSTRAINTS = {
    "fully constrained": "some t > 0 has W t = 0, so that the cables can balance any wrench",
    "suspended": "no t > 0 has W t = 0; only a load, such as the weight, keeps all cables tight",
    "singular": "some t > 0 has W t = 0, but some motion meets no resistance",
}
LEGS = {**CONSTRAINTS, "fully constrained": "rigid legs push and pull, so that they can balance any wrench"}
LEGS["singular"] = "some motion meets no resistance"

OPTIONAL = {
    "diameter_m": "diameter (m)",
    "axial_stiffness_N": "E A (N)",
    "linear_density_kg_per_m": "density (kg/m)",
    "length_min_m": "shortest (m)",
    "length_max_m": "longest (m)",
    "speed_max_m_per_s": "fastest (m/s)",
}
RANGES = {"length_m": "length (m)", "rate_m_per_s": "rate (m/s)", "tension_N": "tension (N)"}

# Rates and the like below this are round-off of zero.
ROUND_OFF = 1e-12


def lines(figures: dict[str, Any]) -> Iterator[str]:
    """Yield the lines of `robot`, `pose` and, if there, `motion`."""
    robot, pose = figures["robot"], figures["pose"]
    platform = robot["platform"]
    yield robot["name"]
    yield _row("degrees of freedom", f"n = {robot['n']}: {', '.join(robot['dof'])} ({robot['motion_pattern']})")
    legs = "" if robot["unilateral"] else " (rigid legs, which also push)"
    yield _row("cables", f"m = {robot['m']}{legs}, redundancy r = m - n = {robot['redundancy']}")
    yield _row("restraint by number", f"{robot['restraint']}: {robot['restraint_meaning']}")
    yield _row("platform", f"{platform['mass_kg']:g} kg, {_shape(platform['shape_m'])}")
    yield _row("centre of mass", f"{_vector(platform['center_of_mass_m'])} m from the origin")
    if any(name.startswith("r") for name in robot["dof"]):
        i = platform["inertia_kg_m2"]
        entries = (i[0][0], i[1][1], i[2][2], i[0][1], i[0][2], i[1][2])
        yield _row("inertia", f"{_vector(entries)} kg m^2 (xx, yy, zz, xy, xz, yz)")
    yield f"at {_vector(pose['position_m'])} m{_turned(pose['orientation_wxyz'])} ({pose['source']})"
    meaning = (CONSTRAINTS if robot["unilateral"] else LEGS)[pose["constraint"]]
    yield _row("constraint", f"{pose['constraint']}: {meaning}")
    lacking = ": some motions change no cable's length" if pose["rank"] < robot["n"] else ""
    yield _row("rank of W", f"{pose['rank']} of n = {robot['n']}{lacking}")
    yield _row("condition number", _condition(pose["condition_number"], robot))
    if pose["static_problem"]:
        yield _row("static tensions", f"none: {pose['static_problem']}")
        yield _row("", f"the nearest within the limits leave {pose['static_residual_N']:.4g} N unbalanced")
    else:
        t = pose["static_tension_N"]
        span = f"{min(t):.5g} to {max(t):.5g} N"
        yield _row("static tensions", f"{span} (qp), smallest margin {pose['static_margin_N']:.4g} N")
    yield from _cables(robot["cables"], pose)
    if "motion" in figures:
        yield from _motion(figures["motion"])


def _cables(cables: list[dict[str, Any]], pose: dict[str, Any]) -> Iterator[str]:
    tensions = pose["static_tension_N"] or ["none"] * len(cables)
    rows = [
        [
            cable["name"],
            _vector(cable["frame_m"]),
            _vector(cable["platform_m"]),
            f"{cable['tension_min_N']:g} to {cable['tension_max_N']:g}",
            f"{length:.4f}",
            tension if isinstance(tension, str) else f"{tension:.2f}",
        ]
        for cable, length, tension in zip(cables, pose["length_m"], tensions, strict=True)
    ]
    yield from _table([["cable", "frame A (m)", "platform B (m)", "limits (N)", "length (m)", "tension (N)"], *rows])
    for key, title in OPTIONAL.items():
        values = ["unknown" if cable[key] is None else f"{cable[key]:g}" for cable in cables]
        if set(values) != {"unknown"}:
            yield _row(title, f"{values[0]}, all cables" if len(set(values)) == 1 else ", ".join(values))


def _motion(motion: dict[str, Any]) -> Iterator[str]:
    yield f"motion: {motion['type']}, {motion['duration_s']:g} s, looked at in {motion['samples']} samples"
    yield _row("path length", f"{motion['path_length_m']:.4g} m")
    speed, acceleration = motion["speed_max_m_per_s"], motion["acceleration_max_m_per_s2"]
    yield _row("peak speed", f"{speed:.4g} m/s, acceleration {acceleration:.4g} m/s^2")
    speed, acceleration = motion["angular_speed_max_rad_per_s"], motion["angular_acceleration_max_rad_per_s2"]
    yield _row("peak angular speed", f"{speed:.4g} rad/s, acceleration {acceleration:.4g} rad/s^2")
    feasible = f"{100 * motion['feasible_share']:.4g} % of the samples"
    if motion["first_infeasible_s"] is not None:
        feasible += f"; first not at {motion['first_infeasible_s']:.4g} s (tensions below: the nearest)"
    yield _row("feasible", feasible)
    if motion["smallest_margin_N"] is not None:
        yield _row("smallest margin", f"{motion['smallest_margin_N']:.4g} N at {motion['smallest_margin_at_s']:.4g} s")
    rows = [[cable["name"], *(" to ".join(map(_number, cable[key])) for key in RANGES)] for cable in motion["cables"]]
    yield from _table([["cable", *RANGES.values()], *rows])
    for text in motion["exceeded"]:
        yield f"  exceeded: {text}"


def _table(rows: list[list[str]]) -> Iterator[str]:
    widths = [max(len(cell) for cell in column) for column in zip(*rows, strict=True)]
    for row in rows:
        first, *rest = (
            f"{cell:<{w}}" if i == 0 else f"{cell:>{w}}" for i, (cell, w) in enumerate(zip(row, widths, strict=True))
        )
        yield f"  {first}  {'  '.join(rest)}".rstrip()


def _row(name: str, value: str) -> str:
    return f"  {name:<21}{value}"


def _vector(values: Sequence[float]) -> str:
    return "[" + ", ".join(f"{value:.6g}" for value in values) + "]"


def _number(value: float) -> str:
    return "0" if abs(value) < ROUND_OFF else f"{value:.4g}"


def _shape(shape: dict[str, Any] | None) -> str:
    if shape is None:
        return "no shape given"
    return f"box of {_vector(shape['box'])} m" if "box" in shape else f"sphere of {shape['sphere']:g} m radius"


def _turned(q: list[float]) -> str:
    """Roll, pitch, yaw of a quaternion, for people."""
    w, x, y, z = q
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
    yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    upright = max(abs(x), abs(y), abs(z)) < 1e-12
    return ", upright" if upright else f", roll pitch yaw {_vector([roll, pitch, yaw])} rad"


def _condition(value: float | None, robot: dict[str, Any]) -> str:
    number = "infinite" if value is None else f"{value:.4g}"
    if not any(name.startswith("r") for name in robot["dof"]):
        return number
    return f"{number} (moments divided by the characteristic length, {robot['characteristic_length_m']:.4g} m)"
