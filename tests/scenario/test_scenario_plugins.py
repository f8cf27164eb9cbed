"""Options of plugins: whose they are, when they are checked, and what another choice of plugin does."""

from __future__ import annotations

import pytest
from scenario_cases import (
    BASE,
    PLUGINS,
    GainsOptions,
    TunedOptions,
    changed,
    line_of,
    load,
    problem,
    problems,
)

from cdpr.base.errors import CdprError, ExitCode, PluginError, ScenarioError
from cdpr.plugins.registry import registry
from cdpr.scenario import load_scenario
from cdpr.scenario.choices import DEFAULT_TYPE, typed
from cdpr.scenario.run_checks import RunChecks
from cdpr.scenario.schema import Simulation

pytestmark = pytest.mark.core


def test_options_are_instances_of_the_plugins_models():
    scenario = load()
    assert scenario.controller_options == GainsOptions(kp=100.0, kd=(1, 2, 3, 4, 5, 6))
    assert scenario.solver_options.model_dump() == {}
    assert scenario.backend_options("tuned") == TunedOptions(integrator="euler", tolerance=1e-6)
    assert scenario.backend_options().model_dump() == {}
    assert scenario.backend_options("reference").model_dump() == {}
    with pytest.raises(PluginError, match="no backend is named 'plane': did you mean 'plain'"):
        scenario.backend_options("plane")


def test_options_of_backends_are_checked_chosen_or_not_installed_or_not():
    text = changed(BASE, "tolerance: 1e-6", "tolerance: x")
    assert PLUGINS.get("backend", "tuned").missing  # its package is not installed
    assert f"a.yaml:{line_of(text, 'tolerance: x')}:" in problem(text)


def test_errors_of_a_model_are_reported_at_its_section():
    text = changed(BASE, "{integrator: euler, tolerance: 1e-6}", "{integrator: rk4, tolerance: 1}")
    line = line_of(text, "tuned:")
    assert problem(text) == f"a.yaml:{line}:10: backend_options.tuned: rk4 needs a tolerance of 0.1 at most"


def test_a_backend_that_needs_options_needs_them_only_when_chosen():
    assert load().simulation.backend == "plain"
    line = problem(BASE, backend="needy")
    assert "backend_options.needy.path: required but not given: file to run" in line
    assert load(BASE, "backend_options.needy.path=x", backend="needy").backend_options().path == "x"


@pytest.mark.parametrize(
    ("old", "new", "key", "what"),
    [
        (
            "type: gains",
            "type: gians",
            "controller.type",
            "no controller is named 'gians': did you mean 'gains'? installed",
        ),
        (
            "type: simple",
            "type: simpel",
            "solver.type",
            "no solver is named 'simpel': did you mean 'simple'?",
        ),
        (
            "backend: plain",
            "backend: plane",
            "simulation.backend",
            "no backend is named 'plane': did you mean 'plain'?",
        ),
        ("  tuned:", "  tund:", "backend_options.tund", "no backend is named 'tund': did you mean 'tuned'?"),
    ],
)
def test_an_unknown_name_alone_is_a_matter_of_plugins(old, new, key, what):
    text = changed(BASE, old, new)
    with pytest.raises(PluginError) as caught:
        load(text)
    assert caught.value.exit_code == ExitCode.PLUGIN
    assert str(caught.value).startswith(f"a.yaml:{line_of(text, new.strip())}:")
    assert f": {key}: {what}" in str(caught.value)


def test_an_unknown_name_among_other_problems_is_a_matter_of_the_scenario():
    text = changed(changed(BASE, "type: gains", "type: gians"), "seed: 7", "seed: x")
    with pytest.raises(ScenarioError) as caught:
        load(text)
    assert caught.value.exit_code == ExitCode.BAD_INPUT
    assert len(caught.value.problems) == 2


def test_several_unknown_names_are_all_named():
    text = changed(changed(BASE, "type: gains", "type: x"), "type: simple", "type: y")
    with pytest.raises(PluginError) as caught:
        load(text)
    assert [line.split(": ")[1] for line in str(caught.value).splitlines()] == [
        "controller.type",
        "solver.type",
    ]


def test_names_that_are_no_texts():
    for old, new in [
        ("type: gains", "type: 5"),
        ("type: simple", "type: [a]"),
        ("backend: plain", "backend: true"),
    ]:
        assert "expected a text, got" in problem(changed(BASE, old, new))


def test_sections_that_are_no_mappings():
    assert "controller: expected a mapping (type), got 5" in problem(BASE, "controller=5")
    assert "solver: expected a mapping (type, infeasible), got a list of 1" in problem(BASE, "solver=[5]")
    assert "backend_options: expected a mapping, got 5" in problem(BASE, "backend_options=5")
    assert "backend_options.tuned: expected a mapping, got 5" in problem(BASE, "backend_options.tuned=5")


def test_a_plugin_whose_model_fails_is_named():
    with pytest.raises(PluginError) as caught:
        load(BASE, backend="broken")
    assert "the options of backend 'broken' of cdpr 0 cannot be checked: RuntimeError: foreign fault" in str(
        caught.value
    )


