"""Every installed plugin of ours passes the kit."""

from __future__ import annotations

import json
import os
import re
import signal
from functools import partial

import pytest
from click.testing import CliRunner
from command_line import cdpr_here
from pydantic import ValidationError
from spread import sampled

from cdpr.plugins import Controller, Estimator, SnapshotOfArrays, TensionSolver
from cdpr.plugins.registry import OWN_DISTRIBUTION, ROLES, registry
from cdpr.sensing import SENSORS
from cdpr.tension import Status
from cdpr.testing import check_factory, plugin_checks, solver_answers
from cdpr.testing.check import Check
from cdpr.ui.cli import cli


def needs_options(entry):
    try:
        entry.info.options()
    except ValidationError:
        return True
    return False


# By default the kit checks these.
ALWAYS = {
    "backend": {"reference", "mujoco"},
    "solver": {"qp"},
    "controller": {"computed_torque"},
    "estimator": {"complementary"},
}


# Tests of solvers/ and native/ cover most of these for the others.
LONG = {
    "nothing_leaks",
    "eight_are_answered_as_one",
    "objective_is_reached",
    "answers_are_continuous",
    "memory_never_decides",
}


MISLEADING = "misleading_problems_are_answered_truly"


def is_slow(role, name, check):
    """The other plugins, and the longest checks."""
    return name not in ALWAYS[role] or check == MISLEADING or (role == "solver" and check in LONG)


CASES = [
    pytest.param(case, id=f"{role}-{name}-{case}", marks=[pytest.mark.slow] if is_slow(role, name, str(case)) else [])
    for role in ROLES
    for name, entry in sorted(registry().plugins[role].items())
    if entry.distribution == OWN_DISTRIBUTION and not entry.missing and not needs_options(entry)
    for case in plugin_checks(role, name)
]


@pytest.mark.parametrize("check", CASES)
def test_built_in(check):
    check()


def test_misleading_problems_in_small_numbers(monkeypatch):
    monkeypatch.setattr(solver_answers, "MANY", 60)
    (check,) = (check for check in plugin_checks("solver", "qp") if str(check) == MISLEADING)
    check()


# Effects of options; the other checks of the kit concern shared code.
ANSWERS = {
    "answers_balance",
    "what_can_be_solved_is_solved",
    "infeasible_is_never_ok",
    "degenerate_problems_are_answered",
}


@pytest.mark.parametrize(
    ("name", "options"),
    [
        pytest.param("exact", {"objective": "one_norm"}, marks=pytest.mark.slow),  # a tenth of a second a problem
        ("qpsolvers", {"name": "quadprog"}),
    ],
)
def test_options_keep_what_is_declared(name, options):
    entry = registry().get("solver", name)
    chosen = entry.info.options(**options)
    results = check_factory("solver", entry.load(), properties=entry.properties(chosen), options=chosen, only=ANSWERS)
    assert {result.outcome for result in results} == {"passed"}, results


REFERENCE = registry().get("backend", "reference")
# Checks in which the scheme differs.
SCHEME = {"coasting_keeps_velocity", "order_is_as_declared", "long_fall", "tumbling_keeps_energy_and_momentum"}


@sampled(
    lambda check: str(check) in SCHEME,
    "check",
    plugin_checks("backend", "reference", options=REFERENCE.info.options(scheme="semi_implicit_euler")),
    ids=str,
)
def test_reference_with_the_scheme_of_the_engines(check):
    check()


@pytest.mark.slow
def test_command_prints_a_table():
    done = cdpr_here("check", "controller", "static")
    assert re.search(r"^passed +it_settles ", done.stdout, re.MULTILINE)
    assert done.stdout.splitlines()[-1].startswith("controller 'static': ")


@pytest.mark.slow
def test_command_prints_json():
    done = cdpr_here("check", "solver", "pseudo_inverse", "--json")
    told = json.loads(done.stdout)
    assert told["name"] == "pseudo_inverse"
    outcomes = {check["id"]: check["outcome"] for check in told["checks"]}
    assert outcomes["answers_balance"] == "passed"
    assert outcomes["answers_are_within_the_limits"] == "n/a"


def test_reasons_of_skipped_checks_name_the_missing_declaration():
    def reason(results):
        (result,) = results
        assert result.outcome == "n/a"
        return result.detail

    solver = partial(check_factory, "solver", Remembering, properties={"warm_start": True})
    assert reason(solver(only=["the_platform_does_not_matter"])) == "it does not declare platform_independent"
    expected = "it declares warm_start: earlier problems may affect its answers"
    assert reason(solver(only=["memory_never_decides"])) == expected
    assert reason(check_factory("controller", Silent, only=["platform_is_renewed"])) == "it does not support renew"


class Remembering(TensionSolver):
    def solve(self, W, wrench, t_min, t_max, out):
        return Status.NOT_FOUND


class Silent(Controller):
    def control(self, time, state, desired, out):
        out[:] = 0.0


class Unclosable(Silent):
    def close(self):
        raise ValueError("no handle")


class Unusable(Unclosable):
    def control(self, time, state, desired, out):
        raise ValueError("no answer")


class Unprintable(Silent):
    def control(self, time, state, desired, out):
        raise UnprintableError


class UnprintableError(Exception):
    def __str__(self):
        raise RuntimeError


@pytest.mark.parametrize(
    ("plugin", "detail"),
    [
        (Unclosable, "close raised ValueError: no handle"),
        (Unusable, "raised ValueError: no answer"),
        (Unprintable, "raised UnprintableError"),
    ],
)
def test_failures_of_plugins_are_described(plugin, detail):
    (result,) = check_factory("controller", plugin, only=["output_is_complete"])
    assert (result.outcome, result.detail) == ("failed", detail)


def test_an_interrupt_shows_the_running_check(monkeypatch):
    monkeypatch.setattr(Check, "carry_out", lambda *_: os.kill(os.getpid(), signal.SIGINT))
    interrupted = CliRunner().invoke(cli, ["check", "controller", "static"])
    assert "interrupted in the check output_is_complete" in interrupted.output


def test_plugins_that_require_options_report_it():
    done = cdpr_here("check", "controller", "fmu", code=3)
    assert "controller 'fmu' needs options, such as a file" in done.stderr


def test_unknown_names_are_reported_as_everywhere():
    done = cdpr_here("check", "backend", "mujuco", code=3)
    assert "did you mean 'mujoco'?" in done.stderr


class Start(SnapshotOfArrays, Estimator):
    """It stays at the start, and uses no measurement."""

    arrays = ()

    def connect(self, inputs):
        self.start = inputs.start

    def estimate(self, time, out):
        out[:] = self.start


@pytest.mark.parametrize("sensor", sorted(set(SENSORS) - {"camera"}))
def test_estimators_may_declare_any_sensor(sensor):
    (result,) = check_factory("estimator", Start, properties={"sensors": (sensor,)}, only=["estimate_is_complete"])
    assert result.outcome == "passed", result.detail
