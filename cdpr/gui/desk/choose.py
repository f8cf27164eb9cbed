"""Another form of a section: another motion, shape, attitude, plugin. What both forms take stays."""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr.errors import CdprError, PluginError
from cdpr.gui.desk.fields import ONE_OF, Schema, at, branches, kind_of, resolve
from cdpr.model import rotations
from cdpr.nearest import did_you_mean
from cdpr.plugins.registry import Registry, Role
from cdpr.scenario.orientation import Orientation
from cdpr.scenario.overrides import CORE_KEYS
from cdpr.scenario.replaced import refused

DIGITS = 9  # of what is converted
PUSH = 0.1  # of the weight: a force to begin with
EVENT_STARTS: dict[str, dict[str, Any]] = {
    "wrench": {"duration": 0.5},
    "sine": {"duration": 2.0},
    "target": {"duration": 2.0},
}


def plugin_section(plugins: Registry, role: Role, name: str, given: Any, folder: str) -> dict[str, Any]:
    """Return a section of controller or solver for another plugin."""
    section = given if isinstance(given, dict) else {}
    core = {key: value for key, value in section.items() if key in CORE_KEYS[role] and key != "type"}
    try:
        model = plugins.get(role, name).info.options
    except PluginError:
        return {**section, "type": name}  # will be told
    fields = {info.alias or key for key, info in model.model_fields.items()}
    kept = {key: value for key, value in section.items() if key in fields and key not in CORE_KEYS[role]}
    wrong = refused(model, kept, folder)
    return {"type": name, **core, **{key: value for key, value in kept.items() if key not in wrong}}


def form_section(node: Schema, root: Schema, name: str, given: Any, data: dict[str, Any]) -> dict[str, Any]:
    """Return a section in the form of this name, with plain values for what it needs; CdprError if there is none.

    Args:
        node: resolved schema of the section.
        root: the whole schema.
        name: type of the form, or the key that stands for it.
        given: the section as it is.
        data: the scenario, for values to start from.
    """
    section = given if isinstance(given, dict) else {}
    forms = branches(node, root)
    if forms:
        if name not in forms:
            raise CdprError(f"there is no {name[:60]!r}: {did_you_mean(name, forms)}there are {', '.join(forms)}")
        allowed = forms[name]["properties"]
        kept = {key: value for key, value in section.items() if key in allowed}
        fresh = {**started(forms[name], root, "", data), **_more(forms[name], name, data), **kept}
        return {"type": name, **{key: value for key, value in fresh.items() if key != "type"}}
    alternatives = ONE_OF.get(str(node.get("name")), ())
    if name not in alternatives:
        raise CdprError(f"there is no {name[:60]!r}; there are {', '.join(alternatives)}")
    if node["name"] == "Orientation":
        return {name: _attitude(name, section)}
    return {name: _shape(name, section, data)}


def started(node: Schema, root: Schema, key: str, data: dict[str, Any]) -> Any:
    """Return a plain value for what a schema asks for."""
    node = resolve(node, root)
    kind = kind_of(node, root)
    home = position_of(data)
    if forms := branches(node, root):
        name = next(iter(forms))
        return {"type": name, **started(forms[name], root, key, data)}
    if kind == "section":
        if ONE_OF.get(str(node.get("name"))):
            return form_section(node, root, ONE_OF[node["name"]][0], {}, data)
        inner = node["properties"]
        needed = {name: started(inner[name], root, name, data) for name in node.get("required", ())}
        if not needed and "position" in inner:  # a pose
            needed = {"position": home}
        return {name: value for name, value in needed.items() if "const" not in inner[name]}
    if kind == "vector":
        if key == "center":
            return [round(home[0] + 0.1, DIGITS), *home[1:]]
        return home if node.get("unit") == "m" else [0.0] * len(node.get("prefixItems", [0.0] * 3))
    if kind == "list":
        return [started(node["items"], root, key, data)]
    if kind == "choice":
        return node.get("const", node.get("enum", [None])[0])
    if key == "cable":
        return 1
    return {"number": 1.0, "integer": 1, "flag": False, "text": ""}.get(kind, "")


def position_of(data: dict[str, Any]) -> list[float]:
    """Return where the run begins, m, as far as that is known."""
    for path in (("initial", "position"), ("robot", "home", "position")):
        value = at(data, path)
        if isinstance(value, list) and len(value) == 3 and all(isinstance(each, (int, float)) for each in value):
            return list(value)
    return [0.0, 0.0, 1.0]


def _more(form: Schema, name: str, data: dict[str, Any]) -> dict[str, Any]:
    """What a form needs though none of it alone is required."""
    more = dict(EVENT_STARTS.get(name, {}))
    if "force" in form["properties"]:
        mass = at(data, ("robot", "platform", "mass"))
        weight = 9.81 * mass if isinstance(mass, (int, float)) and mass > 0 else 100.0
        more["force"] = [0.0, 0.0, -float(f"{PUSH * weight:.2g}")]
    if name == "target":
        more["position"] = position_of(data)
    return more


def _attitude(name: str, given: dict[str, Any]) -> Any:
    """The same attitude in another form; upright where there is none."""
    try:
        q = Orientation.model_validate(given, strict=False).quaternion()
    except ValueError:
        q = np.array([1.0, 0.0, 0.0, 0.0])
    if name == "quaternion":
        return _plain(q)
    rpy = rotations.to_euler(q, "xyz")
    if name == "euler":  # R = Rz Ry Rx about fixed axes
        return {"angles": _plain(rpy), "order": "xyz"}
    return _plain(np.degrees(rpy) if name == "rpy_deg" else rpy)


def _plain(values: Any) -> list[float]:
    return [round(float(value), DIGITS) + 0.0 for value in values]


def _shape(name: str, given: dict[str, Any], data: dict[str, Any]) -> Any:
    """A shape of about the size of the one before, or of the box around the anchors."""
    box = given.get("box")
    if not (isinstance(box, list) and len(box) == 3 and all(isinstance(each, (int, float)) for each in box)):
        box = _around(at(data, ("robot", "cables")))
    x, y, z = (float(f"{abs(each):.3g}") or 0.1 for each in box)
    if name == "box":
        return [x, y, z]
    radius = float(f"{0.25 * (x + y):.3g}")
    return {"sphere": radius, "cylinder": {"radius": radius, "height": z}, "mesh": ""}[name]


def _around(cables: Any) -> list[float]:
    anchors = [cable.get("platform") for cable in cables if isinstance(cable, dict)] if isinstance(cables, list) else []
    try:
        return [float(each) for each in np.ptp(np.array(anchors, dtype=float).reshape(-1, 3), axis=0)]
    except ValueError:
        return [0.4, 0.3, 0.2]
