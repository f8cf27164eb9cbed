"""The figures of a case: those of a run's summary that any machine computes alike, each a column of the table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

# What has a column of its own, what the axes say, what is no number, and what depends on the machine.
BESIDES = ("status", "believed", "clearance_min_by", "slack_intervals", "passed", "real_time_factor")

# All that there may be, so that no axis takes the name of one.
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
    "cable_tension_min_N",  # where they are not ideal
    "cable_tension_max_N",
    "slack_samples",
    "residual_max_N",
    "margin_min_N",
    "clearance_min_m",  # where all cables have diameters
    "clearance_min_at_s",
    "beyond_limits_shorter_steps",  # where the robot has such limits
    "beyond_limits_longer_steps",
    "beyond_limits_faster_steps",
    "beyond_limits_below_min_steps",  # where the controller believes the robot to be another
    "beyond_limits_above_max_steps",
    "beyond_limits_tension_below_min_steps",  # where the cables are not ideal
    "beyond_limits_tension_above_max_steps",
    "through_anchor_s",  # where a cable passes its anchor, or its swivel axis
    "through_axis_s",
    "energy_kinetic_max_J",
    "energy_cable_work_J",
    "energy_external_work_J",
    "energy_turned_over_J",
    "energy_residual_max_J",
    "energy_balanced",
)


def figures(summary: Mapping[str, Any]) -> dict[str, bool | int | float | None]:
    """Flatten a run's summary: {"tension_N": {"max": 1.0}} becomes {"tension_max_N": 1.0}; a yes or no has no unit."""
    out: dict[str, bool | int | float | None] = {}
    for key, value in summary.items():
        if isinstance(value, Mapping):
            name, _, unit = key.rpartition("_")
            for part, number in value.items():
                out[f"{name}_{part}" if isinstance(number, bool) else f"{name}_{part}_{unit}"] = number
        elif key not in BESIDES:
            out[key] = value
    return out
