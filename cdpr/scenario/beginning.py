"""Where a run begins that does not say it: at the robot's home."""

from __future__ import annotations

import json

from pydantic import ValidationError

from cdpr.problems import Mark, Path
from cdpr.scenario.document import Document
from cdpr.scenario.looks import FrameSection
from cdpr.scenario.problems import Problems
from cdpr.scenario.robot_schema import Home

INITIAL: Path = ("initial",)
HOME: Path = ("robot", "home")
BASE: Path = ("robot", "frame")


def begin_at_home(document: Document, problems: Problems) -> None:
    """Write the home pose where `initial` says no position; where it says one, what it leaves out is upright.

    It is written with the place of the home, and taken back before the next change: see `Document.filled`.
    """
    given = document.data.get("initial", {})
    if not isinstance(given, dict) or "position" in given:
        return  # null is told as any
    home, base = document.get(HOME), document.get(BASE)
    lacking = (*INITIAL, "position") if "initial" in document.data else INITIAL
    if home is None:
        if ("robot",) in problems.unreadable or "home" in (document.get(HOME[:1]) or {}):  # null is told
            problems.unreadable.add(lacking)
        return
    try:
        pose = Home.model_validate_json(json.dumps(home))
        frame = FrameSection.model_validate_json(json.dumps(base or {}))
    except ValidationError:  # is told
        problems.unreadable.add(lacking)
        return
    values: dict[str, object] = {"position": frame.placed(pose.position).tolist()}
    if "orientation" not in given and (frame.moved or "orientation" in home):
        values["orientation"] = {"quaternion": frame.turned(pose.orientation.quaternion()).tolist()}
    if not frame.moved:  # as it was written
        values = {key: home[key] for key in values}
    mark = document.mark((*HOME, "position"))
    if "initial" not in document.data:
        _fill(document, INITIAL, {}, mark)
    for key, value in values.items():
        _fill(document, (*INITIAL, key), value, mark)


def forget(document: Document) -> None:
    """Take back what was filled in."""
    for path in reversed(document.filled):
        document.drop(path)
    document.filled.clear()


def _fill(document: Document, path: Path, value: object, mark: Mark) -> None:
    document.put(path, value, mark)
    document.filled.append(path)
