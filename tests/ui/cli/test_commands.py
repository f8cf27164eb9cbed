"""The command line itself: unknown commands, completion of names and keys, units in which people read errors."""

from __future__ import annotations

import math
import os
import shlex

import pytest
from click.testing import CliRunner
from conftest import ROOT

from cdpr.analysis.study import load_study
from cdpr.base.errors import ScenarioError
from cdpr.scenario import load_scenario
from cdpr.ui.cli import cli
from cdpr.ui.cli.completion import keys, plugins
from cdpr.ui.report.text.aligned import unit_for

pytestmark = pytest.mark.core


@pytest.mark.parametrize(
    ("words", "near"), [(["rum"], "run"), (["fmu", "expotr"], "export"), (["vaildate", "x.yaml"], "validate")]
)
def test_an_unknown_command_names_the_nearest(words, near):
    result = CliRunner().invoke(cli, words)
    assert result.exit_code == 2
    assert f"Did you mean '{near}'? There are " in result.output


def test_a_word_like_no_command_names_all():
    result = CliRunner().invoke(cli, ["x" * 500])
    assert result.exit_code == 2
    assert "Did you mean" not in result.output
    assert "There are " in result.output
    assert "x" * 61 not in result.output


def test_keys_that_a_shell_offers_are_keys():
    offered = keys(None, None, "")
    assert "simulation.duration" in offered
    assert {"controller.kp", "solver.weights", "backend_options.mujoco.integrator", "robot.cables[0].frame"} <= {
        *offered
    }
    assert keys(None, None, "simulation.d") == ["simulation.duration"]
    assert keys(None, None, "nothing") == []
    for key in ("simulation.seed", "world.gravity", "initial.position"):
        assert key in offered
        load_scenario(ROOT / "scenarios" / "caroca.yaml", overrides=[f"{key}={1 if 'seed' in key else '[0, 0, 1]'}"])


def test_plugins_that_a_shell_offers():
    assert plugins("solver")(None, None, "qp")[0] == "qp"
    assert plugins("backend")(None, None, "reference,ref") == ["reference,reference"]


@pytest.mark.parametrize(
    ("values", "unit"),
    [([0.0304], "mm"), ([13.04, 0.001], "m"), ([math.nan, 0.5], "mm"), ([math.inf], "mm"), ([-2.0], "m"), ([], "mm")],
)
def test_the_unit_follows_the_largest(values, unit):
    assert unit_for(values, "m")[1] == unit


STUDY = """\
scenario: {scenario}
axes:
- key: controller.kp
  values: [50, 100]
changes: {{simulation.duration: 0.5}}
"""


def study(tmp_path, *words):
    (tmp_path / "s.yaml").write_text(
        STUDY.format(scenario=os.path.relpath(ROOT / "scenarios" / "caroca.yaml", tmp_path))
    )
    return CliRunner().invoke(cli, ["study", str(tmp_path / "s.yaml"), *words])


def test_a_study_takes_keys_for_all_its_cases(tmp_path):
    overrides = ["simulation.duration=0.02", "controller.type=static", "controller.kd=7"]
    study(tmp_path, "--dry-run")
    loaded = load_study(tmp_path / "s.yaml", overrides=overrides)
    for case, kp in zip(loaded.cases, (50, 100), strict=True):
        scenario = load_scenario(case.scenario, text=case.text)
        assert scenario.simulation.duration == 0.02  # after the study's own changes
        assert (scenario.controller.type, scenario.controller_options.kp) == ("static", kp)
        assert scenario.controller_options.kd == 7
    assert loaded.digest != load_study(tmp_path / "s.yaml").digest


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            "controller.kp=3",
            "--set controller.kp=3: controller.kp: an axis of the study varies this key; edit the axis",
        ),
        ("controller.kpp=3", "--set controller.kpp=3: controller.kpp: unknown key 'kpp': did you mean 'kp'?"),
    ],
)
def test_keys_that_a_study_cannot_set(tmp_path, change, said):
    study(tmp_path, "--dry-run")
    with pytest.raises(ScenarioError) as caught:
        load_study(tmp_path / "s.yaml", overrides=[change])
    assert str(caught.value).startswith(said)


PLUGIN = """\
from cdpr.plugins import Controller

class Idle(Controller):
    def control(self, t, state, desired, out):
        out[:] = 0.0
"""


def test_the_continuation_repeats_the_whole_command(tmp_path, monkeypatch):
    def interrupted(*arguments, **more):
        raise KeyboardInterrupt

    monkeypatch.setattr("cdpr.analysis.study.run_study", interrupted)
    (tmp_path / "p.py").write_text(PLUGIN)
    words = ["--jobs", "2", "--set", "world.gravity=[0, 0, -1]", "--plugin", str(tmp_path / "p.py"), "--no-report"]
    result = study(tmp_path, *words, "--out", str(tmp_path / "a b"))
    (line,) = [line for line in result.output.splitlines() if "continue by: " in line]
    said = shlex.split(line.partition("continue by: ")[2])
    assert said[:2] == ["cli", "study"]
    assert said[2:] == [
        *("--plugin", str(tmp_path / "p.py"), str(tmp_path / "s.yaml"), "--set", "world.gravity=[0, 0, -1]"),
        *("--jobs", "2", "--no-report", "--out", str(tmp_path / "a b")),
    ]
