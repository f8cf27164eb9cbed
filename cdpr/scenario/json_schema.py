"""JSON Schemas (draft 2020-12) of scenario and robot files, for editors.

They are less strict than the loader: checks across keys are left to `cdpr validate`. Names of plugins are only
examples, so that a plugin that is not installed is not an error in the editor. Options of installed plugins are
included.
"""

from __future__ import annotations

import copy
from typing import Any

from cdpr.base.fields import HOME, TAB
from cdpr.plugins.registry import Registry, Role, registry
from cdpr.scenario.choices import CORE_KEYS, DEFAULT_TYPE
from cdpr.scenario.nominal import ALTERNATIVE, KEY, WHOLE
from cdpr.scenario.robot_schema import RobotSection
from cdpr.scenario.schema import ScenarioSection
from cdpr.scenario.sections import required_keys

DIALECT = "https://json-schema.org/draft/2020-12/schema"

Schema = dict[str, Any]


def robot_schema() -> Schema:
    """Return the schema of robot files."""
    schema = _tidy(RobotSection.model_json_schema(), without_null=True)
    return {"$schema": DIALECT, "title": "cdpr robot", **schema}


def scenario_schema(plugins: Registry | None = None) -> Schema:
    """Return the schema of scenario files, with the options of `plugins` (default: the installed ones)."""
    plugins = plugins or registry()
    schema = _tidy(ScenarioSection.model_json_schema(), without_null=True)
    definitions, sections = schema["$defs"], schema["properties"]
    robot = sections["robot"]
    sections["robot"] = {
        "description": robot.pop("description"),
        "anyOf": [{"type": "string", "description": "name of a robot file, relative to this file"}, robot],
    }
    sections[KEY] = _in_part(sections[KEY], definitions)
    sections[ALTERNATIVE] = {**sections[KEY], "description": f"another spelling of {KEY}"}
    definitions["Simulation"]["properties"]["backend"]["examples"] = plugins.names("backend")
    sections_of_plugins: tuple[tuple[Role, str], ...] = (
        ("controller", "ControllerSection"),
        ("solver", "SolverSection"),
        ("estimator", "EstimatorSection"),
    )
    for role, definition in sections_of_plugins:
        definitions[definition] = _plugin_section(role, definitions[definition], plugins, definitions)
    sections["backend_options"] = {
        "description": sections["backend_options"]["description"],
        "type": "object",
        "properties": {name: _options("backend", name, plugins, definitions) for name in plugins.names("backend")},
        "additionalProperties": {"type": "object"},
    }
    return {"$schema": DIALECT, "title": "cdpr scenario", **schema}


def _in_part(node: Any, definitions: Schema) -> Any:
    """Return a schema without required keys; referenced definitions are added in the same form.

    Sections with one of several forms keep their required keys.
    """
    if isinstance(node, list):
        return [_in_part(item, definitions) for item in node]
    if not isinstance(node, dict):
        return node
    if isinstance(node.get("$ref"), str):
        name = node["$ref"].rpartition("/")[2]
        own = f"believed.{name}"
        if own not in definitions:
            definitions[own] = _in_part(definitions[name], definitions)
        node = {**node, "$ref": f"#/$defs/{own}"}
    whole = {key: node[key] for key in WHOLE if key in node}
    return {key: _in_part(item, definitions) for key, item in node.items() if key != "required"} | whole


def _plugin_section(role: Role, core: Schema, plugins: Registry, definitions: Schema) -> Schema:
    """Return a section whose other keys depend on `type`; those of an unknown type are not checked."""
    names = plugins.names(role)
    keys = {key: core["properties"][key] for key in CORE_KEYS[role]}
    keys["type"] = {**keys["type"], "examples": names}
    rules: list[Schema] = []
    for name in names:
        options = _options(role, name, plugins, definitions)
        is_type: Schema = {"properties": {"type": {"const": name}}}
        if name != DEFAULT_TYPE[role]:
            is_type["required"] = ["type"]
        allowed = {**options, "properties": {**options.get("properties", {}), **keys}}
        rules.append({"if": is_type, "then": allowed})
    section = {"type": "object", "description": core["description"], "properties": keys}
    return {**section, "allOf": rules} if rules else section


def _options(role: Role, name: str, plugins: Registry, definitions: Schema) -> Schema:
    """Return the schema of a plugin's options, with its definitions moved to `definitions` under unique names."""
    model = plugins.get(role, name).info.options
    try:
        schema = model.model_json_schema(ref_template=f"#/$defs/{role}.{name}.{{model}}")
    except Exception:  # third-party models may have types that JSON Schema does not support
        return {"type": "object"}
    for key, definition in schema.pop("$defs", {}).items():
        definitions[f"{role}.{name}.{key}"] = _tidy(definition, without_null=False)
    tidied: Schema = _tidy(schema, without_null=False)
    return tidied


def _tidy(node: Any, *, without_null: bool) -> Any:
    """Return a schema without generated titles and forbidden nulls, and with units in descriptions."""
    if isinstance(node, list):
        return [_tidy(item, without_null=without_null) for item in node]
    if not isinstance(node, dict):
        return node
    node = copy.copy(node)
    for key in (TAB, HOME):
        node.pop(key, None)
    if "required" in node and isinstance(node.get("properties"), dict):
        node["required"] = required_keys(node)
    if isinstance(node.get("title"), str):
        del node["title"]
    if isinstance(node.get("unit"), str) and "description" in node:
        node["description"] = f"{node['description']} [{node['unit']}]"
    if without_null:
        kind = node.get("properties", {}).get("type", {})
        if "const" in kind and "default" not in kind:  # chosen by its type
            given = [*node.get("required", ()), "type"]
            node["required"] = [key for key in node["properties"] if key in given]
        if "default" in node and node["default"] is None:
            del node["default"]
        forms = [form for form in node.get("anyOf", []) if form != {"type": "null"}]
        if len(forms) == 1:
            del node["anyOf"]
            node = {**forms[0], **node}
    return {key: _tidy(value, without_null=without_null) for key, value in node.items()}
