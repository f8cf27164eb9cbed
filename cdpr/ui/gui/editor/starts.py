"""Initial values of new items: a motion, an event or a cable."""

from __future__ import annotations

from itertools import count
from typing import Any

import numpy as np

from cdpr.base.errors import PluginError
from cdpr.config.document import copied
from cdpr.plugins.registry import Registry, Role
from cdpr.scenario.choices import DEFAULT_TYPE
from cdpr.scenario.nominal import cable_names
from cdpr.ui.gui.editor.fields import ONE_OF, Schema, at, branches, kind_of, resolve

# By key, in its own unit; other numbers start at 1.
NUMBERS = {"radius": 0.05, "pitch": 0.1, "height": 0.1, "duration": 3.0}
AT = 1.0  # s: start of a force
FOR = 0.5  # s: duration of a force
SHARE = 0.1  # size of a force relative to the weight, and of an offset relative to the frame
HOME = [0.0, 0.0, 1.0]  # m
MASS = 10.0  # kg
HIGHEST = 1000.0  # N
GRAVITY = 9.81  # m/s^2
JUMP = 0.01  # of a bias, in the unit of its quantity


class Starts:
    """Source of initial values for a scenario.

    Args:
        data: data of the scenario with its robot; they may be invalid.
        root: the schema.
        plugins: available plugins.
    """

    def __init__(self, data: dict[str, Any], root: Schema, plugins: Registry) -> None:
        self._data, self._root, self._plugins = data, root, plugins

    def form(self, form: Schema) -> dict[str, Any]:
        """Return the required keys of a motion, event or exit, with values that have a visible effect.

        If an event requires one of several keys, one of them is set, if it is known here.
        """
        values: dict[str, Any] = self.value(form, "")
        keys = form.get("properties", {}).keys()
        if {"time", "force"} <= keys:
            mass = at(self._data, ("robot", "platform", "mass"))
            weight = GRAVITY * (mass if _number(mass) and mass > 0.0 else MASS)
            values |= {"time": AT, "duration": FOR, "force": [0.0, 0.0, -_rounded(SHARE * weight)]}
        if {"sensor", "bias"} <= keys:
            return values | {"bias": JUMP}
        if {"time", "position"} <= keys:
            values |= {"position": self.position(), "duration": NUMBERS["duration"]}
        if {"time", "max"} <= keys:
            highest = at(self._data, ("robot", "tension", "max"))
            values["max"] = highest if _number(highest) else HIGHEST
        if {"time", "key", "value"} <= keys and (key := next(iter(self.changeable()), None)):
            role, _, option = key.partition(".")
            held = at(self._data, (role, option))
            values |= {"key": key, "value": held if _number(held) else 1.0}
        return values

    def value(self, node: Schema, key: str) -> Any:
        """Return a value for a key of this schema; "" if only the user can know it."""
        node = resolve(node, self._root)
        kind = kind_of(node, self._root)
        forms = branches(node, self._root)
        if forms:
            name = next(iter(forms))
            return {"type": name, **self.value(forms[name], key)}
        if kind == "section":
            return self._section(node, key)
        if kind == "vector":
            return self._vector(node, key)
        if kind == "list":
            return [self.value(node["items"], key)]
        if kind == "choice":
            return node.get("const", node.get("enum", [None])[0])
        item = resolve(node["items"], self._root) if kind == "yaml" and isinstance(node.get("items"), dict) else {}
        if item and kind_of(item, self._root) == "vector":
            return [self._vector(item, key)]
        if key == "sensor":
            return next(iter(sensor_names(at(self._data, ("sensors",)))), "")
        if key == "cable":
            return cable_names(self._cables())[0] if self._cables() else 1
        if kind == "number":
            return NUMBERS.get(key, 1.0)
        return {"integer": 1, "flag": False}.get(kind, "")

    def _section(self, node: Schema, key: str) -> dict[str, Any]:
        inner = node["properties"]
        names = [each for each in node.get("required", ()) if "const" not in inner[each]]
        alternatives = ONE_OF.get(str(node.get("name")), ())
        names = names or list(alternatives[:1]) or (["position"] if key and "position" in inner else [])
        values = {name: self.value(inner[name], name) for name in names}
        return {name: value for name, value in values.items() if value != ""}

    def _vector(self, node: Schema, key: str) -> list[float]:
        size = len(node.get("prefixItems", ())) or 3
        if node.get("unit") != "m" or size != 3:
            return [0.0] * size
        x, y, z = self.position()
        return [x + NUMBERS["pitch"], y, z] if key == "center" else [x, y, z]  # a circle needs a radius

    def position(self) -> list[float]:
        """Return the initial position of the run, m, if known; a default otherwise."""
        for path in (("initial", "position"), ("robot", "home", "position")):
            value = at(self._data, path)
            if isinstance(value, list) and len(value) == 3 and all(map(_number, value)):
                return list(value)
        return list(HOME)

    def cable(self) -> dict[str, Any]:
        """Return another cable: a copy of the last one, with its frame anchor slightly lower."""
        cables = self._cables()
        anchors = self.anchors("frame")
        values = copied(cables[-1]) if cables and isinstance(cables[-1], dict) else {}
        values.pop("name", None)
        place = values.get("frame")
        if len(anchors) and isinstance(place, list) and len(place) == 3 and all(map(_number, place)):
            way = _rounded(SHARE * float(np.linalg.norm(np.ptp(anchors, axis=0)))) or SHARE
            return {**values, "frame": [*place[:2], round(place[2] - way, 9)]}
        return {"frame": [0.0, 0.0, 2.0], "platform": [0.0, 0.0, 0.0]} | values

    def anchors(self, key: str) -> Any:
        """Return the cables' anchors on "frame" or "platform", (k, 3), m; empty if they are invalid."""
        found = [each.get(key) for each in self._cables() if isinstance(each, dict)]
        try:
            return np.array(found, dtype=float).reshape(-1, 3)
        except (ValueError, TypeError):
            return np.empty((0, 3))

    def changeable(self) -> list[str]:
        """Return the options of controller and solver that may change during a run."""
        keys: list[str] = []
        roles: tuple[Role, ...] = ("controller", "solver")
        for role in roles:
            name = at(self._data, (role, "type")) or DEFAULT_TYPE[role]
            try:
                info = self._plugins.get(role, str(name)).info
            except PluginError:
                continue
            keys += [f"{role}.{option}" for option in info.changeable]
        return keys

    def _cables(self) -> list[Any]:
        cables = at(self._data, ("robot", "cables"))
        return cables if isinstance(cables, list) else []


def sensor_names(sensors: Any) -> list[str]:
    """Return the names of sensors, which may be invalid; by default, the name of a sensor is its type."""
    given = [each for each in sensors if isinstance(each, dict)] if isinstance(sensors, list) else []
    return [str(each.get("name") or each.get("type")) for each in given]


def another_sensor(values: dict[str, Any], sensors: list[Any]) -> dict[str, Any]:
    """Return a new sensor with a name that none of `sensors` has."""
    taken, kind = sensor_names(sensors), str(values.get("type"))
    if kind not in taken:
        return values
    name = next(name for k in count(2) if (name := f"{kind}_{k}") not in taken)
    return {"type": kind, "name": name, **values}


def _number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _rounded(value: float) -> float:
    return float(f"{value:.2g}")
