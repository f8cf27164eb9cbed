"""Supported export formats, with the module whose `write` returns the text of each."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Target:
    """Export format.

    Attributes:
        name: title for users, with the program that reads it.
        module: module with `write(subject, options) -> str`.
        ending: file name ending.
        options: supported fields of `Options`.
        guides: True if the format represents guides of platforms with fewer than six degrees of freedom.
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
