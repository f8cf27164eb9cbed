"""The examples that come with cdpr, found by their names."""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner
from conftest import ROOT
from spread import sampled

import cdpr
from cdpr.analysis.design import load_design
from cdpr.analysis.study import load_study
from cdpr.base.errors import CdprError, OutputError, ScenarioError
from cdpr.scenario import examples
from cdpr.ui.cli import cli

SCENARIOS = ROOT / "scenarios"
ALL = examples.examples()


def said(*arguments):
    done = CliRunner().invoke(cli, [*map(str, arguments)])
    if done.exception and not isinstance(done.exception, SystemExit):
        raise done.exception
    return done.output


def test_all_files_are_examples():
    assert {one.path for one in ALL} == set(SCENARIOS.rglob("*.yaml"))


def test_each_has_a_description():
    for example in ALL:
        assert 15 < len(example.shows) < 260, example
        assert example.shows.endswith((".", "?")), example


def test_a_name_finds_a_file_of_its_kind():
    assert cdpr.load_scenario("caroca").source == str(SCENARIOS / "caroca.yaml")
    assert cdpr.load_robot("caroca").m == 8
    assert examples.resolve("gains", "study") == str(SCENARIOS / "studies" / "gains.yaml")
    assert examples.resolve("seven", None) == str(SCENARIOS / "robots" / "seven.yaml")


def test_a_folder_hides_no_example(tmp_path, monkeypatch):
    """For all verbs and commands; a run in such a folder is found by a path."""
    monkeypatch.chdir(tmp_path)
    cdpr.simulate("caroca", overrides={"simulation.duration": 0.01}, out="caroca")
    assert cdpr.size("caroca", overrides={"simulation.duration": 0.02}).parts[0][2] == 21  # samples
    assert cdpr.size("./caroca").parts[0][2] == 11
    for run in ("./caroca", "other.mcap"):
        assert examples.is_run(run)
    for other in ("caroca", "caroca.yaml", "gains", None):
        assert not examples.is_run(other)
    assert examples.beside(str(tmp_path), "caroca", "robot") == str(SCENARIOS / "robots" / "caroca.yaml")
    assert "caroca.sdf" in said("export", "caroca", "--to", "sdf")


def test_an_existing_file_wins(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "caroca").mkdir()
    assert cdpr.load_scenario("caroca").source == str(SCENARIOS / "caroca.yaml"), "a folder is not a scenario"
    (tmp_path / "caroca").rmdir()
    (tmp_path / "caroca").write_text("name: mine")
    with pytest.raises(ScenarioError, match=r"^caroca:"):
        cdpr.load_scenario("caroca")


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("carocca", r"no file 'carocca', and no example has that name: did you mean 'caroca'\? 'cdpr examples' lists"),
        ("elsewhere/helix.yaml", r"no folder 'elsewhere'; for cdpr's example 'helix', give only the name"),
        (
            "seven",
            "'seven'; expected a scenario, but this is the name of an example robot: 'cdpr info seven'",
        ),
    ],
)
def test_a_name_that_finds_nothing(name, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ScenarioError, match=message):
        cdpr.load_scenario(name)


def test_a_study_by_the_name_of_a_scenario(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(
        ScenarioError, match="expected a study, but this is the name of an example scenario: 'cdpr run caroca' runs it"
    ):
        load_study("caroca")


def test_a_design_is_distinguished_from_a_study(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert load_design("design_box").source == str(SCENARIOS / "studies" / "design_box.yaml")
    assert [one.name for one in ALL if one.kind == "design"] == ["design_box", "design_harvest"]
    with pytest.raises(
        ScenarioError,
        match="expected a study, but this is the name of an example design: 'cdpr design design_box' runs",
    ):
        load_study("design_box")
    with pytest.raises(ScenarioError, match=r"this is a design file; cdpr design runs it; .* has 'axes'"):
        load_study(SCENARIOS / "studies" / "design_box.yaml")
    with pytest.raises(ScenarioError, match="this is a robot file; use it in a design by 'robot: FILE'"):
        load_design(SCENARIOS / "robots" / "poor_box.yaml")


def test_commands_take_names(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert "helix: ok" in said("validate", "helix")
    assert "seven: ok (robot, 7 cables)" in said("validate", "seven")
    rows = json.loads(said("study", "gains", "--dry-run", "--json"))["cases"]
    assert rows


def test_the_list():
    text = said("examples")
    for one in ALL:
        assert f"  {one.name} " in text
        assert one.shows in text


@sampled(lambda name: name in ("caroca", "cogiro", "design_box", "gains"), "name", sorted({one.name for one in ALL}))
def test_a_copy_is_whole(name, tmp_path):
    copies = examples.copy(name, tmp_path / "mine")
    (first, *_) = copies
    assert first.stem == name
    if first.name.startswith("design_"):
        assert load_design(first).name == name
        return
    done = said("study", first, "--dry-run") if first.parent.name == "studies" else said("validate", first)
    assert "ok" in done or "all valid" in done


def test_a_copy_overwrites_nothing(tmp_path):
    said("examples", "copy", "caroca", "--to", tmp_path)
    changed = tmp_path / "robots" / "caroca.yaml"
    changed.write_text("mine")
    (tmp_path / "caroca.yaml").unlink()
    with pytest.raises(OutputError, match=r"robots/caroca\.yaml: exists already"):
        examples.copy("caroca", tmp_path)
    assert not (tmp_path / "caroca.yaml").exists()
    assert changed.read_text() == "mine"


def test_a_copy_of_nothing(tmp_path):
    with pytest.raises(CdprError, match=r"no example 'helixx': did you mean 'helix'\?"):
        examples.copy("helixx", tmp_path)
