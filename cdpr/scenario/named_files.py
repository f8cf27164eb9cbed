"""Files that a document references besides its robot: in motions, events, meshes and plugin options."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, get_args

from pydantic import BaseModel

from cdpr.base.errors import PluginError
from cdpr.base.problems import Path
from cdpr.plugins import FileName
from cdpr.plugins.registry import Registry, Role
from cdpr.scenario.actuator_schema import Actuators
from cdpr.scenario.choices import DEFAULT_TYPE
from cdpr.scenario.events import EVENTS
from cdpr.scenario.motions import MOTIONS
from cdpr.scenario.nominal import ALTERNATIVE, KEY

MESH: Path = ("platform", "shape", "mesh")


def files_of_robot(data: dict[str, Any]) -> Iterator[tuple[Path, str]]:
    """Yield path and file name in a robot's data, which may be invalid."""
    return _given(data, [MESH])


def files_of_scenario(data: dict[str, Any], plugins: Registry) -> Iterator[tuple[Path, str]]:
    """Yield path and file name in a scenario's data, except the robot file."""
    return _given(data, _paths(data, plugins))


def _given(data: dict[str, Any], paths: Iterable[Path]) -> Iterator[tuple[Path, str]]:
    for path in paths:
        if isinstance(name := _at(data, path), str) and name:
            yield path, name


def _at(data: Any, path: Path) -> Any:
    """Return the value at a path in plain data, or None."""
    for key in path:
        if isinstance(data, dict):
            data = data.get(key)
        else:
            data = data[key] if isinstance(data, list) and isinstance(key, int) and key < len(data) else None
    return data


def _paths(data: dict[str, Any], plugins: Registry) -> Iterator[Path]:
    motion = _at(data, ("trajectory", "type"))
    if motion in MOTIONS:
        yield from (("trajectory", key) for key in MOTIONS[motion].files)
    events = data.get("events")
    for i, event in enumerate(events if isinstance(events, list) else []):
        if (kind := _at(event, ("type",))) in EVENTS:
            yield from (("events", i, key) for key in EVENTS[kind].files)
    yield from ((holder, *MESH) for holder in ("robot", KEY, ALTERNATIVE))
    obstacles = _at(data, ("world", "obstacles"))
    yield from (("world", "obstacles", i, "mesh") for i in range(len(obstacles) if isinstance(obstacles, list) else 0))
    yield from (("actuators", key) for key in _named(Actuators))
    roles: tuple[Role, ...] = ("controller", "solver", "estimator")
    for role in roles:
        name = _at(data, (role, "type")) or DEFAULT_TYPE[role]
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
    """Return the options that are file names."""
    return [
        info.alias or key
        for key, info in model.model_fields.items()
        if FileName in (info.annotation, *get_args(info.annotation))
    ]
