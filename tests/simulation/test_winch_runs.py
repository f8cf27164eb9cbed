"""Runs of robots on winches: what is recorded, kept and refused."""

from __future__ import annotations

import numpy as np
import pytest
import yaml
from conftest import ROOT

import cdpr
from cdpr.base.columns import FIRST
from cdpr.base.errors import PluginError, ScenarioError
from cdpr.log.export import column_names
from cdpr.plugins.registry import registry

pytestmark = pytest.mark.core

WINCHES = ROOT / "scenarios" / "robots" / "caroca_winches.yaml"
SHORT = {"simulation.duration": 0.3}
BALANCED = 1e-3  # of the energy turned over in 0.3 s; an engine of first order at 1 ms


def run(scenario="winch", **choice):
    overrides = {**SHORT, **choice.pop("overrides", {})}
    return cdpr.simulate(ROOT / "scenarios" / f"{scenario}.yaml", overrides=overrides, **choice)


@pytest.mark.parametrize("model", ["rigid", "elastic"])
@pytest.mark.parametrize("scheme", ["rk4", "semi_implicit_euler"])
def test_energy_balances_with_the_tensions_that_were(model, scheme):
    overrides = {"robot.cable.model": model, "backend_options.reference.scheme": scheme}
    winched = run(overrides=overrides)
    gap = np.abs(winched.cable_tension - winched.tension)
    assert gap[0].max() < 1e-6  # it starts with what is commanded
    assert gap[-1].max() > 1.0  # friction and inertia
    bound = 1e-9 if scheme == "rk4" else BALANCED
    assert np.abs(winched.energy_residual).max() < bound * np.abs(winched.cable_work).max()


def test_command_and_tension_go_through_the_log(tmp_path):
    done = run(out=tmp_path / "run")
    again = cdpr.load_run(tmp_path / "run")
    np.testing.assert_array_equal(again.rows, done.rows)
    assert again.header.cable_model == "elastic"
    names = column_names(done.header)
    first = names.index("cable_tension_cable_1_N")
    assert names[first : first + 8] == [f"cable_tension_cable_{i}_N" for i in range(1, 9)]
    assert names[-8:] == [f"motor_power_cable_{i}_W" for i in range(1, 9)]


def test_ideal_cables_have_no_such_columns():
    """With ideal cables the winches of the same robot have no effect, and are reported as unused."""
    ideal = run(overrides={"robot.cable.model": "ideal"})
    plain = run(overrides={"robot": yaml.safe_load((ROOT / "scenarios" / "robots" / "caroca.yaml").read_text())})
    np.testing.assert_array_equal(ideal.rows, plain.rows)
    assert tuple(ideal.header.layout.columns) == tuple(column.name for column in FIRST)
    np.testing.assert_array_equal(ideal.cable_tension, ideal.tension)
    assert {"robot.winch", "robot.cable.axial_stiffness", "robot.cable.damping"} <= set(ideal.unused)
    assert "robot.winch" not in run().unused


def test_a_cable_may_have_its_own_winch(tmp_path):
    data = yaml.safe_load(WINCHES.read_text())
    data["cables"][2] |= {"winch": {"drum_radius": 0.08, "inertia": 0.01}, "axial_stiffness": 2e5, "damping": 0}
    (tmp_path / "robot.yaml").write_text(yaml.safe_dump(data))
    robot = cdpr.load_robot(tmp_path / "robot.yaml")
    assert robot.cables[2].winch.drum_radius == 0.08
    assert robot.cables[2].winch.coulomb_friction == 0.0  # a winch is given as a whole
    assert (robot.cables[2].axial_stiffness, robot.cables[2].damping) == (2e5, 0.0)
    assert (robot.cables[3].axial_stiffness, robot.cables[3].damping) == (1e5, 100.0)
    assert robot.cables[3].winch.drum_radius == 0.05


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (
            {"winch": None},
            r"cable.model elastic needs the winch of each cable: give winch for all, such as winch: {",
        ),
        (
            {"cable": {"model": "elastic"}},
            r"elastic needs the axial stiffness \(N\) of each cable: give cable.axial_stiff",
        ),
        ({"cable": {"model": "springy"}}, r"ideal.*rigid.*elastic"),
        ({"winch": {"drum_radius": -0.05, "inertia": 0.002}}, r"drum_radius.*greater than 0.*m"),
    ],
)
def test_wrong_robots_are_refused(change, text, tmp_path):
    data = {**yaml.safe_load(WINCHES.read_text()), **change}
    data = {key: value for key, value in data.items() if value is not None}
    (tmp_path / "robot.yaml").write_text(yaml.safe_dump(data))
    with pytest.raises(ScenarioError, match=text):
        cdpr.load_robot(tmp_path / "robot.yaml")


def test_a_backend_that_knows_no_winches_is_refused(monkeypatch):
    entry = registry().get("backend", "reference")
    monkeypatch.setattr(type(entry), "properties", lambda self, options: {"order": 4})
    with pytest.raises(PluginError, match=r"'reference' does not support robot\.cable\.model elastic"):
        run()