@pytest.mark.parametrize("wrong", ["gain: '5'", "gain: true", "on: 1", "on: 'true'", "on: no"])
def test_a_lax_model_is_used_strictly(wrong):
    assert "expected " in problem(BASE, f"controller={{type: lax, {wrong}}}")


def test_a_model_with_an_odd_schema_is_still_checked():
    assert load(BASE, "controller={type: odd, gain: 3}").controller_options.gain == 3
    with pytest.raises(CdprError, match="controller"):
        load(BASE, "controller={type: odd, gain: x}")


def test_options_of_a_backend_that_needs_some_and_has_none():
    with pytest.raises(PluginError, match="needs options: give them under backend_options"):
        load().backend_options("needy")


def test_another_type_leaves_the_old_options_behind():
    scenario = load(BASE, controller="none", solver="tuned")
    assert scenario.controller.type == "none"
    assert scenario.controller_options.model_dump() == {}
    assert scenario.solver.infeasible == "stop"  # a core key: it carries over
    assert scenario.unused[-2:] == ("controller.kp", "controller.kd")
    assert "kp" not in scenario.resolved_yaml()


def test_the_same_type_keeps_its_options():
    scenario = load(BASE, controller="gains")
    assert scenario.controller_options.kp == 100
    assert "controller.kp" not in scenario.unused


def test_the_default_type_counts_as_the_old_one():
    text = changed(BASE, "{type: gains, kp: 100, kd: [1, 2, 3, 4, 5, 6]}", "{kp: 3, kd: 1}")
    assert DEFAULT_TYPE["controller"] == "computed_torque"
    assert load(text, controller="computed_torque").notes == ()
    scenario = load(text, controller="gains")
    assert scenario.controller_options.kp != 3  # both have a kp: it may mean another thing, in another unit
    assert scenario.notes[0].startswith("controller gains in place of computed_torque: left out kp, kd; by default")


def test_no_option_is_carried_over_to_another_plugin():
    scenario = load(BASE, controller="damped")
    assert (scenario.controller_options.kp, scenario.controller_options.kd) == (1.0, 20.0)
    assert scenario.unused[-2:] == ("controller.kp", "controller.kd")
    assert scenario.notes == ("controller damped in place of gains: left out kp, kd; by default kp = 1.0, kd = 20.0",)
    text = changed(BASE, "{type: gains, kp: 100, kd: [1, 2, 3, 4, 5, 6]}", "{type: gains, kp: 5, limit: 7}")
    scenario = load(text, controller="damped")
    assert scenario.unused[-1:] == ("controller.limit",)
    assert scenario.notes == (
        "controller damped in place of gains: left out kp, limit; by default kp = 1.0, kd = 20.0",
    )


@pytest.mark.parametrize("later", [True, False])
def test_dependent_changes_are_kept_in_any_order(later):
    given = ["controller.type=damped", "controller.kp=400"]
    scenario = load(BASE, *(given if later else given[::-1]))
    assert scenario.controller_options.kp == 400
    assert "controller.kp" not in scenario.unused
    assert "unknown key 'kp'" in problem(BASE, "controller.kp=400", controller="none")


def test_setting_the_type_does_the_same_and_new_options_may_follow():
    scenario = load(BASE, "solver.type=tuned", "solver.tolerance=0.5", "controller.type=none")
    assert scenario.solver_options.tolerance == 0.5
    assert scenario.unused[-2:] == ("controller.kp", "controller.kd")
    scenario = load(BASE, "solver.tolerance=0.5", solver="tuned")
    assert scenario.solver_options.tolerance == 0.5


def test_a_choice_that_does_not_exist_names_the_choice():
    assert problem(BASE, backend="plane").startswith("backend='plane': simulation.backend: no backend is named 'plane'")
    assert problem(BASE, solver="x").startswith("solver='x': solver.type: no solver is named 'x'")
    assert problem(BASE, controller="\ud800").startswith("controller=")
    line = problem(BASE, *typed({"backend": "plane", "solver": None}))
    assert line.startswith("--backend plane: simulation.backend: no backend is named 'plane'")


def test_properties_of_cables_that_nothing_uses_yet_are_listed():
    assert load().unused == ("robot.cables[*].axial_stiffness", "robot.cables[*].linear_density")


def test_the_defaults_are_installed():
    """A scenario without plugin names uses the plugins of cdpr."""
    found = registry()
    found.get("controller", DEFAULT_TYPE["controller"])
    found.get("solver", DEFAULT_TYPE["solver"])
    found.get("backend", Simulation(duration=1.0).backend)


def test_the_installed_plugins_are_used_unless_others_are_given():
    with pytest.raises(PluginError, match="no controller is named 'gains'"):
        load_scenario("a.yaml", text=BASE, backend="reference")


def test_a_fault_of_ours_is_not_taken_for_one_of_the_file(monkeypatch):
    monkeypatch.setattr(RunChecks, "run", lambda self: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        problems()
