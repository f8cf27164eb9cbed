"""Robot, pose and motion, from `cdpr.analysis.distribution.describe`, as aligned text."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from cdpr.mechanics.contacts import passing
from cdpr.ui.report.text.aligned import condition_number, row, table, turned, unrounded, vector
from cdpr.ui.report.text.closed_loop import closed_loop_lines
from cdpr.ui.report.text.distributions import highest
from cdpr.ui.report.text.least import least_of

CONSTRAINTS = {
    "fully constrained": "some t > 0 has W t = 0, so that the cables can balance any wrench",
    "suspended": "no t > 0 has W t = 0; only a load, such as the weight, keeps all cables tight",
    "singular": "some t > 0 has W t = 0, but the cables do not resist some motion",
}
LEGS = {**CONSTRAINTS, "fully constrained": "rigid legs push and pull, so that they can balance any wrench"}
LEGS["singular"] = "the cables do not resist some motion"

OPTIONAL = {
    "diameter_m": "diameter (m)",
    "axial_stiffness_N": "E A (N)",
    "linear_density_kg_per_m": "density (kg/m)",
    "length_min_m": "shortest (m)",
    "length_max_m": "longest (m)",
    "speed_max_m_per_s": "fastest (m/s)",
}
RANGES = {"length_m": "length (m)", "rate_m_per_s": "rate (m/s)", "tension_N": "tension (N)"}

# Smaller rates are round-off of zero.
ROUND_OFF = 1e-12


def lines(figures: dict[str, Any]) -> Iterator[str]:
    """Yield the lines of `robot`, `pose` and, if present, `motion` and `closed_loop`."""
    robot, pose = figures["robot"], figures["pose"]
    platform = robot["platform"]
    yield robot["name"]
    yield row("degrees of freedom", f"n = {robot['n']}: {', '.join(robot['dof'])} ({robot['motion_pattern']})")
    legs = "" if robot["unilateral"] else " (rigid legs, which also push)"
    yield row("cables", f"m = {robot['m']}{legs}, redundancy r = m - n = {robot['redundancy']}")
    yield row("restraint by number", f"{robot['restraint']}: {robot['restraint_meaning']}")
    if robot["few_cables"]:
        yield row("", robot["few_cables"])
    yield row("platform", f"{platform['mass_kg']:g} kg, {_shape(platform['shape_m'])}")
    yield row("centre of mass", f"{vector(platform['center_of_mass_m'])} m from the origin")
    if any(name.startswith("r") for name in robot["dof"]):
        i = platform["inertia_kg_m2"]
        entries = (i[0][0], i[1][1], i[2][2], i[0][1], i[0][2], i[1][2])
        yield row("inertia", f"{vector(entries)} kg m^2 (xx, yy, zz, xy, xz, yz)")
    for name, point in platform["tools_m"].items():
        yield row("tool", f"{name} at {vector(point)} m")
    if "believed" in robot:
        yield row("nominal model", robot["believed"])
    if robot.get("sag"):
        yield row("cables sag", f"in runs; {robot['sag']}")
    if robot.get("friction"):
        yield row("pulleys", f"friction in runs; {robot['friction']}")
    yield f"at {vector(pose['position_m'])} m{turned(pose['orientation_wxyz'])} ({pose['source']})"
    meaning = (CONSTRAINTS if robot["unilateral"] else LEGS)[pose["constraint"]]
    yield row("constraint", f"{pose['constraint']}: {meaning}")
    yield row("rank of W", f"{pose['rank']} of n = {robot['n']}")
    for twist in pose["unresisted_twists"]:
        yield row("no resistance to", f"{_twist(twist)}: it changes no cable's length")
    yield row("condition number", condition_number(pose["condition_number"], robot))
    if pose["static_problem"]:
        yield row("static tensions", f"none: {pose['static_problem']}")
        yield row("", f"the nearest within the limits leave {pose['static_residual_N']:.4g} N unbalanced")
    else:
        t = unrounded(pose["static_tension_N"])
        span = f"{min(t):.5g} to {max(t):.5g} N"
        yield row("static tensions", f"{span} (qp), smallest margin {pose['static_margin_N']:.4g} N")
    if (least := pose.get("least_winch_tension_N")) is not None:
        yield row("least tensions", f"{min(least):.4g} to {max(least):.4g} N at the winches carry the cables' weight")
    if pose.get("clearance_m") is not None:
        gap = pose["clearance_m"]
        through = passing(names := pose["clearance_by"], gap)
        distance = f"{gap:.4g} m{': TOUCHING' if gap < 0.0 else ''}, {names}"
        yield row("least clearance", f"none: {through}" if through else distance)
    yield from _cables(robot["cables"], pose)
    if "motion" in figures:
        yield from _motion(figures["motion"], robot["dof"])
    if "closed_loop" in figures:
        yield from closed_loop_lines(figures["closed_loop"])


def _cables(cables: list[dict[str, Any]], pose: dict[str, Any]) -> Iterator[str]:
    tensions: list[Any] = unrounded(pose["static_tension_N"] or []) or ["none"] * len(cables)
    rows = [
        [
            cable["name"],
            vector(cable["frame_m"]),
            vector(cable["platform_m"]),
            f"{cable['tension_min_N']:g} to {highest(cable):g}",
            f"{length:.4f}",
            tension if isinstance(tension, str) else f"{tension:.5g}",
        ]
        for cable, length, tension in zip(cables, pose["length_m"], tensions, strict=True)
    ]
    yield from table([["cable", "frame A (m)", "platform B (m)", "limits (N)", "length (m)", "tension (N)"], *rows])
    for key, title in OPTIONAL.items():
        values = ["unknown" if cable[key] is None else f"{cable[key]:g}" for cable in cables]
        if set(values) != {"unknown"}:
            yield row(title, f"{values[0]}, all cables" if len(set(values)) == 1 else ", ".join(values))
    yield from _winches(cables)


def _winch(winch: dict[str, Any] | None) -> str:
    """Return a winch as text: type, radius, transmission, inertia, and the steps of a stepper."""
    if winch is None:
        return "none"
    words = [winch["type"]]
    if winch["drum_radius_m"] is not None:
        grows = f" growing by {winch['drum_growth_m']:g} m^2 per m" if winch["drum_growth_m"] else ""
        words.append(f"drum of {winch['drum_radius_m']:g} m{grows}")
    if winch["gear_ratio"] != 1.0:
        words.append(f"gear {winch['gear_ratio']:g}:1")
    if winch["efficiency"] != 1.0:
        words.append(f"efficiency {winch['efficiency']:g}")
    if winch["reeving"] != 1.0:
        words.append(f"{winch['reeving']:g} falls")
    words.append("ideal" if winch["inertia_kg_m2"] is None else f"{winch['inertia_kg_m2']:g} kg m^2 at the drum")
    if "resistance_ohm" in winch:
        words.append(f"motor of {winch['torque_constant_N_m_per_A']:g} N m/A and {winch['resistance_ohm']:g} ohm")
    if "microsteps" in winch:
        words.append(f"{winch['steps_per_turn']:g} steps per turn, {winch['microsteps']:g} microsteps")
        torque = winch["stall_torque_N_m"]
        words.append("stall torque unknown" if torque is None else f"stall torque {torque:g} N m")
    return ", ".join(words)


def _winches(cables: list[dict[str, Any]]) -> Iterator[str]:
    """Yield a line for each group of cables with equal winches."""
    groups: dict[str, list[str]] = {}
    for cable in cables:
        groups.setdefault(_winch(cable["winch"]), []).append(cable["name"])
    if set(groups) != {"none"}:
        for text, names in groups.items():
            yield row("winch", f"{text}; {'all cables' if len(groups) == 1 else ', '.join(names)}")


def _motion(motion: dict[str, Any], dof: list[str]) -> Iterator[str]:
    span, end = motion["duration_s"], motion["end_s"]
    moves = motion["speed_max_m_per_s"] or motion["angular_speed_max_rad_per_s"]
    until = f" (it ends at {end:.6g} s)" if moves and end < span else ""
    if end > span:
        until = f" of the {end:g} s until it ends: simulation.duration stops it on its way"
    yield f"motion: {motion['type']}, {span:g} s{until}, {motion['samples']} samples evaluated"
    yield row("path length", f"{motion['path_length_m']:.4g} m")
    speed, acceleration = motion["speed_max_m_per_s"], motion["acceleration_max_m_per_s2"]
    yield row("peak speed", f"{speed:.4g} m/s, acceleration {acceleration:.4g} m/s^2")
    speed, acceleration = motion["angular_speed_max_rad_per_s"], motion["angular_acceleration_max_rad_per_s2"]
    yield row("peak angular speed", f"{speed:.4g} rad/s, acceleration {acceleration:.4g} rad/s^2")
    if motion["controlled"] != dof:
        yield row(
            "controlled", f"{', '.join(motion['controlled'])}: the cables balance the wrench in these directions only"
        )
    if motion["events"]:
        yield row("with its events", ", ".join(motion["events"]))
    if motion.get("tensions"):
        yield row("tensions", motion["tensions"])
    feasible = f"{100 * motion['feasible_share']:.4g} % of the samples"
    if motion["first_infeasible_s"] is not None:
        feasible += f"; first not at {motion['first_infeasible_s']:.4g} s (tensions below: the nearest)"
    yield row("feasible", feasible)
    if motion["smallest_margin_N"] is not None:
        yield row("smallest margin", f"{motion['smallest_margin_N']:.4g} N at {motion['smallest_margin_at_s']:.4g} s")
    for title, text in least_of(motion.get("least", {})):
        yield row(title, text)
    rows = [[cable["name"], *(" to ".join(map(_number, cable[key])) for key in RANGES)] for cable in motion["cables"]]
    yield from table([["cable", *RANGES.values()], *rows])
    for text in motion["exceeded"]:
        yield f"  exceeded: {text}"


def _twist(twist: list[float]) -> str:
    """Return a twist as text: the axes of translation and rotation."""
    moves, turns = _axes(twist[:3], "m/s"), _axes(twist[3:], "rad/s")
    parts = [*([f"moving along {moves}"] if moves else []), *([f"turning about {turns}"] if turns else [])]
    return " while ".join(parts)


def _axes(rates: list[float], unit: str) -> str:
    named = [(axis, rate) for axis, rate in zip("xyz", rates, strict=True) if rate]
    if len(named) == 1 and abs(named[0][1]) == 1.0:
        return named[0][0]
    return ", ".join(f"{axis} at {rate:.4g} {unit}" for axis, rate in named)


def _number(value: float) -> str:
    return "0" if abs(value) < ROUND_OFF else f"{value:.4g}"


def _shape(shape: dict[str, Any] | None) -> str:
    if shape is None:
        return "no shape given"
    if "box" in shape:
        return f"box of {vector(shape['box'])} m"
    if "sphere" in shape:
        return f"sphere of {shape['sphere']:g} m radius"
    if "cylinder" in shape:
        return "cylinder of {:g} m radius, {:g} m high".format(*shape["cylinder"])
    lower, upper = map(vector, shape["mesh"])
    return f"mesh from {lower} to {upper} m"
