"""The JSON Schemas of `cdpr schema`: they accept what the loader accepts and catch what an editor can."""

from __future__ import annotations

from functools import cache

import jsonschema
import pytest
from conftest import ROOT
from pydantic import ConfigDict
from scenario_cases import BASE, PLUGINS, ROBOT, TEXTS, changed, load

from cdpr.config.problems import Problems
from cdpr.config.yaml_nodes import parse
from cdpr.plugins import PluginInfo, PluginOptions
from cdpr.plugins.registry import Registry
from cdpr.scenario.json_schema import robot_schema, scenario_schema

SCENARIOS = ROOT / "scenarios"

SCHEMAS = {
    "installed": scenario_schema,  # editors know the installed plugins
    "fake": lambda: scenario_schema(PLUGINS),
    "robot": robot_schema,
}


@cache
def validator(name: str):
    """Return a validator: made when first needed, which takes longer than collecting all tests of the file."""
    return jsonschema.Draft202012Validator(SCHEMAS[name]())


def data(text: str):
    return parse(text, "a.yaml", Problems()).data


@pytest.mark.parametrize("name", SCHEMAS)
@pytest.mark.usual("installed")  # it contains nearly all of the others
def test_they_are_schemas(name):
    schema = validator(name).schema
    jsonschema.Draft202012Validator.check_schema(schema)
    assert schema["$schema"] == "https://json-schema.org/draft/2020-12/schema"


@pytest.mark.parametrize("file", sorted(SCENARIOS.glob("*.yaml")), ids=lambda file: file.stem)
def test_shipped_scenarios_fit(file):
    validator("installed").validate(data(file.read_text()))


@pytest.mark.parametrize("file", sorted((SCENARIOS / "robots").glob("*.yaml")), ids=lambda file: file.stem)
def test_shipped_robots_fit(file):
    validator("robot").validate(data(file.read_text()))


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
def test_every_key_fits_and_so_does_what_is_resolved(text):
    validator("fake").validate(data(text))
    validator("fake").validate(data(load(text).resolved_yaml()))
    validator("robot").validate(data(ROBOT))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("mass: 150", "mass: heavy"),
        ("mass: 150", "mass: -5"),
        ("mass: 150", "mass: null"),
        ("mass:", "mas:"),
        ("[0, 0, -9.81]", "[0, -9.81]"),
        ("diameter: 0.006", "diameter: -1"),
        ("diameter: 0.006", "diameter: null"),
        ("infeasible: stop", "infeasible: stopp"),
        ("type: quintic", "type: quintc"),
        ("  duration: 3.0\n", ""),
        ("seed: 7", "seed: 7.5"),
        ("kp: 100", "kpp: 100"),
        ("kp: 100", "kp: [1, 2]"),
        ("type: simple,", "type: simple, speed: 3,"),
        ("integrator: euler", "integrator: rk5"),
        ("name: every-key", "name: a b"),
        ("order: XYZ", "order: XY"),
    ],
)
def test_errors_marked_by_editors(old, new):
    assert not validator("fake").is_valid(data(changed(BASE, old, new)))


def test_a_scenario_may_leave_its_beginning_to_the_robot():
    start = BASE[BASE.index("initial:") : BASE.index("robot:")]
    for shorter in ("", "initial: {velocity: [0, 0, 1]}\n", "initial: {orientation: {rpy_deg: [0, 0, 1]}}\n"):
        validator("fake").validate(data(changed(BASE, start, shorter)))
    assert not validator("fake").is_valid(data(changed(BASE, start, "initial: {position: [0, 0]}\n")))


def test_unknown_plugins_are_no_error_and_known_ones_are_suggested():
    validator("fake").validate(data(changed(BASE, "type: gains", "type: a_strangers")))
    validator("fake").validate(data(changed(BASE, "backend: plain", "backend: a_strangers")))
    validator("fake").validate(data(changed(BASE, "  tuned:", "  a_strangers:")))
    definitions = validator("fake").schema["$defs"]
    assert definitions["ControllerSection"]["properties"]["type"]["examples"] == PLUGINS.names("controller")
    assert definitions["Simulation"]["properties"]["backend"]["examples"] == PLUGINS.names("backend")


def test_without_a_type_the_options_are_those_of_the_default():
    text = changed(BASE, "{type: gains, kp: 100, kd: [1, 2, 3, 4, 5, 6]}", "{kp: 3}")
    validator("fake").validate(data(text))
    assert not validator("fake").is_valid(data(changed(text, "{kp: 3}", "{kpp: 3}")))


def test_a_robot_is_a_file_name_or_a_mapping():
    head, _, rest = BASE.partition("robot:\n")
    tail = rest[rest.index("trajectory:") :]
    validator("fake").validate(data(f"{head}robot: r.yaml\n{tail}"))
    assert not validator("fake").is_valid(data(f"{head}robot: 5\n{tail}"))


def test_fields_carry_descriptions_and_units():
    platform = validator("robot").schema["$defs"]["PlatformSection"]["properties"]
    assert platform["mass"]["description"] == "mass of the platform [kg]"
    assert platform["mass"]["unit"] == "kg"

    def fields(node, name=""):
        if isinstance(node, dict):
            for key, item in node.get("properties", {}).items():
                yield f"{name}.{key}", item
            for key, item in node.items():
                yield from fields(item, key)
        elif isinstance(node, list):
            for item in node:
                yield from fields(item, name)

    for schema in (validator("installed").schema, validator("robot").schema):
        undescribed = {name for name, item in fields(schema) if "description" not in item and "const" not in item}
        assert not {name for name in undescribed if not name.startswith(("properties.", "if."))}


def test_a_plugin_whose_options_have_no_schema_does_no_harm():
    class Odd(PluginOptions):
        model_config = ConfigDict(arbitrary_types_allowed=True)
        thing: type(iter([])) | None = None

    plugins = Registry()
    plugins.add("controller", PluginInfo(name="odd", factory="x:Y", summary="", options=Odd), "x", "0")
    schema = scenario_schema(plugins)
    jsonschema.Draft202012Validator.check_schema(schema["$defs"]["ControllerSection"])
    assert jsonschema.Draft202012Validator(schema).is_valid(data(changed(BASE, "{type: gains", "{type: odd")))
