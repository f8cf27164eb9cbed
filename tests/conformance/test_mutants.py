"""Each check of the kit is killed by a plugin that is broken on purpose."""

from __future__ import annotations

import backend_mutants
import controller_mutants
import estimator_mutants
import pytest
import solver_mutants

from cdpr.base.errors import CdprError
from cdpr.testing import check_factory
from cdpr.testing.kit import BACKEND, CONTROLLER, ESTIMATOR, SOLVER
from cdpr_controllers import ComputedTorqueOptions
from cdpr_solvers.options import QpOptions

ROLES = [
    ("backend", BACKEND, backend_mutants.MUTANTS, {}),
    ("solver", SOLVER, solver_mutants.MUTANTS, solver_mutants.QP),
    ("controller", CONTROLLER, controller_mutants.MUTANTS, {}),
    ("estimator", ESTIMATOR, estimator_mutants.MUTANTS, {}),
]

OPTIONS = {"solver": QpOptions(), "controller": ComputedTorqueOptions()}  # of what most of them wrap

BROKEN = [
    pytest.param(role, mutant, {**base, **properties}, ids, id=f"{role}-{mutant.__name__}")
    for role, _, mutants, base in ROLES
    for mutant, (properties, ids) in mutants.items()
]


@pytest.mark.parametrize(("role", "mutant", "properties", "ids"), BROKEN)
@pytest.mark.usual("backend-[A-M]*", "controller-[A-P]*", "estimator-[L-R]*")
def test_broken_plugin_is_caught(role, mutant, properties, ids):
    results = check_factory(role, mutant, properties=properties, options=OPTIONS.get(role), only=ids)
    assert {result.id: result.outcome for result in results} == dict.fromkeys(ids, "failed")
    assert all(result.detail for result in results)


@pytest.mark.parametrize(("role", "checks", "mutants", "base"), ROLES, ids=[role for role, *_ in ROLES])
def test_every_check_has_a_mutant(role, checks, mutants, base):
    killed = {id for _, ids in mutants.values() for id in ids}
    assert {check.id for check in checks} == killed


@pytest.mark.parametrize(
    "checks", [SOLVER, CONTROLLER, ESTIMATOR, BACKEND], ids=["solver", "controller", "estimator", "backend"]
)
def test_descriptions_of_checks_contain_reason_and_details(checks):
    """The terminal shows the reason, docs/plugin_checks.md the whole docstring in one table cell."""
    for check in checks:
        assert check.description.startswith(check.reason), check.id
        assert not set("\n|") & set(check.description), check.id
    assert any(len(check.description) > len(check.reason) for check in checks)


@pytest.mark.slow
def test_unbroken_estimator_passes():
    results = check_factory("estimator", estimator_mutants.Fitted, properties=estimator_mutants.SENSORS)
    assert [result for result in results if result.outcome == "failed"] == []


def test_unbroken_wrapper_passes():
    """The mutants fail for their fault, not for the wrapping."""
    results = check_factory("backend", backend_mutants.Wrapped, properties={"order": 4})
    assert [result for result in results if result.outcome == "failed"] == []


@pytest.mark.slow
def test_a_backend_without_guides_is_not_applicable():
    results = {result.id: result for result in check_factory("backend", backend_mutants.NoGuides)}
    assert results["held_directions_stay"].outcome == "n/a"
    assert "only free platforms" in results["held_directions_stay"].detail


def test_expected_failures_are_strict():
    known = {"long_fall": "the engine clamps", "gravity_pulls": "no longer true"}
    results = {r.id: r for r in check_factory("backend", backend_mutants.Clamp, expected_failures=known, only=known)}
    assert results["long_fall"].outcome == "expected"
    assert "the engine clamps" in results["long_fall"].detail
    assert results["gravity_pulls"].outcome == "failed"
    assert "no longer true" in results["gravity_pulls"].detail


def test_a_declared_clamp_is_no_fault():
    (result,) = check_factory("backend", backend_mutants.Clamp, properties={"speed_max": 100.0}, only=["long_fall"])
    assert result.outcome == "passed"


def test_unknown_ids_are_refused():
    with pytest.raises(CdprError, match=r"unknown check long_fell; allowed: .*long_fall"):
        check_factory("backend", backend_mutants.Wrapped, expected_failures={"long_fell": "typo"})
