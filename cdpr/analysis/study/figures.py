"""Figures of a case: the machine-independent figures of a run's summary, one column of the table each."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

UNIT = re.compile(r"_(m_s|rad_s|[A-Za-z]+)$")  # at the end of a key

# keys with a column of their own, given by an axis, not numeric, or machine-dependent
BESIDES = (
    "status",
    "believed",
    "clearance_min_by",
    "slack_intervals",
    "lost_steps_intervals",
    "passed",
    "real_time_factor",
)

# All possible figures; reserved, so that no axis has the same name.
FIGURES = (
    "samples",
    "simulated_s",
    "infeasible_steps",
    "unanswered_steps",
    "position_error_max_m",
    "position_error_rms_m",
    "position_error_final_m",
    "orientation_error_max_rad",
    "orientation_error_rms_rad",
    "orientation_error_final_rad",
    "tension_min_N",
    "tension_max_N",
    "tension_largest_step_N",
    "cable_tension_min_N",  # if the cables are not ideal
    "cable_tension_max_N",
    "slack_samples",
    "lost_steps",  # if the robot has stepper motors
    "motor_current_max_A",  # if motors have electrical data
    "motor_current_rms_A",
    "motor_voltage_max_V",
    "electrical_energy_used_J",
    "electrical_energy_regenerated_J",
    "estimate_position_error_max_m",  # if the scenario has an estimator
    "estimate_position_error_rms_m",
    "estimate_orientation_error_max_rad",
    "estimate_orientation_error_rms_rad",
    "estimate_velocity_error_max_m_s",
    "estimate_velocity_error_rms_m_s",
    "estimate_angular_velocity_error_max_rad_s",
    "estimate_angular_velocity_error_rms_rad_s",
    "estimate_nis_mean_per_value",  # if it predicts measurements
    "estimate_nis_inside_95_percent",
    "estimate_nis_last",
    "estimate_nis_last_values",
    "estimate_nees_mean_per_value",  # if it has a covariance
    "estimate_nees_inside_95_percent",
    "estimate_nees_last",
    "estimate_nees_last_values",
    "residual_max_N",
    "margin_min_N",
    "clearance_min_m",  # if all cables have diameters
    "clearance_min_at_s",
    "beyond_limits_shorter_steps",  # if the robot has such limits
    "beyond_limits_longer_steps",
    "beyond_limits_faster_steps",
    "beyond_limits_below_min_steps",  # if the controller uses a different nominal model
    "beyond_limits_above_max_steps",
    "beyond_limits_tension_below_min_steps",  # if the cables are not ideal
    "beyond_limits_tension_above_max_steps",
    "through_anchor_s",  # if a cable passes its anchor or its swivel axis
    "through_axis_s",
    "energy_kinetic_max_J",
    "energy_cable_work_J",
    "energy_external_work_J",
    "energy_load_energy_J",  # if an event changes the mass of the platform
    "energy_turned_over_J",
    "energy_residual_max_J",
    "energy_balanced",  # empty if the work of a source is unknown
)


def figures(summary: Mapping[str, Any]) -> dict[str, bool | int | float | None]:
    """Flatten a run's summary: {"tension_N": {"max": 1.0}} becomes {"tension_max_N": 1.0}.

    Names of booleans and None have no unit. Lists are omitted.
    """
    out: dict[str, bool | int | float | None] = {}
    for key, value in summary.items():
        if isinstance(value, Mapping):
            out |= _flat(key, value)
        elif key not in BESIDES:
            out[key] = value
    return out


def _flat(key: str, values: Mapping[str, Any]) -> dict[str, bool | int | float | None]:
    """Return the figures of one mapping, with the unit of its key at the end of their names."""
    out: dict[str, bool | int | float | None] = {}
    found = UNIT.search(key)
    stem, unit = (key, "") if found is None else (key[: found.start()], found[0])
    for part, number in values.items():
        if isinstance(number, Mapping):
            out |= {f"{key}_{name}": each for name, each in _flat(part, number).items()}
        elif not isinstance(number, list):
            has_unit = isinstance(number, int | float) and not isinstance(number, bool)
            out[f"{stem}_{part}{unit if has_unit else ''}"] = number
    return out
