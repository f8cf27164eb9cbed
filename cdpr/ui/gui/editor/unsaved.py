"""Files that do not exist yet: new ones, and the generated scenario around a robot."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from cdpr.base import defaults
from cdpr.base.errors import CdprError
from cdpr.plugins.registry import Registry
from cdpr.scenario import load_robot
from cdpr.scenario.schema import ScenarioSection
from cdpr.scenario.source import stem
from cdpr.scenario.template import Sizes, commented, controller_data, robot_text
from cdpr.simulation.trial_runs import WARNING, scenario_with_trials
from cdpr.ui.gui.editor.files import File, named

KINDS = ("robot", "scenario")
DURATION = 10.0  # s: time to view a robot and to push it
HEAD = "The robot stays at its home. Written by cdpr gui; lengths in m, times in s, angles in rad."
NO_FILE = "this scenario was created to show the robot and has no file: save it"


def new_file(kind: str, arguments: Mapping[str, Any], plugins: Registry) -> tuple[File, str]:
    """Return a new file, and a note on its trial run or "".

    Args:
        kind: "robot" or "scenario".
        arguments: `file`, the name of the new file (default robot.yaml or scenario.yaml), and the arguments of `cdpr
            new`: frame and platform (three lengths, m), mass (kg), cables, crossed, planar, suspended, and for a
            scenario `robot`, the file of its robot.
        plugins: available plugins.

    Raises:
        CdprError: if an argument is unknown or invalid.
    """
    if kind not in KINDS:
        raise CdprError(f"expected robot or scenario, got {kind!r:.40}")
    given = {key: value for key, value in arguments.items() if value is not None}
    name, source = named(given.pop("file", f"{kind}.yaml")), given.pop("robot", None)
    known = tuple(Sizes.__dataclass_fields__)
    if wrong := [key for key in given if key not in known]:
        raise CdprError(f"{', '.join(wrong)}: unknown; allowed for a new {kind}: {', '.join(known)}")
    if source is not None and kind == "robot":
        raise CdprError("robot: only a new scenario names one")
    if source is not None and given:
        raise CdprError(f"{', '.join(given)}: sizes are those of the robot file; leave them out, or robot")
    sizes = _sizes(given)
    if kind == "robot":
        text, note = robot_text(name, sizes, stem(name)), ""
    else:
        trial = scenario_with_trials(name, source and named(source), sizes)
        text, note = trial.text, trial.note.removeprefix(WARNING)
    return File(name, text, first=text), note


def _sizes(given: Mapping[str, Any]) -> Sizes:
    try:
        parts = {key: tuple(map(float, given[key])) for key in ("frame", "platform") if key in given}
        if any(len(part) != 3 for part in parts.values()):
            raise ValueError
        mass = {"mass": float(given["mass"])} if "mass" in given else {}
        count = {"cables": int(given["cables"])} if "cables" in given else {}
    except (TypeError, ValueError, OverflowError):
        text = "frame and platform: expected three lengths (m) each; mass: a number (kg); cables: a whole number"
        raise CdprError(text) from None
    flags = {key: bool(given[key]) for key in ("crossed", "planar", "suspended") if key in given}
    values: dict[str, Any] = {**parts, **mass, **count, **flags}
    return Sizes(**values)


def around(robot: File, plugins: Registry) -> File:
    """Return a scenario, not on disk, with a robot at its home."""
    folder, base = os.path.dirname(robot.name), stem(robot.name)
    count, name = 1, os.path.join(folder, f"{base}_scenario.yaml")
    while os.path.lexists(name):
        count += 1
        name = os.path.join(folder, f"{base}_scenario_{count}.yaml")
    data: dict[str, Any] = {"robot": os.path.basename(robot.name)}
    data["simulation"] = {"backend": defaults.BACKEND, "duration": DURATION, "control_step": 0.001}
    loaded = None
    with suppress(CdprError):  # the form reports it
        loaded = load_robot(robot.name, text=robot.text)
    if loaded is not None and loaded.home is None:
        from cdpr.mechanics.properties import home_pose  # expensive import

        data["initial"] = {"position": [float(part) for part in home_pose(loaded)[0][:3]]}
    data["controller"] = controller_data(loaded, plugins)
    data["solver"] = {"type": defaults.SOLVER}
    text = commented(ScenarioSection, data, plugins, HEAD)
    return File(name, text, first=text, fixed=NO_FILE)
