"""What is written for other programs: one row for each format, with the module whose `write` makes its text."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Target:
    """One format.

    Attributes:
        module: of `write(subject, options) -> str`.
        ending: of its files.
        options: of `Options` that it takes.
        guides: whether it says what holds a platform that is not free in all directions.
    """

    module: str
    ending: str
    options: tuple[str, ...] = ()
    guides: bool = True


TARGETS = {
    "mjcf": Target("cdpr.formats.write.mjcf", ".xml"),
    "sdf": Target("cdpr.formats.write.sdf", ".sdf", ("style", "version")),
    "urdf": Target("cdpr.formats.write.urdf", ".urdf", guides=False),
}
