"""From the desk to the disk and back."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, get_args

from pydantic import BaseModel

from cdpr.errors import CdprError, OutputError, PluginError
from cdpr.gui.desk import edit
from cdpr.gui.desk.fields import at
from cdpr.gui.desk.files import File, Files, named, on_disk, write
from cdpr.plugins import FileName
from cdpr.plugins.registry import Registry, Role
from cdpr.problems import Path
from cdpr.scenario.actuator_schema import Actuators
from cdpr.scenario.events import EVENTS
from cdpr.scenario.files import seen_from
from cdpr.scenario.motions import AnyMotion, Motion
from cdpr.scenario.overrides import DEFAULT_TYPE

ENDINGS = (".yaml", ".yml")
MESH: Path = ("platform", "shape", "mesh")
MOTIONS: tuple[type[Motion], ...] = get_args(get_args(AnyMotion)[0])


def reread(files: Files, shown: Sequence[File]) -> dict[str, str]:
    """Return what is on the disk of all files; CdprError where one that is shown cannot be read."""
    texts = {}
    for key, file in files.files.items():
        text = file.first
        try:
            if file.saved is not None:
                text = on_disk(file.name)
            edit.read(text)
        except CdprError as error:
            if file in shown:
                raise CdprError(f"revert: {file.name}: {error}") from None
            continue  # nobody asks for it any more
        texts[key] = text
    for key, text in texts.items():
        if files.files[key].saved is not None:
            files.files[key].saved = text
    return files.texts() | texts


def save(files: Iterable[File]) -> list[str]:
    """Write these files and return their names. Raises OutputError; those before are then written."""
    names = []
    for file in files:
        write(file.name, file.text, new=file.saved is None)
        file.saved = file.text
        names.append(file.name)
    return names


def save_as(files: Files, robot: File | None, target: str, plugins: Registry) -> tuple[Files, list[str]]:
    """Write a scenario and what was changed of its robot elsewhere; return the new files and their names.

    A robot that was made to be looked at alone is written alone, unless the scenario around it was changed.
    """
    old = files.scenario
    alone = robot is not None and old.saved is None and bool(old.fixed) and not old.modified
    first = robot if alone and robot else old
    name = _target(target, first)
    folder = os.path.dirname(name)
    _make(folder)
    if alone and robot:
        text = _moved(robot.text, [MESH], os.path.dirname(robot.name), folder)
        write(name, text, new=True)
        beside = os.path.join(folder, os.path.basename(old.name))
        around = edit.set_value(old.text, ("robot",), os.path.basename(name))
        made = {os.path.abspath(beside): File(beside, around, first=around, fixed=old.fixed)}
        return Files(os.path.abspath(beside), {**made, os.path.abspath(name): File.open(name)}), [name]
    text = _moved(old.text, file_paths(edit.read(old.text), plugins), os.path.dirname(old.name), folder)
    names = [name]
    if robot is not None:
        keep = not robot.modified and not robot.fixed
        place, written = (robot.name, robot.text) if keep else _place_of(robot, old, folder)
        text = edit.set_value(text, ("robot",), seen_from(folder or ".", place))
        if not keep and not os.path.lexists(place):
            _make(os.path.dirname(place))
            write(place, written, new=True)
            names.append(place)
    try:
        write(name, text, new=True)
    except OutputError:
        for place in names[1:]:  # what is not saved leaves nothing
            os.unlink(place)
        raise
    return Files(os.path.abspath(name), {os.path.abspath(name): File.open(name)}), names


def _make(folder: str) -> None:
    try:
        os.makedirs(folder or ".", exist_ok=True)
    except OSError as error:
        raise OutputError(f"cannot make the folder '{folder}': {error.strerror or error}") from None


def _target(target: str, first: File) -> str:
    """Return the file that is meant by a file or folder; OutputError where it is there."""
    target = named(target)
    if os.path.isdir(target) or target.endswith(os.sep):
        target = os.path.join(target, os.path.basename(first.name))
    elif not target.endswith(ENDINGS):
        target += ENDINGS[0]
    if os.path.lexists(target):
        raise OutputError(f"'{target}' is there already: it is not written over; choose another name")
    return target


def _place_of(robot: File, scenario: File, folder: str) -> tuple[str, str]:
    """Return where a robot goes, as it lay to its scenario, under a name that is free or holds the same; its text."""
    beside = os.path.relpath(robot.name, os.path.dirname(scenario.name) or ".")
    if beside.startswith(os.pardir):
        beside = os.path.basename(robot.name)
    base, ending = os.path.splitext(os.path.join(folder, beside))
    count, place = 1, f"{base}{ending}"
    while True:
        text = _moved(robot.text, [MESH], os.path.dirname(robot.name), os.path.dirname(place))
        if not os.path.lexists(place) or (os.path.isfile(place) and _holds(place, text)):
            return place, text
        count += 1
        place = f"{base}_{count}{ending}"


def _holds(name: str, text: str) -> bool:
    try:
        return on_disk(name) == text
    except CdprError:
        return False


def _moved(text: str, paths: Iterable[Path], old: str, new: str) -> str:
    """Return a text that names the same files from another folder."""
    if os.path.realpath(old or ".") == os.path.realpath(new or "."):
        return text
    data = edit.read(text)
    for path in paths:
        name = at(data, path)
        if isinstance(name, str) and name and not os.path.isabs(name):
            text = edit.set_value(text, path, seen_from(new or ".", os.path.join(old, name)))
    return text


def file_paths(data: dict[str, Any], plugins: Registry) -> Iterator[Path]:
    """Yield where a scenario may name files besides its robot's: motions, events, meshes, options of plugins."""
    for motion in MOTIONS:
        if at(data, ("trajectory", "type")) == motion.kind():
            yield from (("trajectory", key) for key in motion.files)
    events = data.get("events")
    for i, event in enumerate(events if isinstance(events, list) else []):
        kinds = [kind for kind in EVENTS if isinstance(event, dict) and event.get("type") == kind.kind()]
        yield from (("events", i, key) for kind in kinds for key in kind.files)
    yield from ((holder, *MESH) for holder in ("robot", "believed"))
    obstacles = at(data, ("world", "obstacles"))
    yield from (("world", "obstacles", i, "mesh") for i in range(len(obstacles) if isinstance(obstacles, list) else 0))
    yield from (("actuators", key) for key in _named(Actuators))
    roles: tuple[Role, ...] = ("controller", "solver")
    for role in roles:
        name = at(data, (role, "type")) or DEFAULT_TYPE[role]
        yield from ((role, key) for key in _of_plugin(plugins, role, name))
    backends = data.get("backend_options")
    for name in backends if isinstance(backends, dict) else ():
        yield from (("backend_options", name, key) for key in _of_plugin(plugins, "backend", name))


def _of_plugin(plugins: Registry, role: Role, name: Any) -> list[str]:
    try:
        return _named(plugins.get(role, name).info.options)
    except (PluginError, TypeError):
        return []


def _named(model: type[BaseModel]) -> list[str]:
    """Options that name files."""
    return [
        info.alias or key
        for key, info in model.model_fields.items()
        if FileName in (info.annotation, *get_args(info.annotation))
    ]
