"""Translation of form edits into edits of the files' texts."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

from cdpr.base.errors import CdprError
from cdpr.base.problems import Path, dotted
from cdpr.config.document import copied
from cdpr.config.yaml_nodes import parse_value
from cdpr.plugins.registry import Registry, Role
from cdpr.scenario.nominal import ALTERNATIVE, KEY
from cdpr.ui.gui.editor import choose, edit, nominal
from cdpr.ui.gui.editor.fields import ANY, MISSING, ONE_OF, Field, Schema, at, branches, every, resolve
from cdpr.ui.gui.editor.files import File, Files
from cdpr.ui.gui.editor.form import SCHEMA
from cdpr.ui.gui.editor.starts import Starts, another_sensor

Texts = dict[str, str]  # by file

ROLES: tuple[Role, ...] = ("controller", "solver", "estimator")
CABLES: Path = ("robot", "cables")
SENSORS: Path = ("sensors",)
LIMITS: tuple[Path, ...] = (("robot", "tension", "min"), ("robot", "tension", "max"))


class FormEdits:
    """Translator of edits into texts; it changes nothing itself.

    Its methods raise CdprError for edits that cannot be written.

    Args:
        files: the files.
        data: their data, with the robot inserted.
        robot_file: robot file as referenced in the scenario; "" if the robot is inline.
        robot: that file, if it can be read.
        tabs: returns the form, for edits that depend on the kind of field.
        known: returns all sections with effective values.
        plugins: available plugins.
    """

    def __init__(
        self,
        files: Files,
        data: dict[str, Any],
        robot_file: str,
        robot: File | None,
        tabs: Callable[[], list[dict[str, Any]]],
        known: Callable[[], Any],
        plugins: Registry,
    ) -> None:
        self._files, self._data, self._robot_file, self._robot = files, data, robot_file, robot
        self._tabs, self._known, self._plugins = tabs, known, plugins
        self._starts = Starts(data, SCHEMA, plugins)

    def set(self, key: Path, value: Any) -> Texts:
        """Return the texts with a new value at a key, or another type of a section."""
        if len(key) > 1 and key[-1] == "type" and isinstance(value, str):
            section = key[:-1]
            if section in [(role,) for role in ROLES] or self._forms(section) is not None:
                key = section  # setting `type` changes the form of the section
        if isinstance(value, str):
            value = self._chosen(key, value)
        return self._write(self._files.texts(), *self._typed(*self._whole(key, value)))

    def remove(self, key: Path) -> Texts:
        """Return the texts without a key or item, unchanged if it is absent; a cable is removed with its limits."""
        texts = self._files.texts()
        place = self._place(key)[1] if key[0] == "believed" else key
        if at(self._data, place) is MISSING:
            return texts
        if key[:-1] == CABLES:
            for limits in self._limits():
                texts = self._cut(texts, (*limits, key[-1]))
        texts = self._cut(texts, key)
        if place[:2] == ("believed", "cables") and len(place) == 4:
            text = texts[self._files.main]
            entry = _as_given(text, place[:3])
            if set(at(edit.read(text), entry)) == {"name"}:  # no difference is left for that cable
                texts = {**texts, self._files.main: edit.remove(text, entry)}
        return texts

    def insert(self, key: Path, value: Any) -> Texts:
        """Return the texts with an item appended to a list; a cable is added with limits."""
        texts, items = self._files.texts(), at(self._data, key)
        items = [] if items is MISSING else items
        if not isinstance(items, list):
            raise CdprError(f"{dotted(key)}: is not a list, so nothing can be inserted")
        if not isinstance(value, dict):
            value = self._item(key, value, items)
            if key == SENSORS and isinstance(value, dict):
                value = another_sensor(value, items)
        for limits in self._limits() if key == CABLES else ():
            held = at(self._data, limits)
            texts = self._write(texts, limits, [*held, held[-1]])
        return self._write(texts, key, [*items, value])

    def _limits(self) -> list[Path]:
        """Return the paths of limits that are given per cable."""
        cables = at(self._data, CABLES)
        lists = [(path, at(self._data, path)) for path in LIMITS]
        return [path for path, held in lists if isinstance(held, list) and held and len(held) == len(cables)]

    def _item(self, key: Path, name: Any, items: list[Any]) -> Any:
        """Return a new list item: of this type, or like the last one."""
        node = self._schema(key)
        item = resolve(node.get("items", ANY), SCHEMA) if node else {}
        if isinstance(name, str) and "discriminator" in item:
            return choose.form_section(item, SCHEMA, name, {}, self._starts)
        if name is not None:
            return name
        if key == CABLES:
            return self._starts.cable()
        if not items:
            return self._starts.value(item, str(key[-1]))
        last = copied(items[-1])
        if isinstance(last, dict):
            last.pop("name", None)
            if isinstance(last.get("time"), (int, float)):
                last["time"] += 1.0
        return last

    def _chosen(self, key: Path, text: str) -> Any:
        """Convert a text from the form: the name of a type, YAML in a field that accepts it, or plain text."""
        for role in ROLES:
            if key == (role,):
                return choose.plugin_section(role, text, self._data.get(role))
        node = self._forms(key)
        if node is not None:
            given = at(self._data, key)
            present = at(self._known(), key) if given is MISSING else given
            return choose.form_section(node, SCHEMA, text, present, self._starts)
        field = self._field(key)
        if field is None or field["kind"] != "yaml":
            return text
        try:
            return parse_value(text)
        except ValueError as error:
            raise CdprError(f"{dotted(key)}: {error}") from None

    def _field(self, path: Path) -> Field | None:
        wanted = dotted(path)
        return next((each for tab in self._tabs() for each in every(tab["fields"]) if each["path"] == wanted), None)

    def _forms(self, key: Path) -> Schema | None:
        """Return the schema of a section with several types; None for other keys."""
        node = self._schema(key)
        return node if node and ("discriminator" in node or node.get("name") in ONE_OF) else None

    def _schema(self, key: Path) -> Schema | None:
        """Return the resolved schema at a path; None if there is none."""
        node: Any = SCHEMA
        data: Any = self._data
        for part in key:
            node = resolve(node, SCHEMA)
            if forms := branches(node, SCHEMA):
                node = forms.get(str(data.get("type")) if isinstance(data, dict) else "", {})
            node = node.get("properties", {}).get(part) if isinstance(part, str) else node.get("items")
            if not isinstance(node, dict):
                return None
            data = at(data, (part,))
        return resolve(node, SCHEMA)

    def _whole(self, key: Path, value: Any) -> tuple[Path, Any]:
        """Extend an edit of a vector's component to the whole vector, if the file has no list there."""
        if len(key) < 2 or not isinstance(key[-1], int):
            return key, value
        vector, i = key[:-1], key[-1]
        if isinstance(at(self._data, self._place(vector)[1] if key[0] == "believed" else vector), list):
            return key, value
        field = self._field(vector)
        held = field["value"] if field else at(self._data, ("robot", *vector[1:])) if key[0] == "believed" else None
        if field and field["kind"] == "vector" and not isinstance(held, list):
            cables = at(self._data, CABLES)
            held = [held] * (field["size"] or (len(cables) if isinstance(cables, list) else 0))
        if isinstance(held, list) and i < len(held):
            return vector, [*held[:i], value, *held[i + 1 :]]
        return key, value

    def _typed(self, key: Path, value: Any) -> tuple[Path, Any]:
        """Extend an edit inside an absent section of several types by its `type`."""
        for end in range(1, len(key)):
            node = self._schema(key[:end])
            if node is None or "discriminator" not in node or at(self._data, key[:end]) is not MISSING:
                continue
            forms, default = branches(node, SCHEMA), node.get("default")
            known = default.get("type") if isinstance(default, dict) else None
            name = known or next((each for each, form in forms.items() if key[end] in form["properties"]), None)
            for word in reversed(key[end:]):
                value = {word: value}
            return key[:end], {"type": name, **value} if name else value
        return key, value

    def _place(self, key: Path) -> tuple[str, Path, dict[str, Any] | None]:
        """Return the file that contains a key, its path there, and the list entry to create first."""
        if key[0] == "robot" and len(key) > 1 and self._robot_file:
            if self._robot is None:
                raise CdprError(f"{dotted(key)}: the robot file '{self._robot_file}' cannot be read")
            return os.path.abspath(self._robot.name), key[1:], None
        if key[0] != "believed":
            return self._files.main, key, None
        path, entry = nominal.target(key[1:], at(self._data, ("believed", "cables")), at(self._data, CABLES))
        return self._files.main, ("believed", *path), entry

    def _cut(self, texts: Texts, key: Path) -> Texts:
        file, path, _ = self._place(key)
        return {**texts, file: edit.remove(texts[file], _as_given(texts[file], path))}

    def _write(self, texts: Texts, key: Path, value: Any) -> Texts:
        file, path, entry = self._place(key)
        text = texts[file]
        path = _as_given(text, path)
        if entry is not None and len(path) == 3:
            if not isinstance(value, dict):
                raise CdprError(f"{dotted(key)}: expected a mapping of what differs")
            text = edit.insert(text, path[:2], {**entry, **value})
        else:
            text = text if entry is None else edit.insert(text, path[:2], entry)
            text = edit.set_value(text, path, value)
        return {**texts, file: text}


def _as_given(text: str, path: Path) -> Path:
    """Return a path with `nominal` in place of `believed` if the file has this spelling."""
    if path[0] != KEY:
        return path
    given = edit.read(text)
    return (ALTERNATIVE, *path[1:]) if ALTERNATIVE in given and KEY not in given else path
