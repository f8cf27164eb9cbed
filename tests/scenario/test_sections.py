"""A new section of scenarios appears in the window's form, the documentation and the help of `cdpr schema`."""

from __future__ import annotations

import pytest
import scenario_files
from click.testing import CliRunner
from pydantic import Field, create_model

from cdpr.base.fields import HOME, TAB, Section, tab, unit
from cdpr.config.describe import json_schema
from cdpr.plugins.registry import registry
from cdpr.scenario import schema
from cdpr.scenario.json_schema import scenario_schema
from cdpr.scenario.schema import ScenarioSection
from cdpr.scenario.sections import TABS, sections_of
from cdpr.ui.cli import cli
from cdpr.ui.gui.editor import form

TEXT = "the air around the robot"


class Medium(Section):
    """Air."""

    density: float = Field(1.2, description="mass per volume", json_schema_extra=unit("kg/m^3"))


def extended(**extra):
    field = Medium, Field(Medium(), description=TEXT, **extra)
    return create_model("Toy", __base__=ScenarioSection, medium=field)


@pytest.fixture
def with_medium(monkeypatch):
    """A schema with a section `medium` in the tab of motions, last."""
    toy = extended(json_schema_extra=tab("motion", 5))
    monkeypatch.setattr(schema, "ScenarioSection", toy)
    monkeypatch.setattr(form, "SCHEMA", json_schema(toy))


def test_a_new_section_appears_in_the_form(with_medium):
    tabs = form.tabs(form.Subject({"medium": {"density": 1.0}}, "", {}, registry()))
    motion = next(each for each in tabs if each["key"] == "motion")
    assert [field["path"] for field in motion["fields"]] == ["initial", "trajectory", "medium"]
    (density,) = motion["fields"][2]["fields"]
    assert (density["path"], density["value"], density["unit"]) == ("medium.density", 1.0, "kg/m^3")


def test_a_new_section_appears_in_the_documentation(with_medium):
    assert f"| `medium` | Motion |  | {TEXT} |" in scenario_files.sections_table()


def test_a_new_section_appears_in_the_help(with_medium):
    lines = CliRunner().invoke(cli, ["schema", "--help"]).output.splitlines()
    assert f"  medium           {TEXT}" in lines


def test_sections_without_a_tab_are_in_the_last_one():
    row = next(row for row in sections_of(json_schema(extended())) if row.key == "medium")
    assert (row.tab, row.required) == (list(TABS)[-1], False)


def test_tabs_keep_the_order_of_ranks():
    keys = [row.key for row in sections_of(json_schema(ScenarioSection)) if row.tab == "control"]
    assert keys == ["controller", "solver", "controlled", "limits", "actuators", "drives", "sensors", "estimator"]


def test_the_initial_state_is_not_required_as_the_home_of_the_robot_replaces_it():
    rows = {row.key: row for row in sections_of(json_schema(ScenarioSection))}
    assert [key for key, row in rows.items() if row.required] == ["robot", "simulation"]
    assert "required if the robot has no home" in rows["initial"].text


def test_schemas_for_editors_contain_no_keys_of_cdpr():
    text = str(scenario_schema())
    assert TAB not in text
    assert HOME not in text
