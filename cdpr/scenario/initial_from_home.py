"""Initial pose of a run from the robot's home."""

from __future__ import annotations

import json

from pydantic import ValidationError

from cdpr.base.problems import Mark, Path
from cdpr.config.document import Document
from cdpr.config.problems import Problems
from cdpr.scenario.appearance import FrameSection
from cdpr.scenario.robot_schema import Home

INITIAL: Path = ("initial",)
HOME: Path = ("robot", "home")
BASE: Path = ("robot", "frame")


def begin_at_home(document: Document, problems: Problems) -> None:
    """Write the home pose into `initial` if it has no position; with a position, a missing orientation is upright.

    The value has the position of the home in the file. It is removed before the next change: see `Document.filled`.
    """
    given = document.data.get("initial", {})
    if not isinstance(given, dict) or "position" in given:
        return  # null values are reported elsewhere
    home, base = document.get(HOME), document.get(BASE)
    lacking = (*INITIAL, "position") if "initial" in document.data else INITIAL
    if home is None:
        if ("robot",) in problems.unreadable or "home" in (document.get(HOME[:1]) or {}):  # null is reported elsewhere
            problems.unreadable.add(lacking)
        return
    try:
        pose = Home.model_validate_json(json.dumps(home))
        frame = FrameSection.model_validate_json(json.dumps(base or {}))
    except ValidationError:  # reported elsewhere
        problems.unreadable.add(lacking)
        return
    values: dict[str, object] = {"position": frame.placed(pose.position).tolist()}
    if "orientation" not in given and (frame.moved or "orientation" in home):
        values["orientation"] = {"quaternion": frame.turned(pose.orientation.quaternion()).tolist()}
    if not frame.moved:  # as written in the file
        values = {key: home[key] for key in values}
    mark = document.mark((*HOME, "position"))
    if "initial" not in document.data:
        _fill(document, INITIAL, {}, mark)
    for key, value in values.items():
        _fill(document, (*INITIAL, key), value, mark)


def forget(document: Document) -> None:
    """Remove the values that were filled in."""
    while document.filled:
        document.drop(document.filled[-1])


def _fill(document: Document, path: Path, value: object, mark: Mark) -> None:
    document.put(path, value, mark)
    document.filled.append(path)
