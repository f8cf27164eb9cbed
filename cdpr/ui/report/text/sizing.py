"""Sizing of cables, drums and motors as lines and tables."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from cdpr.ui.report.text.aligned import digits, table

# Columns of the tables: heading and key.
CABLES = (
    ("peak (N)", "tension_peak_N"),
    ("rms (N)", "tension_rms_N"),
    ("min (N)", "tension_least_N"),
    ("breaking load (N)", "breaking_load_N"),
    ("shortest (m)", "length_shortest_m"),
    ("longest (m)", "length_longest_m"),
    ("speed (m/s)", "speed_m_per_s"),
    ("acceleration (m/s^2)", "acceleration_m_per_s2"),
)
POWERS = (
    ("driving (W)", "power_driving_W"),
    ("braking (W)", "power_braking_W"),
    ("energy out (J)", "energy_given_J"),
    ("energy in (J)", "energy_taken_J"),
    ("drum turns", "drum_turns"),
    ("drum (rad/s)", "drum_speed_rad_per_s"),
    ("drum (N m)", "drum_torque_peak_N_m"),
    ("drum rms (N m)", "drum_torque_rms_N_m"),
    ("motor (rad/s)", "motor_speed_rad_per_s"),
    ("motor (N m)", "motor_torque_peak_N_m"),
    ("motor rms (N m)", "motor_torque_rms_N_m"),
    ("motor (W)", "motor_power_W"),
)
ELECTRICAL = (
    ("motor current (A)", "motor_current_peak_A"),
    ("motor current rms (A)", "motor_current_rms_A"),
    ("motor voltage (V)", "motor_voltage_V"),
    ("electrical power (W)", "electrical_power_W"),
    ("electrical feedback (W)", "electrical_feedback_W"),
    ("electrical energy used (J)", "electrical_energy_used_J"),
    ("electrical energy regenerated (J)", "electrical_energy_regenerated_J"),
)
TABLES = {"cables": ("Cables", CABLES), "drums": ("Power and drums", POWERS), "motors": ("Motors", ELECTRICAL)}


def cells(figures: Mapping[str, Any], columns: tuple[tuple[str, str], ...]) -> list[tuple[str, ...]]:
    """Return the heading and rows of a table of cables, without empty columns."""
    known = [(title, key) for title, key in columns if any(each[key] is not None for each in figures["cables"])]
    rows = [("cable", *(title for title, _ in known))]
    for each in figures["cables"]:
        rows.append((each["name"], *("" if each[key] is None else digits(each[key]) for _, key in known)))
    return rows


def duties(figures: Mapping[str, Any]) -> list[str]:
    """Return lines on each duty: infeasible samples, largest tension and exceeded limits."""
    found = []
    for each in figures["duties"]:
        lost = f", {each['infeasible']} of them without admissible tensions" if each["infeasible"] else ""
        most = "" if each["largest_tension_N"] is None else f"; largest tension {digits(each['largest_tension_N'])} N"
        found.append(f"{each['name']}: {each['samples']} samples{lost}{most}")
        found += [f"  exceeded: {text}" for text in each["exceeded"]]
    return found


def lines(figures: Mapping[str, Any]) -> list[str]:
    """Return the result of `Sizing.plain` as lines for a terminal."""
    text = [f"{figures['robot']}: requirements on its cables, breaking load {figures['safety']:g} times the peak", ""]
    for _, columns in TABLES.values():
        rows = cells(figures, columns)
        if len(rows[0]) > 1:
            text += [*table(rows, ruled=True), ""]
    return text + duties(figures) + [figures[key] for key in ("sag", "friction") if key in figures]
