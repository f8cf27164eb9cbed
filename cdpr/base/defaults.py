"""Default plugins of scenarios, commands and functions, defined only here."""

from __future__ import annotations

BACKEND = "reference"
CONTROLLER = "computed_torque"
SOLVER = "qp"
