"""The signals by which cdpr speaks with an FMU, by role: a plant, a winch for all cables, or a controller.

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
    """One signal: `size` numbers, or one a cable where that is 0."""

    name: str
    size: int
    unit: str  # of all its numbers; "" where any may come; of the forces where it is a wrench
    need: Need = "optional"
    components: tuple[str, ...] = ()
    synonyms: tuple[str, ...] = ()  # other names for it, believed only where length and unit agree

    def units(self, count: int) -> Sequence[str]:
        """The SI unit of each number."""
        return ("N",) * 3 + ("N.m",) * 3 if self.components == FORCE_MOMENT else (self.unit,) * count


def _wrench(name: str, need: Need, *synonyms: str) -> Signal:
    return Signal(name, 6, "N", need, FORCE_MOMENT, synonyms)


def _platform(need: Need, prefix: str = "", *, synonyms: bool = False) -> tuple[Signal, ...]:
    """Pose and twist."""
    rows: tuple[tuple[str, str, tuple[str, ...], tuple[str, ...]], ...] = (
        ("position", "m", XYZ, ("p", "pos", "r", "x")),
        ("quaternion", "1", WXYZ, ("orientation", "quat", "q")),
        ("velocity", "m/s", XYZ, ("v", "vel")),
        ("angular_velocity", "rad/s", XYZ, ("omega", "w", "ang_vel")),
    )
    return tuple(
        Signal(prefix + name, len(parts), unit, need, parts, others if synonyms else (f"{name}_{prefix[:-1]}",))
        for name, unit, parts, others in rows
    )


LENGTHS = (
    Signal("cable_length", 0, "m", synonyms=("length", "lengths", "l")),
    Signal("cable_rate", 0, "m/s", synonyms=("rate", "rates", "cable_velocity", "ldot")),
)
TENSIONS = ("tension", "tensions", "cable_force", "cable_forces", "F_cable", "F", "T")

INPUTS: dict[Role, tuple[Signal, ...]] = {
    "plant": (
        Signal("cable_tension", 0, "N", "choice", synonyms=TENSIONS),
        Signal("command", 0, "N", "choice"),
        _wrench("external_wrench", "optional", "wrench_external", "disturbance"),
    ),
    "winch": (Signal("command", 0, "", "required"), *LENGTHS),
    "controller": (
        *_platform("optional", synonyms=True),
        *_platform("optional", "desired_"),
        Signal("desired_acceleration", 3, "m/s^2", components=XYZ, synonyms=("acceleration_desired",)),
        Signal(
            "desired_angular_acceleration", 3, "rad/s^2", components=XYZ, synonyms=("angular_acceleration_desired",)
        ),
        *LENGTHS,
    ),
}
OUTPUTS: dict[Role, tuple[Signal, ...]] = {
    "plant": (*_platform("required", synonyms=True), *LENGTHS),
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
