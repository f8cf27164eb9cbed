"""What is written for other programs: one row for each format, with the module whose `write` makes its text."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Target:
    """One format.

    Attributes:
        name: what people call it, and what reads it.
        module: of `write(subject, options) -> str`.
        ending: of its files.
        options: of `Options` that it takes.
        guides: whether it says what holds a platform that is not free in all directions.
    """

    name: str
    module: str
    ending: str
    options: tuple[str, ...] = ()
    guides: bool = True


TARGETS = {
    "mjcf": Target("MJCF, for MuJoCo", "cdpr.formats.write.mjcf", ".xml", ("pulleys",)),
    "sdf": Target("SDF, for Gazebo", "cdpr.formats.write.sdf", ".sdf", ("style", "version", "pulleys")),
    "urdf": Target("URDF, for RViz and TF", "cdpr.formats.write.urdf", ".urdf", guides=False),
}
