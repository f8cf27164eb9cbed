"""Plugins that are not installed: classes given to `simulate`, and the classes of a file after --plugin."""

from __future__ import annotations

import json
from types import MappingProxyType

import numpy as np
import pytest
from click.testing import CliRunner
from conftest import ROOT
from pydantic import Field

import cdpr
from cdpr.analysis.jobs.pool import Case, run_cases
from cdpr.base.errors import PluginError, ScenarioError
from cdpr.plugins import Backend, Controller, Estimator, PluginOptions, SnapshotOfArrays, TensionSolver, registry
from cdpr.simulation import loop_parts
from cdpr.tension import Status
from cdpr.ui.cli import cli

pytestmark = pytest.mark.core

CAROCA = ROOT / "scenarios" / "caroca.yaml"
SHORT = {"simulation.duration": 0.005}

FILE = '''"""Plugins of my own."""

from pydantic import Field

from cdpr.plugins import Controller, PluginOptions


class Hover(Controller):
    """carries the weight alone"""

    class Options(PluginOptions):
        factor: float = Field(1.0, ge=0.0)

    def control(self, time, state, desired, out):
        out[:] = 0.0
        out[:3] = -self.options.factor * self.robot.platform.mass * self.gravity
        if self.options.factor == 7.0:
            raise ValueError("seven")
'''


class Hover(Controller):
    """carries the weight alone"""

    class Options(PluginOptions):
        factor: float = Field(1.0, ge=0.0)

    def control(self, time, state, desired, out):
        out[:] = 0.0
        out[:3] = -self.options.factor * self.robot.platform.mass * self.gravity


class Pinv(TensionSolver):
    properties = MappingProxyType({"respects_bounds": False})

    def solve(self, W, wrench, t_min, t_max, tension):
        tension[:] = np.linalg.pinv(W) @ wrench
        return Status.OK


class Motionless(SnapshotOfArrays, Estimator):
    """A platform that is believed to stay `offset` metres above its start."""

    class Options(PluginOptions):
        offset: float = 0.0

    arrays = ()

    def connect(self, inputs):
        self.inputs = inputs

    def estimate(self, time, out):
        out[:] = self.inputs.start
        out[2] += self.options.offset


class Still(Backend):
    """A plant that does not move."""

    def reset(self, state):
        self.state[:] = state

    def step(self, n):
        pass


@pytest.fixture
def file(tmp_path):
    (tmp_path / "mine.py").write_text(FILE)
    return tmp_path / "mine.py"


@pytest.fixture
def used(file):
    registry.use_files([str(file)])
    yield file
    registry.use_files(())


def said(*arguments, code=0):
    done = CliRunner(catch_exceptions=True).invoke(cli, [*map(str, arguments)])
    if isinstance(done.exception, cdpr.CdprError):
        assert done.exception.exit_code == code
        return str(done.exception)
    assert done.exit_code == code, (done.output, done.exception)
    return done.output


def test_classes_run():
    run = cdpr.simulate(CAROCA, controller=Hover, solver=Pinv, backend=Still, overrides=SHORT)
    header = run.header
    assert (header.controller, header.solver, header.backend) == ("Hover", "Pinv", "Still")
    assert header.versions[__name__].startswith("sha256:")
    assert np.allclose(run.wrench[:, 2], header.mass * 9.81, rtol=1e-12)
    assert np.array_equal(run.position[0], run.position[-1])


def test_a_class_has_options_that_are_checked():
    run = cdpr.simulate(CAROCA, controller=Hover, overrides={**SHORT, "controller.factor": 1.5})
    assert np.allclose(run.wrench[:, 2], 1.5 * run.header.mass * 9.81, rtol=1e-12)
    with pytest.raises(ScenarioError, match=r"controller\.factor.*-1"):
        cdpr.simulate(CAROCA, controller=Hover, overrides={"controller.factor": -1.0})


def test_an_estimator_is_chosen_by_class_or_name():
    """The controller uses its estimate: PD terms act on the offset, with caroca's kp of 100 on 150 kg."""
    changes = {**SHORT, "estimator.offset": 0.002}
    run = cdpr.simulate(CAROCA, estimator=Motionless, overrides=changes)
    assert run.header.estimator == "Motionless"
    assert np.allclose(run["estimated_position"][:, 2] - run.position[0, 2], 0.002, atol=1e-12)
    plain = cdpr.simulate(CAROCA, overrides=SHORT)
    assert plain.wrench[0, 2] - run.wrench[0, 2] == pytest.approx(150 * 100 * 0.002, rel=1e-9)
    named = cdpr.simulate(CAROCA, estimator="none", overrides=SHORT)
    assert named.header.estimator == "none"
    assert np.array_equal(named.rows, plain.rows)
    with cdpr.Simulation(CAROCA, estimator=Motionless, overrides=changes) as simulation:
        simulation.step(5)
        assert np.array_equal(simulation.row, run.rows[5])
    cases = cdpr.rollout(CAROCA, 2, vary={"estimator.offset": [0.0, 0.002]}, estimator=Motionless, overrides=SHORT)
    assert np.array_equal(cases.tension[1, 0], run.tension[0])
    batch = cdpr.Batch(CAROCA, 2, estimator=Motionless, overrides=changes)
    batch.step(5)
    assert np.array_equal(batch.column("position")[:, 1], run.position[5])


