"""What is read of other programs: one row for each format, with what recognises it by content, and what reads it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Format:
    """One format.

    Attributes:
        name: what people call it.
        module: of `recognise(content) -> bool`, cheap and never an error, and of
            `read(path, content, chosen) -> Imported`; imported when a file is looked at. A format that
            needs a library has `load_library()`, which imports it before the process that reads is forked.
        endings: of the files of a folder that are looked at.
    """

    name: str
    module: str
    endings: tuple[str, ...]


FORMATS = (
    Format("CASPR", "cdpr.formats.read.caspr", (".xml",)),
    Format("Gazebo plug-in YAML", "cdpr.formats.read.gazebo", (".yaml", ".yml")),
    Format("MJCF", "cdpr.formats.read.mjcf", (".xml", ".mjcf")),
    Format("WireX", "cdpr.formats.read.wirex", (".wcrfx",)),
    Format("SDF", "cdpr.formats.read.sdf", (".sdf", ".world")),
)
