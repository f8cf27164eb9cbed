"""Defaults of scenarios, commands and functions, defined only here."""

from __future__ import annotations

BACKEND = "reference"
CONTROLLER = "computed_torque"
SOLVER = "qp"
SAFETY = 5.0  # ratio of a cable's breaking load to its largest tension