def test_a_class_of_another_role_is_no_estimator():
    with pytest.raises(
        PluginError, match=r"estimator: expected a name or a class derived from cdpr\.plugins\.Estimator"
    ):
        cdpr.simulate(CAROCA, estimator=Hover)
    with pytest.raises(PluginError, match="no estimator is named 'kalman'"):
        cdpr.simulate(CAROCA, estimator="kalman")


def test_a_loaded_scenario_takes_a_class_and_keeps_to_itself():
    scenario = cdpr.load_scenario(CAROCA, overrides=SHORT)
    assert cdpr.simulate(scenario, controller=Hover).header.controller == "Hover"
    assert cdpr.simulate(scenario).header.controller != "Hover"
    assert "Hover" not in registry.registry().names("controller")


def named_as_ours():
    return type("static", (Hover,), {})


def without_control():
    return type("Half", (Controller,), {})


@pytest.mark.parametrize(
    ("choice", "message"),
    [
        (Pinv, r"controller: expected a name or a class derived from cdpr\.plugins\.Controller, got .*Pinv"),
        (object(), "controller: expected a name or a class"),
        (named_as_ours(), "class static: a controller of this name already exists; choose another name"),
        (without_control(), "controller: class Half lacks control"),
        (type("Odd", (Hover,), {"Options": dict}), "Odd.*must derive from cdpr.plugins.PluginOptions"),
        (type("Bad", (Hover,), {"__init__": lambda self, *_: 1 / 0}), "'Bad' cannot be created: ZeroDivisionError"),
    ],
)
def test_non_plugins_are_rejected(choice, message):
    with pytest.raises(PluginError, match=message):
        cdpr.simulate(CAROCA, controller=choice, overrides=SHORT)


def test_an_instance_is_reported_as_a_class():
    made = Hover(None, np.zeros(3), 0.001, None)
    with pytest.raises(PluginError, match="give the class, and its options as overrides"):
        cdpr.simulate(CAROCA, controller=made)


def test_a_file_runs_and_is_recorded(file, tmp_path):
    short = ["--set", "simulation.duration=0.005", "--no-report"]
    said("run", CAROCA, "--plugin", file, "--controller", "Hover", *short, "--out", tmp_path / "run")
    record = json.loads((tmp_path / "run" / "run.json").read_text())
    assert record["header"]["controller"] == "Hover"
    assert record["header"]["versions"]["mine.py"].startswith("sha256:")
    assert registry.plugin_files() == (), "the next command of this process knows nothing of it"


def test_the_option_estimator_replaces_that_of_the_scenario(tmp_path):
    scenario = ROOT / "scenarios" / "encoders_only.yaml"
    short = ["--set", "simulation.duration=0.005", "--no-report"]
    text = said("run", scenario, "--estimator", "forward_kinematics", *short, "--out", tmp_path / "run")
    assert "reference, computed_torque, qp, forward_kinematics;" in text
    assert "estimator forward_kinematics in place of ekf: left out force_noise, position_error, rotation_error" in text
    run = cdpr.load_run(tmp_path / "run")
    assert run.header.estimator == "forward_kinematics"
    direct = cdpr.simulate(scenario, overrides={**SHORT, "estimator": {"type": "forward_kinematics"}})
    assert not np.array_equal(direct.position, run.position), "the start of the estimate is not an option: it is kept"
    message = said("run", scenario, "--estimator", "ekf", "--set", "estimator.type=none", code=2)
    assert "--estimator ekf: estimator.type: contradicts" in message
    assert "no estimator is named 'ekff': did you mean 'ekf'" in said("run", CAROCA, "--estimator", "ekff", code=3)


def test_a_file_is_listed_and_checked(file):
    listed = json.loads(said("plugins", "--plugin", file, "--json"))["controllers"]
    (row,) = [row for row in listed if row["name"] == "Hover"]
    assert (row["summary"], row["options"], row["distribution"]) == ("carries the weight alone", ["factor"], "mine.py")
    assert "ok" in said("validate", CAROCA, "--plugin", file)


