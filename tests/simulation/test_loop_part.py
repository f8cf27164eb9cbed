"""A part of the loop that only this file and one entry of the table know."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT
from restarts import assert_restarts_give

import cdpr
from cdpr.base.column import Column
from cdpr.base.columns import GROUPS, ColumnGroup, known_columns
from cdpr.base.errors import CdprError
from cdpr.native.random_numbers import Stream
from cdpr.simulation import loop_parts
from cdpr.simulation.loop_part import LoopPart
from cdpr.tension.operations import Operation

CAROCA = str(ROOT / "scenarios" / "caroca.yaml")
SHORT = {"simulation.duration": 0.05}


class Toy(LoopPart):
    """Counts its operations, and sums the distance that the platform travelled."""

    name = "toy"
    columns = (Column("toy", 4, "", "Numbers of operations at each place, and the distance"),)

    def connect(self, surroundings):
        self.now, self.memory = surroundings, np.zeros(4)
        self.arrays = (self.memory,)

    def at(self, place, distance=0.0):
        self.memory[place] += 1.0
        self.memory[3] += distance * np.linalg.norm(self.now.view("velocity"))
        self.now.columns["toy"][:] = self.memory

    def observed(self, period):
        return [Operation(self.name, lambda: self.at(0, period))]

    def distributed(self):
        return [Operation(self.name, lambda: self.at(1))]

    def moved(self):
        return [Operation(self.name, lambda: self.at(2))]

    def describe(self):
        return {"distance": float(self.memory[3])}


@pytest.fixture
def toy(monkeypatch):
    plain = cdpr.simulate(CAROCA, overrides=SHORT)
    monkeypatch.setattr(loop_parts, "LOOP_PARTS", [lambda scenario: Toy()])
    return plain


def test_a_part_adds_its_column_and_changes_nothing_else(toy, tmp_path):
    run = cdpr.simulate(CAROCA, overrides=SHORT, out=tmp_path / "run")
    width = toy.rows.shape[1]
    assert np.ascontiguousarray(run.rows[:, :width]).tobytes() == toy.rows.tobytes()
    k = np.arange(len(run.time))
    assert np.array_equal(run["toy"][:, :3], np.stack([k + 1, k + 1, k], axis=1))  # no trace of the warm-up
    way = np.cumsum(0.001 * np.linalg.norm(run.velocity, axis=1)[1:])
    assert np.allclose(run["toy"][1:, 3], way, rtol=1e-12, atol=0.0)
    read = cdpr.load_run(tmp_path / "run")
    assert np.array_equal(read["toy"], run["toy"])
    assert run.plugins["toy"] == {"distance": run["toy"][-1, 3]}


def test_its_memory_is_restored_and_reset(toy):
    whole = cdpr.simulate(CAROCA, overrides=SHORT).rows.tobytes()
    assert_restarts_give(whole, CAROCA, SHORT)


def test_a_rollout_has_the_bits_of_single_runs(toy):
    masses = [150.0, 170.0]
    runs = [cdpr.simulate(CAROCA, overrides={**SHORT, "robot.platform.mass": mass}) for mass in masses]
    batch = cdpr.rollout(CAROCA, 2, vary={"robot.platform.mass": masses}, overrides=SHORT, columns=["toy", "position"])
    for i, run in enumerate(runs):
        assert np.array_equal(batch["toy"][i], run["toy"])
        assert np.array_equal(batch["position"][i], run.position)


def test_documented_columns_of_a_part_are_in_its_runs_only(toy, monkeypatch):
    monkeypatch.setitem(GROUPS, "toy", ColumnGroup(Toy.columns, "the loop contains a toy"))
    assert known_columns()["toy"][1] == "the loop contains a toy"
    assert "toy" in cdpr.simulate(CAROCA, overrides=SHORT).header.layout.fields
    monkeypatch.setattr(loop_parts, "LOOP_PARTS", [])
    assert "toy" not in cdpr.simulate(CAROCA, overrides=SHORT).header.layout.fields


def named(title, columns=(), streams=()):
    kind = type("Named", (LoopPart,), {"name": title, "columns": columns, "streams": streams})
    return lambda scenario: kind()


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ([named("a"), named("a")], "the loop has 2 parts named 'a': expected unique names"),
        ([named("backend")], "the loop has 2 parts named 'backend'"),
        ([named("a", streams=(Stream(0, "x"),)), named("b", streams=(Stream(0, "x"),))], "2 random streams named 'x'"),
        ([named("a", Toy.columns), named("b", Toy.columns)], "would both be 'toy' in a table"),
    ],
)
def test_equal_names_are_rejected(monkeypatch, parts, message):
    monkeypatch.setattr(loop_parts, "LOOP_PARTS", parts)
    with pytest.raises(CdprError, match=message):
        cdpr.simulate(CAROCA, overrides=SHORT)


def test_a_part_that_cannot_be_described_keeps_the_run(monkeypatch):
    class Silent(Toy):
        def describe(self):
            raise RuntimeError("nothing to say")

    monkeypatch.setattr(loop_parts, "LOOP_PARTS", [lambda scenario: Silent()])
    run = cdpr.simulate(CAROCA, overrides=SHORT)
    assert (run.status, len(run.rows)) == ("finished", 51)
    assert run.events[-1].text == "the toy raised RuntimeError: nothing to say while closing"


# Operations that move the plant have the time of the last sample, those that observe it the time of the new state.
@pytest.mark.parametrize(("place", "rows"), [("observed", 10), ("moved", 11)])
@pytest.mark.parametrize("kind", [cdpr.Infeasible, cdpr.Diverged])
def test_errors_after_a_sample_add_no_row(monkeypatch, place, rows, kind):
    class Failing(LoopPart):
        name = "failing"

        def connect(self, surroundings):
            self.time = surroundings.view("time")

        def fail(self):
            if self.time[0] > 0.0095:
                raise kind("here")

    setattr(Failing, place, lambda self, *_: [Operation(self.name, self.fail)])
    monkeypatch.setattr(loop_parts, "LOOP_PARTS", [lambda scenario: Failing()])
    with pytest.raises(kind, match="here") as stop:
        cdpr.simulate(CAROCA, overrides=SHORT)
    assert len(stop.value.run.rows) == rows


def undocumented(kinds):
    """Return the columns of these parts that are in no group of the table of columns."""
    return [column.name for kind in kinds for column in kind.columns if column.name not in known_columns()]


def test_columns_of_parts_are_in_the_table(toy):
    assert undocumented([Toy]) == ["toy"]
    assert undocumented(each for each in LoopPart.__subclasses__() if each.__module__.startswith("cdpr")) == []
