"""Defaults of scenarios, commands and functions, defined only here."""

from __future__ import annotations

BACKEND = "reference"
CONTROLLER = "computed_torque"
LENGTH_CONTROLLER = "inverse_kinematics"  # of new scenarios for winches that all take lengths or rates
LENGTH_OPTIONS = {"flex_compensation": True}  # so that the platform is at rest at the start
SOLVER = "qp"
ESTIMATOR = "none"  # the controller uses measurements, or the true state
SAFETY = 5.0  # ratio of a cable's breaking load to its largest tension
MOST_STARTS = 10_000  # of a search for equilibria, which then takes minutes
