"""Plain figures of a robot, a pose and a motion with units in their names: the output of `cdpr info`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cdpr.analysis.distribution.survey import Survey, survey
from cdpr.cables import WINCH_TYPES, bends, rubs
from cdpr.cables.drum import INERTIA, RADIUS
from cdpr.cables.motor import RESISTANCE, TORQUE_CONSTANT
from cdpr.cables.stepper import MICROSTEPS, STALL_TORQUE, STEPS_PER_TURN
from cdpr.cables.transmission import EFFICIENCY, GEAR_RATIO, GROWTH, REEVING
from cdpr.mechanics.exit_friction import FRICTIONLESS
from cdpr.mechanics.kinematics import make_state
from cdpr.mechanics.properties import check_lengths, conditioning, free_wrench_matrix, unresisted
from cdpr.mechanics.reach import Reach, bounds_of, plain_columns
from cdpr.mechanics.restraint import RESTRAINTS, few_cables, restraint
from cdpr.mechanics.sag import CHORD, least_tensions
from cdpr.model import Cable
from cdpr.model.robot import Array, Robot
from cdpr.tension.checks import RESIDUAL_TOLERANCE, newton
from cdpr.tension.closure import positive_null_vector
from cdpr.tension.stage import Solve

OPTIONAL = {
    "diameter_m": "diameter",
    "axial_stiffness_N": "axial_stiffness",
    "linear_density_kg_per_m": "linear_density",
    "length_min_m": "length_min",
    "length_max_m": "length_max",
    "speed_max_m_per_s": "speed_max",
}
WINCH = {
    "drum_radius_m": RADIUS,
    "drum_growth_m": GROWTH,
    "reeving": REEVING,
    "gear_ratio": GEAR_RATIO,
    "efficiency": EFFICIENCY,
    "inertia_kg_m2": INERTIA,
}
MOTOR = {"torque_constant_N_m_per_A": TORQUE_CONSTANT, "resistance_ohm": RESISTANCE}
STEPPER = {"steps_per_turn": STEPS_PER_TURN, "microsteps": MICROSTEPS, "stall_torque_N_m": STALL_TORQUE}


def describe_robot(robot: Robot) -> dict[str, Any]:
    """Return the figures that do not depend on the pose."""
    platform, kind = robot.platform, restraint(robot)
    return {
        "name": robot.name,
        "dof": list(robot.dof),
        "motion_pattern": robot.pattern,
        "n": robot.n,
        "m": robot.m,
        "redundancy": robot.m - robot.n,
        "restraint": kind,
        "restraint_meaning": RESTRAINTS[kind],
        "few_cables": few_cables(robot),
        "unilateral": robot.unilateral,
        "sag": CHORD if bends(robot) else "",
        "friction": FRICTIONLESS if rubs(robot) else "",
        "characteristic_length_m": robot.characteristic_length,
        "platform": {
            "mass_kg": platform.mass,
            "center_of_mass_m": platform.center_of_mass.tolist(),
            "inertia_kg_m2": platform.inertia.tolist(),
            "shape_m": platform.outline,
            "tools_m": {name: point.tolist() for name, point in platform.tools.items()},
        },
        "cables": [
            {
                "name": cable.name,
                "frame_m": cable.frame.tolist(),
                "platform_m": cable.platform.tolist(),
                "tension_min_N": cable.tension_min,
                "tension_max_N": cable.tension_max,
                **{key: getattr(cable, name) for key, name in OPTIONAL.items()},
                "winch": winch_figures(cable),
            }
            for cable in robot.cables
        ],
    }


def winch_figures(cable: Cable) -> dict[str, Any] | None:
    """Return the figures of a cable's winch, None for unknown numbers; None without a winch.

    They are its type, drum, transmission and inertia, the electrical data of its motor if given, and for a
    stepper its steps and stall torque.

    Example:
        >>> import cdpr
        >>> winch_figures(cdpr.load_robot("caroca_winches").cables[0])["drum_radius_m"]
        0.05
    """
    if cable.winch is None:
        return None
    known = WINCH | STEPPER if STALL_TORQUE in WINCH_TYPES[cable.winch.type][0].numbers else WINCH
    if math.isfinite(TORQUE_CONSTANT.of(cable, math.nan)):
        known = known | MOTOR
    numbers = {key: number.of(cable, math.nan) for key, number in known.items()}
    return {
        "type": cable.winch.type,
        **{key: value if math.isfinite(value) else None for key, value in numbers.items()},
    }


def describe_pose(robot: Robot, pose: Array, gravity: Array, solve: Solve) -> dict[str, Any]:
    """Return restraint, conditioning, lengths and static tensions at a pose.

    Args:
        robot: the robot.
        pose: (7,), position (m) and quaternion.
        gravity: (3,), m/s^2, world.
        solve: bound method of a tension solver.

    Raises:
        CdprError: if a cable has zero length and hence no direction.
    """
    check_lengths(robot, pose)
    state = make_state(pose[:3], pose[3:])
    W = free_wrench_matrix(robot, state)
    rank, condition = conditioning(W)
    closed = positive_null_vector(W) is not None if robot.unilateral else True
    still = survey(robot, np.zeros(1), np.concatenate([state, np.zeros(6)])[None], gravity, solve)
    balanced = bool(still.feasible[0])
    return {
        "position_m": pose[:3].tolist(),
        "orientation_wxyz": pose[3:].tolist(),
        "gravity_m_per_s2": np.asarray(gravity).tolist(),
        "constraint": "suspended" if not closed else "fully constrained" if rank == robot.n else "singular",
        "rank": rank,
        "condition_number": condition,
        "unresisted_twists": [twist.tolist() for twist in unresisted(W, robot)],
        "length_m": still.length[0].tolist(),
        "static_wrench": still.wrench[0].tolist(),
        "static_tension_N": still.tension[0].tolist() if balanced else None,
        "static_margin_N": float(still.margin[0]) if balanced else None,
        "static_problem": None if balanced else _why_not(robot, W, still, solve),
        "static_residual_N": float(still.residual[0]),
        "least_winch_tension_N": _least(robot, pose, gravity),
    }


def _least(robot: Robot, pose: Array, gravity: Array) -> list[float] | None:
    """Return the least tensions of sagging cables at their winches; None if none sags."""
    if not bends(robot):
        return None
    found: list[float] = least_tensions(robot, pose[None, :3], pose[None, 3:], gravity)[0].tolist()
    return found


def _why_not(robot: Robot, W: Array, still: Survey, solve: Solve) -> str:
    """Return which tensions would balance the weight, if any; W is (n, m) as in `free_wrench_matrix`."""
    weights = np.repeat([1.0, 1.0 / robot.characteristic_length], 3)[robot.rows]
    wrench = weights * still.wrench[0][robot.rows]
    unit = newton(np.array([robot.tension_min, robot.tension_max]))
    allowed = RESIDUAL_TOLERANCE * max(unit, float(np.linalg.norm(wrench)))
    any_sign = np.linalg.lstsq(W, wrench, rcond=None)[0]
    if np.linalg.norm(W @ any_sign - wrench) > allowed:
        return "no tensions, not even pushing ones, balance the weight"
    tension = np.zeros(robot.m)
    status = solve(W, wrench, np.zeros(robot.m), np.full(robot.m, np.inf), tension)
    if status != 0:
        return "the weight could be balanced only by cables that push"
    return f"only tensions of {tension.min():.4g} to {tension.max():.4g} N balance the weight"


def describe_motion(robot: Robot, motion: Survey) -> dict[str, Any]:
    """Return the extent of a motion, its requirements on the cables, and the exceeded limits.

    The robot's degrees of freedom are those in which the cables must balance the wrench.
    """
    d, worst = motion.desired, int(np.argmin(np.where(motion.feasible, motion.margin, -np.inf)))
    return {
        "duration_s": float(motion.time[-1]),
        "samples": len(motion.time),
        "controlled": list(robot.dof),
        "path_length_m": float(np.linalg.norm(np.diff(d[:, :3], axis=0), axis=1).sum()),
        "speed_max_m_per_s": _peak(d[:, 7:10]),
        "acceleration_max_m_per_s2": _peak(d[:, 13:16]),
        "angular_speed_max_rad_per_s": _peak(d[:, 10:13]),
        "angular_acceleration_max_rad_per_s2": _peak(d[:, 16:19]),
        "feasible_share": float(motion.feasible.mean()),
        "first_infeasible_s": None if motion.feasible.all() else float(motion.time[np.argmin(motion.feasible)]),
        "smallest_margin_N": float(motion.margin[worst]) if motion.feasible.all() else None,
        "smallest_margin_at_s": float(motion.time[worst]) if motion.feasible.all() else None,
        "cables": [
            {
                "name": cable.name,
                "length_m": _ends(motion.length[:, i]),
                "rate_m_per_s": _ends(motion.rate[:, i]),
                "tension_N": _ends(motion.tension[:, i]),
            }
            for i, cable in enumerate(robot.cables)
        ],
        "exceeded": _exceeded(robot, motion),
    }


def _exceeded(robot: Robot, motion: Survey) -> list[str]:
    reach = Reach(plain_columns(robot.m), bounds_of(robot), robot.m)
    reach.add(np.column_stack([motion.time, motion.length, motion.rate]))
    return [one.text([cable.name for cable in robot.cables]) for one in reach.exceeded()]


def _peak(vectors: Array) -> float:
    return float(np.linalg.norm(vectors, axis=1).max())


def _ends(values: Array) -> list[float]:
    return [float(values.min()), float(values.max())]
