"""Form of a scenario and its robot: tabs of fields, each with its problems."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from cdpr.base.problems import Path, Problem, dotted
from cdpr.config.describe import json_schema
from cdpr.plugins.registry import Registry, Role
from cdpr.scenario.choices import CORE_KEYS, DEFAULT_TYPE
from cdpr.scenario.nominal import KEY, cable_names
from cdpr.scenario.schema import ScenarioSection
from cdpr.scenario.sections import OTHER, TABS, ranked, required_keys, sections_of
from cdpr.ui.gui.editor.fields import MISSING, Field, FieldFactory, Schema, at, choice, entry, every, resolve
from cdpr.ui.gui.editor.nominal import cables_in_place
from cdpr.ui.gui.editor.starts import Starts
from cdpr.ui.gui.editor.table import cable_table

SCHEMA: Schema = json_schema(ScenarioSection)


@dataclass(frozen=True)
class Subject:
    """Data from which a form is generated.

    Attributes:
        data: data of the scenario file, with the robot inserted.
        robot_file: robot file as referenced in the scenario; "" if the robot is inline.
        known: all sections with effective values, if the scenario is valid.
        plugins: available plugins.
    """

    data: dict[str, Any]
    robot_file: str
    known: Any
    plugins: Registry


def tabs(subject: Subject) -> list[dict[str, Any]]:
    """Return the tabs of the form."""
    maker = FieldFactory(SCHEMA, subject.known, _choices(subject))
    found: dict[str, list[Field]] = {tab: [] for tab in TABS}
    for section in sections_of(SCHEMA):
        found[section.tab] += _fields(subject, maker, section.key)
    unknown = ((key, value) for key, value in subject.data.items() if key not in SCHEMA["properties"])
    found[OTHER] += [maker.odd((key,), value) for key, value in unknown]
    return [{"key": key, "label": TABS[key], "fields": fields} for key, fields in found.items()]


def placed(tabs: list[dict[str, Any]], problems: Iterable[Problem]) -> list[dict[str, Any]]:
    """Return problems as plain data, each with the path of the field that shows it."""
    paths = set(_paths(tabs))
    rows = []
    for each in problems:
        ends = range(len(each.path), 0, -1)
        under = next((dotted(each.path[:end]) for end in ends if dotted(each.path[:end]) in paths), "")
        line = each.mark.line
        place = f"{each.mark.source}:{line}" if line else each.mark.source
        rows.append({"path": under, "key": dotted(each.path), "place": place, "line": line, "text": each.text})
    return rows


def _paths(tabs: list[dict[str, Any]]) -> Iterable[str]:
    for tab in tabs:
        for each in every(tab["fields"]):
            yield each["path"]
            for row in each.get("rows", ()):
                yield row["path"]
                yield from (f"{row['path']}.{column['key']}" for column in each["columns"])


def _fields(subject: Subject, maker: FieldFactory, key: str) -> list[Field]:
    """Return the fields of a section: those of the robot one by one, else one."""
    if key == "robot":
        return _robot(subject, maker)
    if key == KEY:
        robot = subject.data.get("robot", MISSING)
        return [_nominal(subject, maker, SCHEMA["$defs"]["RobotSection"], robot)] if isinstance(robot, dict) else []
    if key in CORE_KEYS:
        role: Role = "controller" if key == "controller" else "solver" if key == "solver" else "estimator"
        return [_of_plugin(subject, maker, role)]
    if key == "backend_options":
        return [_of_backends(subject, maker)]
    home = at(subject.data, ("robot", "home"))
    needed = key in (required_keys(SCHEMA) if home else SCHEMA["required"])
    value, known = subject.data.get(key, MISSING), at(subject.known, (key,))
    return [maker.field(SCHEMA["properties"][key], (key,), value, known, needed=needed)]


def _robot(subject: Subject, maker: FieldFactory) -> list[Field]:
    robot = subject.data.get("robot", MISSING)
    fields: list[Field] = []
    if subject.robot_file or not isinstance(robot, dict):
        about = SCHEMA["properties"]["robot"]["description"]
        file = subject.robot_file or None
        fields.append(
            entry(("robot",), "text", file, given=file is not None, optional=False, label="robot file", text=about)
        )
    if not isinstance(robot, dict):
        return fields
    node = SCHEMA["$defs"]["RobotSection"]
    return fields + _of_robot(node, maker, ("robot",), robot, at(subject.known, ("robot",)))


def _of_robot(node: Schema, maker: FieldFactory, path: Path, robot: dict[str, Any], known: Any) -> list[Field]:
    rows = []
    for key in ranked(node["properties"]):
        value, here = robot.get(key, MISSING), at(known, (key,))
        if key == "cables" and (isinstance(value, list) or value is MISSING):
            rows.append(cable_table(maker, (*path, key), value, robot, here))
        else:
            needed = key in node["required"]
            rows.append(maker.field(node["properties"][key], (*path, key), value, here, needed=needed))
    return [*rows, *(maker.odd((*path, key), value) for key, value in robot.items() if key not in node["properties"])]


def _nominal(subject: Subject, maker: FieldFactory, node: Schema, robot: dict[str, Any]) -> Field:
    """Return the field of the nominal robot: its values default to those of the robot, and no key is required."""
    given = subject.data.get("believed", MISSING)
    about = resolve(SCHEMA["properties"]["believed"], SCHEMA)
    section = maker.field(about, ("believed",), MISSING if isinstance(given, dict) else given)
    section |= {"given": given is not MISSING, "optional": True}
    if given is not MISSING and not isinstance(given, dict):
        return section
    nominal = {} if given is MISSING else dict(given)
    cables = robot.get("cables")
    if isinstance(cables, list):
        nominal["cables"] = cables_in_place(nominal.get("cables"), cables)
    known = at(subject.known, ("robot",))
    merged = {**robot, **nominal}
    fields = _of_robot(node, maker, ("believed",), {**nominal}, robot if known is MISSING else known)
    for i, each in enumerate(fields):
        if each["kind"] == "table":
            fields[i] = cable_table(
                maker, ("believed", "cables"), merged.get("cables", MISSING), merged, cables or MISSING
            )
        each["optional"] = True
    return section | {"kind": "section", "value": None, "fields": fields}


def _of_plugin(subject: Subject, maker: FieldFactory, role: Role) -> Field:
    given = subject.data.get(role, MISSING)
    field = maker.field(SCHEMA["properties"][role], (role,), given, at(subject.known, (role,)))
    if field["kind"] != "section":
        return field
    section = given if isinstance(given, dict) else {}
    name = section.get("type", DEFAULT_TYPE[role])
    own = [row for row in field["fields"] if row["path"].partition(".")[2] in CORE_KEYS[role]]
    options = {key: value for key, value in section.items() if key not in CORE_KEYS[role]}
    entry = next((each for each in _entries(subject.plugins, role) if each["value"] == name), None)
    field |= {"value": name, "choices": _entries(subject.plugins, role), "help": entry["help"] if entry else ""}
    core = [row for row in own if row["path"] != f"{role}.type"]
    return field | {"fields": [*core, *_options(subject, role, name, (role,), options, maker)]}


def _of_backends(subject: Subject, maker: FieldFactory) -> Field:
    given = subject.data.get("backend_options", MISSING)
    field = maker.field(SCHEMA["properties"]["backend_options"], ("backend_options",), given)
    if given is not MISSING and not isinstance(given, dict):
        return field
    sections = {} if given is MISSING else given
    chosen = at(subject.data, ("simulation", "backend"))
    if chosen is MISSING:
        chosen = resolve(SCHEMA["$defs"]["Simulation"], SCHEMA)["properties"]["backend"]["default"]
    rows = []
    for name in dict.fromkeys([*([chosen] if isinstance(chosen, str) else []), *sections]):
        path: Path = ("backend_options", name)
        options = sections.get(name, MISSING)
        if options is not MISSING and not isinstance(options, dict):
            rows.append(maker.odd(path, options))
            continue
        inner = _options(subject, "backend", name, path, options or {}, maker)
        if inner or options is not MISSING:
            row = maker.odd(path, {}) | {"kind": "section", "value": None, "given": options is not MISSING}
            rows.append(row | {"fields": inner})
    return field | {"kind": "section", "value": None, "fields": rows}


def _options(
    subject: Subject, role: Role, name: Any, path: Path, given: dict[str, Any], maker: FieldFactory
) -> list[Field]:
    """Return the fields of a plugin's options; only those in the file if the plugin is unavailable."""
    try:
        model = subject.plugins.get(role, name).info.options
        root = json_schema(model)
    except Exception:  # unknown plugin (reported elsewhere), or not a name
        root = {}
    return FieldFactory(root, choices=maker.choices).fields(root, path, given)


def _entries(plugins: Registry, role: Role) -> list[dict[str, Any]]:
    found = [plugins.get(role, name) for name in plugins.names(role)]
    return [
        choice(name, each.info.summary, each.remedy if each.missing else None) | {"label": name}
        for name, each in zip(plugins.names(role), found, strict=True)
    ]


def _choices(subject: Subject) -> dict[str, list[dict[str, Any]]]:
    """Return the allowed values of text fields that refer to cables, plugins or options."""
    choices = {"simulation.backend": _entries(subject.plugins, "backend")}
    cables = at(subject.data, ("robot", "cables"))
    names = [choice(name) | {"label": name} for name in cable_names(cables)] if isinstance(cables, list) else []
    changeable = Starts(subject.data, SCHEMA, subject.plugins).changeable()
    keys = [choice(key) | {"label": key} for key in changeable]
    events = subject.data.get("events")
    for i in range(len(events) if isinstance(events, list) else 0):
        choices[f"events[{i}].cable"] = names
        choices[f"events[{i}].key"] = keys
    return choices
