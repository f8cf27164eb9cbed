"""Notes on quantities that omit the friction of pulleys, for output."""

from __future__ import annotations

from cdpr.cables import rubs
from cdpr.model import Robot

FRICTIONLESS = (
    "static tensions, stiffness, workspaces, sizing and equilibria are those without friction: the tensions at the "
    "winches are those at the platform"
)
SIZED = (
    "friction on pulleys: motor torques of runs include it; all other figures are those without friction, with the "
    "tensions at the platform"
)


def friction_note(robot: Robot) -> str:
    """Return a note on static figures of a robot whose pulleys have friction; "" without friction."""
    return f"friction on pulleys: {FRICTIONLESS}" if rubs(robot) else ""
