"""What a scenario, a command or a call takes that names no plugin; here and nowhere else."""

from __future__ import annotations

BACKEND = "reference"
CONTROLLER = "computed_torque"
SOLVER = "qp"
