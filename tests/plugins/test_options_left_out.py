"""Options belong to their plugin: another one begins with its own defaults, and every surface reports that."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from command_line import cdpr_here
from conftest import ROOT

import cdpr
from cdpr.analysis.design.reader import load_design
from cdpr.analysis.study import load_study
from cdpr.base.errors import OptionsLeftOut, ScenarioError
from cdpr.plugins import Controller, PluginOptions
from cdpr.ui.gui.editor.editor import Editor

CAROCA = ROOT / "scenarios" / "caroca.yaml"
SHORT = {"simulation.duration": 0.05}


class Newtons(Controller):
    """PD in N/m."""

    class Options(PluginOptions):
        kp: float = 20000.0
        kd: float = 5000.0

    def control(self, time, state, desired, out):
        options = self.options
        out[:] = 0.0
        out[:3] = -self.robot.platform.mass * self.gravity
        out[:3] += options.kp * (desired[:3] - state[:3]) + options.kd * (desired[7:10] - state[7:10])


NOTE = "controller Newtons in place of computed_torque: left out kp, kd; by default kp = 20000.0, kd = 5000.0"


def test_a_controller_of_ones_own_has_its_own_gains():
    with pytest.warns(OptionsLeftOut) as told:
        run = cdpr.simulate(CAROCA, controller=Newtons)
    assert [str(one.message) for one in told] == [NOTE]
    assert told[0].filename == __file__  # the caller's line
    assert run.summary()["position_error_m"]["max"] == pytest.approx(7.23e-3, rel=1e-3)
    said = {"controller.kp": 20000.0, "controller.kd": 5000.0}
    np.testing.assert_array_equal(cdpr.simulate(CAROCA, controller=Newtons, overrides=said).rows, run.rows)


def test_nothing_is_warned_of_where_nothing_is_left_out():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scenario = cdpr.load_scenario(CAROCA, overrides={"controller.kp": 3}, controller="computed_torque")
        assert scenario.controller_options.kp == 3
        assert scenario.with_changes({"controller.kd": 4}).controller_options.kp == 3


def test_a_rollout_takes_a_class():
    masses = {"robot.platform.mass": [24.0, 25.0]}
    with pytest.warns(OptionsLeftOut, match=NOTE):
        found = cdpr.rollout(CAROCA, 2, vary=masses, controller=Newtons, overrides=SHORT, every=1)
    alone = cdpr.simulate(CAROCA, controller=Newtons, overrides=SHORT | {"robot.platform.mass": 25.0})
    np.testing.assert_array_equal(found["position"][1], alone.position)
    with pytest.raises(cdpr.CdprError, match="a class does not go with scheduler"):
        cdpr.rollout(CAROCA, 2, vary=masses, controller=Newtons, scheduler="tcp://nowhere:1")


STUDY = """scenario: caroca
changes: {simulation.duration: 0.02}
axes:
- {key: controller.type, values: [computed_torque, static]}
"""


def test_a_study_names_an_example_and_reports_what_is_left_out(tmp_path):
    (tmp_path / "s.yaml").write_text(STUDY)
    study = load_study(tmp_path / "s.yaml")
    assert [case.scenario for case in study.cases] == [str(CAROCA)] * 2
    assert study.notes == (
        "controller static in place of computed_torque: left out kp, kd; by default kp = 50.0, kd = 50.0",
    )
    done = cdpr_here("study", "s.yaml", "--dry-run", cwd=tmp_path)
    assert done.stderr.count(study.notes[0]) == 1
    (tmp_path / "s.yaml").write_text(STUDY.replace("caroca", "carocca"))
    with pytest.raises(ScenarioError, match=r"no example has that name: did you mean 'caroca'"):
        load_study(tmp_path / "s.yaml")


def test_a_design_names_an_example(tmp_path):
    text = (ROOT / "scenarios" / "studies" / "design_harvest.yaml").read_text()
    named = [line.split("#")[0].split() for line in text.splitlines() if line.startswith("robot:")]
    name = named[0][1].rpartition("/")[2].removesuffix(".yaml")
    (tmp_path / "d.yaml").write_text(text.replace(named[0][1], name))
    assert load_design(tmp_path / "d.yaml").robot_file == str(ROOT / "scenarios" / "robots" / f"{name}.yaml")


def test_the_command_line_reports_it_once(tmp_path):
    words = "run", CAROCA, "--controller", "static", "--set", "simulation.duration=0.01", "--no-report"
    done = cdpr_here(*words, cwd=tmp_path)
    assert done.stderr.count("controller static in place of computed_torque: left out kp, kd;") == 1


def test_the_window_reports_it_at_the_type():
    editor = Editor("caroca")
    editor.edit("controller.type", "static")
    (told,) = [one for one in editor.form()["warnings"] if "in place of" in one["text"]]
    assert told["text"].endswith("left out kp, kd; by default kp = 50.0, kd = 50.0")
    assert editor.scenario().controller_options.kp == 50.0
    editor.edit("controller.kp", 60.0)  # from then on it is old
    assert not [one for one in editor.form()["warnings"] if "in place of" in one["text"]]