def test_a_worker_uses_the_file_as_it_was(used):
    """Though it is changed before the worker begins; and one without the file knows nothing of it."""
    case = Case("one", str(CAROCA), {**SHORT, "controller.type": "Hover"})
    bare = Case("two", str(CAROCA), {**SHORT, "controller.type": "Hover"}, plugins=())
    used.write_text("broken(")
    first, second = run_cases([case, bare], jobs=1, timeout=60.0)
    assert first.status == "finished", first.message
    assert first.versions["mine.py"] == case.plugins[0].version
    assert second.status == "failed"
    assert "no controller is named 'Hover'" in second.message


def test_a_file_that_only_adds_a_part_to_the_loop(file, monkeypatch):
    monkeypatch.setattr(loop_parts, "LOOP_PARTS", list(loop_parts.LOOP_PARTS))
    file.write_text(
        "from cdpr.base.column import Column\nfrom cdpr.simulation.loop_part import LoopPart\n"
        "from cdpr.simulation import loop_parts\nclass Count(LoopPart):\n    name = 'count'\n"
        "loop_parts.LOOP_PARTS.append(lambda scenario: Count())\n"
    )
    try:
        registry.use_files([str(file)])
        run = cdpr.simulate(CAROCA, overrides=SHORT)
        assert [part.__class__.__name__ for part in loop_parts.loop_parts(cdpr.load_scenario(CAROCA))] == ["Count"]
        assert run.status == "finished"
    finally:
        registry.use_files(())


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("import os\nx = (", r"mine\.py:2: SyntaxError: '\(' was never closed"),
        ("import os\n\nimport no_such_library", r"mine\.py:3: ModuleNotFoundError: No module named 'no_such_library'"),
        ("def f():\n    1 / 0\nf()", r"mine\.py:2: ZeroDivisionError: division by zero"),
        ("raise SystemExit(3)", r"mine\.py:1: SystemExit: 3"),
        (
            "x = 1",
            r"mine\.py: contains no class that derives from cdpr\.plugins\.Controller, TensionSolver, Estimator or "
            r"Backend, and adds no part to the loop \(LOOP_PARTS of cdpr\.simulation\.loop_parts\)$",
        ),
        ("from cdpr.simulation.loop_parts import LOOP_PARTS", "contains no class that derives from"),
        (FILE.replace("def control", "def kontrol"), "class Hover lacks control"),
        (
            FILE.replace("class Hover", "class static"),
            "mine.py: class static: a controller of this name already exists",
        ),
    ],
)
def test_a_broken_file_is_reported_with_its_line(file, text, message):
    file.write_text(text)
    with pytest.raises(PluginError, match=message):
        registry.use_files([str(file)])
    assert registry.plugin_files() == ()
    assert "Hover" not in registry.registry().names("controller")


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(PluginError, match=r"--plugin .*gone\.py: No such file or directory"):
        registry.use_files([str(tmp_path / "gone.py")])


def test_exceptions_of_plugin_files_are_reported_with_their_line(used):
    line = FILE.splitlines().index('            raise ValueError("seven")') + 1
    with pytest.raises(PluginError, match=rf"raised ValueError: seven in control \(mine\.py:{line}\)"):
        cdpr.simulate(CAROCA, controller="Hover", overrides={**SHORT, "controller.factor": 7.0})


def test_library_exceptions_are_reported_at_the_calling_line(used):
    used.write_text(FILE.replace('raise ValueError("seven")', "__import__('numpy').linalg.inv([[0.0]])"))
    registry.use_files([str(used)])
    with pytest.raises(PluginError, match=r"LinAlgError: .* in control \(mine\.py:\d+\)"):
        cdpr.simulate(CAROCA, controller="Hover", overrides={**SHORT, "controller.factor": 7.0})


def test_unknown_names_mention_plugins():
    with pytest.raises(PluginError, match="--plugin FILE adds your own"):
        registry.registry().get("controller", "Hover")


@pytest.mark.parametrize(("old", "new"), [("acts", "operations"), ("engine_acts", "engine_operations")])
def test_a_method_of_a_backend_under_its_old_name_is_rejected(old: str, new: str) -> None:
    class Old(Backend):
        def reset(self, state):
            self.state[:] = state

        def step(self, n):
            pass

    setattr(Old, old, lambda self, n=1: [])
    with pytest.raises(PluginError, match=f"method '{old}' is not used: rename it to '{new}'"):
        cdpr.simulate(str(CAROCA), backend=Old, overrides=SHORT)
