"""Supported import formats, with the module that recognises and reads each."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Format:
    """Import format.

    Attributes:
        name: title for users.
        module: module with `recognise(content) -> bool`, which is fast and never raises, and
            `read(path, content, choice) -> Imported`. It is imported on demand. If the format needs a library, the
            module has `load_library()`, which imports it before the reading process is forked.
        endings: file name endings that are considered in a folder.
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
    Format("RepRapFirmware", "cdpr.formats.read.reprap", (".g",)),
    Format("Klipper", "cdpr.formats.read.klipper", (".cfg",)),
    Format("CDPyR", "cdpr.formats.read.cdpyr", (".json", ".yaml", ".yml", ".xml")),
    Format("list of anchors", "cdpr.formats.read.anchor_lists", (".json", ".yaml", ".yml", ".csv")),
)
