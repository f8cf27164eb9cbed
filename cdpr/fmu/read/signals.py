"""Signals between cdpr and an FMU, by role: a plant, a winch for all cables, or a controller.

Conventions are those of `cdpr.model`: SI, world axes at the platform's origin, quaternions w, x, y, z.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

Role = Literal["plant", "winch", "controller"]
ROLES: tuple[Role, ...] = get_args(Role)
# choice: exactly one of those of its side.
Need = Literal["required", "optional", "choice"]
XYZ = ("x", "y", "z")
WXYZ = ("w", "x", "y", "z")
FORCE_MOMENT = ("fx", "fy", "fz", "mx", "my", "mz")


@dataclass(frozen=True)
class Signal:
    """One signal: `size` numbers, or one per cable if that is 0."""

    name: str
    size: int
    unit: str  # of all its numbers; "" for any; of the forces of a wrench
    need: Need = "optional"
    components: tuple[str, ...] = ()
    synonyms: tuple[str, ...] = ()  # other names, accepted only if length and unit agree
    halves: tuple[str, ...] = ()  # a force and a moment that together form it: an array of FMI 3 has one unit

    def units(self, count: int) -> Sequence[str]:
        """Return the SI unit of each number."""
        return ("N",) * 3 + ("N.m",) * 3 if self.components == FORCE_MOMENT else (self.unit,) * count


def _wrench(name: str, need: Need, *synonyms: str, halves: tuple[str, ...] = ()) -> Signal:
    return Signal(name, 6, "N", need, FORCE_MOMENT, synonyms, halves)


def _state(need: Need) -> tuple[Signal, ...]:
    return (
        Signal("position", 3, "m", need, XYZ, ("p", "pos", "r", "x")),
        Signal("quaternion", 4, "1", need, WXYZ, ("orientation", "quat", "q")),
        Signal("velocity", 3, "m/s", need, XYZ, ("v", "vel")),
        Signal("angular_velocity", 3, "rad/s", need, XYZ, ("omega", "w", "ang_vel")),
    )


def _desired(name: str, size: int, unit: str, components: tuple[str, ...], *synonyms: str) -> Signal:
    return Signal(f"desired_{name}", size, unit, "optional", components, (f"{name}_desired", *synonyms))


DESIRED = (
    _desired("position", 3, "m", XYZ),
    _desired("quaternion", 4, "1", WXYZ, "desired_orientation", "orientation_desired"),
    _desired("velocity", 3, "m/s", XYZ),
    _desired("angular_velocity", 3, "rad/s", XYZ),
    _desired("acceleration", 3, "m/s^2", XYZ),
    _desired("angular_acceleration", 3, "rad/s^2", XYZ),
)
LENGTHS = (
    Signal("cable_length", 0, "m", synonyms=("length", "lengths", "l")),
    Signal("cable_rate", 0, "m/s", synonyms=("rate", "rates", "cable_velocity", "ldot")),
)
TENSIONS = ("tension", "tensions", "cable_force", "cable_forces", "F_cable", "F", "T")

# Outputs of plants with winches.
WINCHED = (
    Signal("cable_tension", 0, "N"),
    Signal("cable_work", 1, "J"),
    Signal("unstretched_length", 0, "m"),
    Signal("unstretched_rate", 0, "m/s"),
    Signal("motor_torque", 0, "N.m"),
    _wrench("bending_wrench", "optional", halves=("bending_force", "bending_moment")),
)
UNITS_OF_COMMANDS = {"tension": "N", "length": "m", "rate": "m/s"}  # of winches

EXTERNAL = ("external_force", "external_moment")

INPUTS: dict[Role, tuple[Signal, ...]] = {
    "plant": (
        Signal("cable_tension", 0, "N", "choice", synonyms=TENSIONS),
        Signal("command", 0, "N", "choice"),
        _wrench("external_wrench", "optional", "wrench_external", "disturbance", halves=EXTERNAL),
    ),
    "winch": (Signal("command", 0, "", "required"), *LENGTHS),
    "controller": (*_state("optional"), *DESIRED, *LENGTHS),
}
OUTPUTS: dict[Role, tuple[Signal, ...]] = {
    "plant": (*_state("required"), *LENGTHS),
    "winch": (
        Signal("cable_tension", 0, "N", "required", synonyms=TENSIONS),
        Signal("motor_angle", 0, "rad"),
        Signal("motor_speed", 0, "rad/s"),
    ),
    "controller": (
        _wrench("wrench", "choice", "w", "wrench_command"),
        Signal("command", 0, "N", "choice", synonyms=("cable_command", "cable_tension", *TENSIONS)),
    ),
}
