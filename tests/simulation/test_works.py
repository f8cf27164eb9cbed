"""Energy balance with further sources of work, known and unknown, of a backend, a part of the loop and a section."""

from __future__ import annotations

import json
from dataclasses import replace
from types import MappingProxyType

import numpy as np
import pytest
from conftest import ROOT

import cdpr
from cdpr.analysis.study.figures import figures
from cdpr.base.errors import PluginError
from cdpr.log.run import Run
from cdpr.mechanics.energy import energy
from cdpr.plugins import Column
from cdpr.scenario.events.loads import Wrench
from cdpr.simulation import loop_parts
from cdpr.simulation.loop_part import LoopPart
from cdpr.ui.cli.run import _lines
from cdpr.ui.report.pages.tables import summary
from cdpr_backends.reference import ReferenceBackend

SCENARIO = ROOT / "scenarios" / "planar.yaml"
SHORT = {"simulation.duration": 0.3, "initial.velocity": [0.5, 0.0, 0.2]}
WORK = (Column("drag_work", 1, "J", "Work of the drag since the first sample"),)


class Damped(ReferenceBackend):
    """Plant that loses speed in each step, by forces whose work is known."""

    column = np.zeros(1)  # of the runs without it

    def log(self, columns):
        self.column = columns["drag_work"]

    def reset(self, state):
        super().reset(state)
        self.column[0] = self.lost = 0.0

    def step(self, n):
        super().step(n)
        state, lost = self.state.copy(), self.lost
        state[7:] *= 1.0 - 1e-3
        lost += self.kinetic(state) - self.kinetic(self.state)
        super().reset(state)
        self.column[0] = self.lost = lost

    def kinetic(self, state):
        return energy(self.robot.inertial, self.gravity, state)[0]


class Known(Damped):
    columns = WORK
    properties = MappingProxyType({"works": {"the drag": "drag_work"}})


class Unknown(Damped):
    properties = MappingProxyType({"works": {"the drag": "", "the gears": ""}})


def run_of(backend="reference", **others) -> Run:
    return cdpr.simulate(SCENARIO, backend=backend, overrides=SHORT, **others)


def texts(run):
    """Return the energy in the figures, the printed line and the page of a run."""
    (line,) = [line for line in _lines(run, {}) if line.startswith("energy")]
    return run.summary()["energy_J"], line, summary(run, {})


def test_a_known_work_is_in_the_balance(tmp_path):
    run = run_of(Known, out=tmp_path / "run")
    figures, line, page = texts(run)
    assert figures["balanced"] is True
    assert figures["drag_work"] == run["drag_work"][-1] < -1.0
    assert figures["residual_max"] < 1e-7 * figures["turned_over"]
    assert f"of the drag {figures['drag_work']:.4g} J" in line
    assert "Work of the drag (J)" in page
    assert "judged" not in line + page
    read = cdpr.load_run(tmp_path / "run")
    assert read.header.works == (("the drag", "drag_work"),)
    assert np.array_equal(read.energy_residual, run.energy_residual)


def test_without_its_declaration_the_balance_is_false():
    figures, line, page = texts(run_of(Damped))
    assert figures["balanced"] is False
    assert "unknown_works" not in figures
    assert "TOO MUCH" in line
    assert "out of balance" in page


def test_an_unknown_work_makes_the_balance_unknown_and_is_named(tmp_path):
    run = run_of(Unknown, out=tmp_path / "run")
    energy, line, page = texts(run)
    assert energy["balanced"] is None
    assert energy["unknown_works"] == ["the drag", "the gears"]
    reason = "the work of the drag and of the gears is unknown"
    assert f"not judged: {reason}" in line
    assert f"not judged, {reason}" in page
    row = figures(run.summary())
    assert row["energy_balanced"] is None
    assert {key for key in row if "unknown" in key} == set()
    assert json.loads((tmp_path / "run" / "run.json").read_text())["summary"]["energy_J"]["balanced"] is None


class Toy(LoopPart):
    name = "toy"


def test_of_a_part_of_the_loop(monkeypatch):
    toy = Toy()
    monkeypatch.setattr(loop_parts, "LOOP_PARTS", [lambda scenario: toy])
    assert run_of().summary()["energy_J"]["balanced"] is True
    monkeypatch.setattr(toy, "works", {"toys": ""}, raising=False)
    energy = run_of().summary()["energy_J"]
    assert (energy["balanced"], energy["unknown_works"]) == (None, ["toys"])


def test_of_a_section(monkeypatch):
    monkeypatch.setattr(Wrench, "needs", replace(Wrench.needs, works={"a spring": ""}))
    push = {"type": "wrench", "time": 0.1, "force": [1.0, 0.0, 0.0]}
    overrides = {**SHORT, "events": [push, {**push, "time": 0.2}]}
    energy = cdpr.simulate(SCENARIO, overrides=overrides).summary()["energy_J"]
    assert (energy["balanced"], energy["unknown_works"]) == (None, ["a spring"])
    assert run_of().summary()["energy_J"]["balanced"] is True


@pytest.mark.parametrize(
    ("works", "text"),
    [
        ({"the drag": "drag"}, "works of 'the drag': expected an additional column .* got 'drag'"),
        ({"the drag": "cable_work"}, "expected an additional column"),
        ({"the drag": None}, "expected a mapping of sources and columns, got {'the drag': None}"),
        ({5: ""}, "works: expected a source with a name, got 5"),
        ({"": ""}, "works: expected a source with a name, got ''"),
        (["the drag"], r"expected a mapping of sources and columns, got \['the drag'\]"),
    ],
)
def test_wrong_declarations(works, text):
    class Wrong(Known):
        properties = MappingProxyType({"works": works})

    with pytest.raises(PluginError, match=f"backend 'Wrong': .*{text}"):
        run_of(Wrong)


def test_two_parts_with_one_source(monkeypatch):
    class Other(LoopPart):
        name = "toy"
        works = MappingProxyType({"the drag": ""})

    monkeypatch.setattr(loop_parts, "LOOP_PARTS", [lambda scenario: Other()])
    with pytest.raises(PluginError, match="part of the loop 'toy': works: another part declares the source 'the drag'"):
        run_of(Known)
