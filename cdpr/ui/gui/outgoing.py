"""Export of the form's robot and scenario as files for other programs."""

from __future__ import annotations

from base64 import b64encode
from typing import Any

from cdpr.base.errors import CdprError
from cdpr.base.nearest import did_you_mean
from cdpr.base.problems import shown
from cdpr.fmu.export.archive import zipped
from cdpr.formats.write import TARGETS
from cdpr.formats.write.export_model import CHOICES, Options, begin, export, left_out
from cdpr.formats.write.ros2 import packages
from cdpr.scenario import Scenario

PACKAGES = "ros2"  # a folder of packages, sent as an archive


def targets() -> list[dict[str, Any]]:
    """Return the export formats with their titles, options and allowed values."""
    rows = [
        {"to": to, "name": target.name, "options": {key: CHOICES[key] for key in target.options}}
        for to, target in TARGETS.items()
    ]
    return [*rows, {"to": PACKAGES, "name": "ROS 2 packages", "options": {}}]


def exported(scenario: Scenario, to: str, options: dict[str, str]) -> tuple[dict[str, Any], list[str]]:
    """Return the message with a file to download, as `cdpr export` writes it, and a list of omitted items.

    Raises:
        CdprError: if the format is unknown, does not support an option, or cannot represent the robot.
    """
    known = [*TARGETS, PACKAGES]
    if to not in known:
        raise CdprError(
            f"to: expected one of {', '.join(known)}, got {shown(to)}; {did_you_mean(str(to), known)}".rstrip("; ")
        )
    takes = TARGETS[to].options if to in TARGETS else ()
    if wrong := [name for name in options if name not in takes]:
        raise CdprError(f"{to}: {', '.join(wrong)}: not an option of this format")
    if to == PACKAGES:
        name = f"{scenario.name}_{PACKAGES}"
        files, omitted = packages(scenario)
        entries = tuple((f"{name}/{path}", data) for path, data in files.items())
        return _file(f"{name}.zip", "application/zip", zipped(entries)), omitted
    subject = begin(scenario)
    text = export(subject, to, Options(**options))
    return _file(f"{subject.robot.name}{TARGETS[to].ending}", "text/xml", text.encode()), left_out(subject, to)


def _file(name: str, kind: str, content: bytes) -> dict[str, Any]:
    return {"kind": "file", "name": name, "type": kind, "content": b64encode(content).decode()}
