"""The command line itself: unknown commands, completion of names and keys, units in which people read errors."""

from __future__ import annotations

import math

import pytest
from click.testing import CliRunner
from conftest import ROOT

from cdpr.cli import cli
from cdpr.cli.completion import keys, plugins
from cdpr.report.text import unit_for
from cdpr.scenario import load_scenario


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
    assert "There are run, info" in result.output
    assert len(result.output) < 500


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
