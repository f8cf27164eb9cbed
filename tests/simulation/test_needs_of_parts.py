"""Parts of the loop in the needs table: uses reject, report or contain each of them, and so do worker processes."""

from __future__ import annotations

from functools import partial

import pytest
from click.testing import CliRunner
from conftest import ROOT
from moving_anchors import Carriage
from need_cases import FMU_OPTIONS, exports

import cdpr
from cdpr.analysis.jobs.cases import Case
from cdpr.analysis.jobs.pool import run_cases
from cdpr.base.errors import PluginError, ScenarioError
from cdpr.base.needs import EVERYWHERE, USES, Needs, left_out, no, of_loop_part, of_moving_anchors
from cdpr.formats.write.export_model import begin
from cdpr.formats.write.export_model import left_out as left_out_of
from cdpr.simulation import loop_parts
from cdpr.simulation.build import build, faults
from cdpr.simulation.loop_part import LoopPart
from cdpr.simulation.needs import omitted, require, supported
from cdpr.simulation.works import works_of
from cdpr.ui.cli import cli

CAROCA = str(ROOT / "scenarios" / "caroca.yaml")
APART = "part of the loop 'toy': not supported by {}: exports contain no added parts of the loop; remove it from the"


class Toy(LoopPart):
    name = "toy"


class Helpful(LoopPart):
    name = "helpful"
    needs = EVERYWHERE


@pytest.fixture
def loop(monkeypatch):
    """Return a function that loads caroca with these parts in its loop."""

    def load(*kinds, **overrides):
        monkeypatch.setattr(loop_parts, "LOOP_PARTS", [lambda scenario, kind=kind: kind() for kind in kinds])
        return cdpr.load_scenario(CAROCA, overrides={"simulation.duration": 0.01, **overrides})

    return load


def test_exports_reject_a_part_that_declares_nothing(loop, tmp_path):
    scenario = loop(Toy, Helpful)
    for use, call in exports(scenario, tmp_path).items():
        with pytest.raises(ScenarioError) as told:
            call()
        (line,) = str(told.value).splitlines()
        assert APART.format(USES[use]) in line


@pytest.mark.parametrize("options", FMU_OPTIONS.values())
def test_fmu_export_writes_no_fmu_without_a_part(loop, tmp_path, options):
    loop(Toy)
    target = tmp_path / "toy.fmu"
    result = CliRunner().invoke(cli, ["fmu", "export", CAROCA, "-o", str(target), *options])
    assert "part of the loop 'toy': not supported by an exported FMU" in str(result.exception)
    assert not target.exists()


def test_runs_rollouts_and_comparisons_contain_it(loop):
    scenario = loop(Toy)
    for use in "rollout", "threads", "live", "compare":
        require(scenario, use)
        assert supported(scenario, use)


def test_each_use_reads_the_declaration_of_a_part(loop):
    for use in USES:
        scenario = loop(type("Shy", (Toy,), {"needs": Needs(**{use: no("it is shy")})}))
        with pytest.raises(ScenarioError, match=f"'toy': not supported by {USES[use]}: it is shy"):
            require(scenario, use)
        assert [other for other in USES if not supported(scenario, other)] == [use]


def test_a_part_that_is_left_out_is_reported(loop):
    scenario = loop(type("Spare", (Toy,), {"needs": Needs(mjcf=left_out("models have no sensors"))}))
    assert omitted(scenario, "mjcf") == ["part of the loop 'toy': models have no sensors"]
    assert left_out_of(begin(scenario, "mjcf"), "mjcf") == omitted(scenario, "mjcf")


def test_a_part_that_moves_the_anchors_is_reported_once_with_its_section(loop, monkeypatch):
    scenario = loop(type("Own", (Carriage,), {"needs": EVERYWHERE}))
    with pytest.raises(ScenarioError, match="'carriage': not supported by MJCF: its cables leave from anchors at rest"):
        require(scenario, "mjcf")
    rows = [(("frame",), of_moving_anchors(), None)]
    monkeypatch.setattr("cdpr.simulation.needs.in_use", lambda scenario: rows)
    with pytest.raises(ScenarioError) as told:
        require(scenario, "mjcf")
    assert "frame: not supported" in str(told.value)
    assert len(str(told.value).splitlines()) == 1


def test_all_parts_with_the_same_reason_are_reported(loop):
    scenario = loop(Toy, type("Other", (Toy,), {"name": "other"}))
    with pytest.raises(ScenarioError) as told:
        require(scenario, "mjcf")
    assert {line.split("'")[1] for line in str(told.value).splitlines()} == {"toy", "other"}


@pytest.mark.parametrize("role", ["backend", "controller"])
def test_plugins_must_declare_features_that_a_part_needs(loop, role):
    scenario = loop(type("Airy", (Toy,), {"needs": Needs(**{role: {"features": "air"}})}))
    with pytest.raises(PluginError, match=rf"part of the loop 'toy': {role} '\w+', .* does not support features: air"):
        build(scenario)
    assert len(list(faults(scenario))) == 1


def test_works_that_needs_of_a_part_declare_are_known(loop):
    assert works_of(loop(type("Airy", (Toy,), {"needs": Needs(works={"air": ""})}))) == (("air", ""),)


def test_workers_reject_cases_of_a_process_with_other_parts(loop, tmp_path):
    loop(Toy)
    case = Case("a", CAROCA, {"simulation.duration": 0.01})
    (outcome,) = run_cases([case], jobs=1, timeout=60.0)
    assert outcome.status == "failed"
    assert outcome.message.startswith("parts of the loop: expected test_needs_of_parts.loop.<locals>.load.<locals>.")
    assert (
        "got cdpr.simulation.drives.drives_of, cdpr.simulation.sensors.sensors_of, "
        "cdpr.simulation.estimation.estimation_of in its worker: add them to LOOP_PARTS in a file for --plugin"
    ) in outcome.message


class Maker:
    def __call__(self, scenario):
        return Toy()


def test_names_of_entries_are_equal_in_all_processes(monkeypatch):
    """They contain no addresses of objects."""
    of_kind = partial(lambda kind, scenario: kind(), Toy)
    monkeypatch.setattr(loop_parts, "LOOP_PARTS", [Maker(), partial(Maker(), None), of_kind, Maker().__call__])
    there = loop_parts.entries()
    of_kind = partial(lambda kind, scenario: kind(), Toy)
    monkeypatch.setattr(loop_parts, "LOOP_PARTS", [Maker(), partial(Maker(), None), of_kind, Maker().__call__])
    loop_parts.check_entries(there)
    assert there[0] == there[1] == "test_needs_of_parts.Maker"


def test_the_default_rejects_exports_only():
    rejected = {use for use in USES if of_loop_part().support(use).level == "no"}
    assert set(USES) - rejected == {"rollout", "threads", "live", "compare"}
