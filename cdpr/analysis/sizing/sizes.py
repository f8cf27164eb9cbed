"""Sizes of cables, drums and motors: the worst of several duties, and the exceeded limits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from cdpr.analysis.sizing.demands import LEAST, Demands, demands, drum_turns
from cdpr.analysis.sizing.duty import Duty
from cdpr.base.defaults import SAFETY
from cdpr.base.errors import CdprError
from cdpr.base.problems import shown
from cdpr.cables import bends, rubs
from cdpr.cables.chain import Number
from cdpr.cables.motor import RATED_CURRENT, SUPPLY
from cdpr.mechanics.exit_friction import SIZED as FRICTION
from cdpr.mechanics.reach import Reach, bounds_of, plain_columns
from cdpr.mechanics.sag import SIZED
from cdpr.model import Robot
from cdpr.model.robot import Array

# Relative tolerance of tension limits, as in solvers: logged tensions are decimal.
REACHED = 1e-9


@dataclass(frozen=True, eq=False)
class Sizing:
    """Requirements of several duties on the cables of a robot.

    Attributes:
        robot: name.
        cables: names, (m,).
        safety: factor on the largest tension.
        parts: name, figures, number of samples, number of infeasible samples, and exceeded limits of each duty.
        worst: worst figures of all duties.
        source: (m,), name of the duty with the largest tension.
        sag: True if a cable sags.
        friction: True if a pulley has friction.
    """

    robot: str
    cables: tuple[str, ...]
    safety: float
    parts: tuple[tuple[str, Demands, int, int, tuple[str, ...]], ...]
    worst: Demands
    source: tuple[str, ...]
    sag: bool = False
    friction: bool = False

    def to_dict(self) -> dict[str, Any]:
        """Return the sizing as plain data with units in the names; None for missing figures."""
        return {
            "robot": self.robot,
            "safety": self.safety,
            "cables": [
                {"name": name, "breaking_load_N": _number(self.safety * self.worst.tension[i]), "by": self.source[i]}
                | {key: _number(getattr(self.worst, part)[i]) for part, key in NAMES.items()}
                for i, name in enumerate(self.cables)
            ],
            "duties": [
                {
                    "name": name,
                    "samples": samples,
                    "infeasible": lost,
                    "exceeded": list(exceeded),
                    "largest_tension_N": _number(np.fmax.reduce(found.tension)),
                }
                for name, found, samples, lost, exceeded in self.parts
            ],
            **({"sag": SIZED} if self.sag else {}),
            **({"friction": FRICTION} if self.friction else {}),
        }


NAMES = {
    "tension": "tension_peak_N",
    "tension_rms": "tension_rms_N",
    "tension_least": "tension_least_N",
    "speed": "speed_m_per_s",
    "acceleration": "acceleration_m_per_s2",
    "driving": "power_driving_W",
    "braking": "power_braking_W",
    "given": "energy_given_J",
    "taken": "energy_taken_J",
    "shortest": "length_shortest_m",
    "longest": "length_longest_m",
    "turns": "drum_turns",
    "drum_speed": "drum_speed_rad_per_s",
    "torque": "drum_torque_peak_N_m",
    "torque_rms": "drum_torque_rms_N_m",
    "motor_speed": "motor_speed_rad_per_s",
    "motor_torque": "motor_torque_peak_N_m",
    "motor_torque_rms": "motor_torque_rms_N_m",
    "motor_power": "motor_power_W",
    "current": "motor_current_peak_A",
    "current_rms": "motor_current_rms_A",
    "voltage": "motor_voltage_V",
    "electrical_power": "electrical_power_W",
    "feedback_power": "electrical_feedback_W",
    "used": "electrical_energy_used_J",
    "regenerated": "electrical_energy_regenerated_J",
}


def sizing(duties: Sequence[Duty], safety: float = SAFETY) -> Sizing:
    """Return the sizing for several duties.

    Raises:
        CdprError: if there is no duty, the robots have different cables, or `safety` is below 1.
    """
    if not duties:
        raise CdprError("expected at least one scenario or run")
    if not isinstance(safety, int | float) or not 1.0 <= safety < math.inf:
        raise CdprError(f"safety: expected a number from 1 on, got {shown(safety)}")
    first = duties[0].robot
    names = tuple(cable.name for cable in first.cables)
    for duty in duties[1:]:
        if duty.robot.name != first.name or tuple(cable.name for cable in duty.robot.cables) != names:
            raise CdprError(
                f"{duty.name}: is of the robot {duty.robot.name} and {duties[0].name} of {first.name}, or has other "
                "cables: size them separately"
            )
    found = [demands(duty) for duty in duties]
    worst = {}
    for part in fields(Demands):
        values = np.array([getattr(each, part.name) for each in found])
        pick = np.fmin if part.name in LEAST else np.fmax
        worst[part.name] = pick.reduce(values, axis=0)
    worst["turns"] = drum_turns(first, worst["shortest"], worst["longest"])  # over all
    peaks = np.array([np.nan_to_num(each.tension, nan=-np.inf) for each in found])
    source = tuple(duties[k].name if math.isfinite(peaks[k, i]) else "" for i, k in enumerate(peaks.argmax(axis=0)))
    parts = tuple(
        (duty.name, figures, len(duty.feasible), int((~duty.feasible).sum()), _exceeded(duty, figures))
        for duty, figures in zip(duties, found, strict=True)
    )
    sag = any(bends(duty.robot) for duty in duties)
    friction = any(rubs(duty.robot) for duty in duties)
    return Sizing(first.name, names, float(safety), parts, Demands(**worst), source, sag, friction)


def _exceeded(duty: Duty, found: Demands) -> tuple[str, ...]:
    """Return descriptions of the exceeded limits of the robot's cables."""
    robot, names = duty.robot, [cable.name for cable in duty.robot.cables]
    texts = []
    supply, rated = (_limits(robot, number) for number in (SUPPLY, RATED_CURRENT))
    for limit, values, sign, scale, words in (
        (robot.tension_max, found.tension, 1.0, robot.tension_max, "pull more than their highest tension"),
        (robot.tension_min, found.tension_least, -1.0, robot.tension_max, "pull less than their lowest tension"),
        (supply, found.voltage, 1.0, supply, f"have motors that need more than their {SUPPLY.key}"),
        (rated, found.current_rms, 1.0, rated, f"have motors whose rms current exceeds their {RATED_CURRENT.key}"),
    ):
        with np.errstate(invalid="ignore"):
            over = sign * (values - limit) > REACHED * np.abs(scale)
        if over.any():
            texts.append(f"cables {', '.join(name for name, out in zip(names, over, strict=True) if out)} {words}")
    if duty.time is not None and duty.rate is not None:
        texts += _left(robot, names, np.column_stack([duty.time, duty.length, duty.rate]))
    return tuple(texts)


def _limits(robot: Robot, number: Number) -> Array:
    """Return a number of the motors of all cables, (m,); NaN if it is not known."""
    return np.array([math.nan if cable.winch is None else number.of(cable, math.nan) for cable in robot.cables])


def _left(robot: Robot, names: Sequence[str], rows: Any) -> list[str]:
    reach = Reach(plain_columns(robot.m), bounds_of(robot), robot.m)
    reach.add(rows)
    return [one.text(list(names)) for one in reach.exceeded()]


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
