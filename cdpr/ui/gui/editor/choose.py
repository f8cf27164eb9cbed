"""Change of a section's type: another motion, shape, attitude or plugin. Common keys are kept."""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr.base.errors import CdprError, PluginError
from cdpr.base.nearest import did_you_mean
from cdpr.model import rotations
from cdpr.plugins.registry import Registry, Role
from cdpr.scenario.choices import CORE_KEYS, DEFAULT_TYPE
from cdpr.scenario.option_migration import replacement_note
from cdpr.scenario.orientation import Orientation
from cdpr.ui.gui.editor.fields import ONE_OF, Schema, branches
from cdpr.ui.gui.editor.starts import Starts

DIGITS = 9  # of converted values
SIZE = (0.4, 0.3, 0.2)  # m, default size of a platform


def plugin_section(role: Role, name: str, given: Any) -> dict[str, Any]:
    """Return a controller or solver section for another plugin, without options of the previous one."""
    section = given if isinstance(given, dict) else {}
    if section.get("type", DEFAULT_TYPE[role]) == name:
        return {**section, "type": name}
    return {"type": name, **{key: value for key, value in section.items() if key in CORE_KEYS[role] and key != "type"}}


def plugin_note(plugins: Registry, role: Role, before: Any, after: Any) -> str:
    """Return a note on the options after a change of plugin; "" if there is nothing to report."""
    old, new = (each if isinstance(each, dict) else {} for each in (before, after))
    names = [str(each.get("type", DEFAULT_TYPE[role])) for each in (old, new)]
    if names[0] == names[1]:
        return ""
    try:
        model = plugins.get(role, names[1]).info.options
    except PluginError:
        return ""  # the form reports it
    left_out = [key for key in old if key not in new and key != "type"]
    return replacement_note(role, names[0], names[1], left_out, new, model)


def form_section(node: Schema, root: Schema, name: str, given: Any, starts: Starts) -> dict[str, Any]:
    """Return a section of another type, with initial values for required keys.

    Args:
        node: resolved schema of the section.
        root: complete schema.
        name: type, or the key that distinguishes the form.
        given: current section.
        starts: source of initial values.

    Raises:
        CdprError: if the type does not exist.
    """
    section = given if isinstance(given, dict) else {}
    forms = branches(node, root)
    known = list(forms) or list(ONE_OF.get(str(node.get("name")), ()))
    if name not in known:
        raise CdprError(f"unknown plugin {name[:60]!r}: {did_you_mean(name, known)}allowed: {', '.join(known)}")
    if forms:
        kept = {key: value for key, value in section.items() if key in forms[name]["properties"]}
        return {"type": name, **{**starts.form(forms[name]), **kept, "type": name}}
    return {name: _attitude(name, section) if node["name"] == "Orientation" else _shape(name, section, starts)}


def _attitude(name: str, given: dict[str, Any]) -> Any:
    """Return the same attitude in another representation; the identity if there is none."""
    try:
        q = Orientation.model_validate(given, strict=False).quaternion()
    except ValueError:
        q = np.array([1.0, 0.0, 0.0, 0.0])
    if name == "quaternion":
        return _plain(q)
    rpy = rotations.to_euler(q, "xyz")  # R = Rz Ry Rx, about fixed axes
    if name == "euler":
        return {"angles": _plain(rpy), "order": "xyz"}
    return _plain(np.degrees(rpy) if name == "rpy_deg" else rpy)


def _plain(values: Any) -> list[float]:
    return [round(float(value), DIGITS) + 0.0 for value in values]


def _shape(name: str, given: dict[str, Any], starts: Starts) -> Any:
    """Return a shape with about the size of the previous box, or of the box around the anchors."""
    box, anchors = given.get("box"), starts.anchors("platform")
    try:
        sizes = [float(each) for each in (box or np.ptp(anchors, axis=0))]
    except (ValueError, TypeError):
        sizes = []
    x, y, z = (float(f"{abs(each):.3g}") or other for each, other in zip(sizes or SIZE, SIZE, strict=False))
    radius = float(f"{0.25 * (x + y):.3g}")
    return {"box": [x, y, z], "sphere": radius, "cylinder": {"radius": radius, "height": z}, "mesh": ""}[name]
