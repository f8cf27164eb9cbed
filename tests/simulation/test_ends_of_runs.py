"""For any exception or output of a plugin, its run ends with a clear error and a complete record."""

from __future__ import annotations

import json

import numpy as np
import pytest
from conftest import ROOT

from cdpr import Diverged, PluginError, Simulation, rollout, simulate
from cdpr.base.errors import ExitCode
from cdpr.plugins import Controller, TensionSolver
from cdpr.tension.status import Status

pytestmark = pytest.mark.core

CAROCA = ROOT / "scenarios" / "caroca.yaml"
SHORT = {"simulation.duration": 0.05}


class Own(BaseException):
    """Derives from BaseException, as no plugin's should."""


def raising(error):
    """Return a solver and a controller that raise after some calls."""

    class Solver(TensionSolver):
        def solve(self, W, wrench, t_min, t_max, tension):
            self.count = getattr(self, "count", 0) + 1
            if self.count > 10:
                raise error
            tension[:] = 500.0
            return Status.INFEASIBLE

    class Law(Controller):
        def control(self, time, state, desired, out):
            out[:] = 0.0
            if time > 0.01:
                raise error

    return {"solver": Solver, "controller": Law}


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("error", [GeneratorExit, SystemExit, Own, StopIteration])
@pytest.mark.parametrize("role", ["solver", "controller"])
def test_any_exception_of_a_plugin_ends_the_run_as_failed(error, role, tmp_path):
    plugin = {role: raising(error)[role]}
    with pytest.raises(PluginError, match=f"raised {error.__name__}") as stop:
        simulate(CAROCA, overrides=SHORT, out=tmp_path / "run", **plugin)
    assert stop.value.exit_code == ExitCode.PLUGIN
    assert json.loads((tmp_path / "run" / "run.json").read_text())["status"] == "failed"
    with Simulation(CAROCA, overrides=SHORT, **plugin) as sim, pytest.raises(PluginError, match=error.__name__):
        sim.until(0.05)
    outcomes = rollout(CAROCA, 1, vary={"robot.platform.mass": [25.0]}, overrides=SHORT, **plugin).outcomes
    assert [one.status for one in outcomes] == ["failed"]


def test_a_plugin_that_cannot_be_made_is_reported():
    class Law(Controller):
        def __init__(self, *arguments):
            raise GeneratorExit

        def control(self, time, state, desired, out):
            """Never called."""

    with pytest.raises(PluginError, match="cannot be created: GeneratorExit"):
        simulate(CAROCA, controller=Law, overrides=SHORT)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("value", [np.inf, -np.inf, np.nan])
def test_an_output_that_is_not_finite_ends_the_run(value, tmp_path):
    class Law(Controller):
        def control(self, time, state, desired, out):
            out[:] = 0.0
            out[3] = value if time > 0.0095 else 0.0

    with pytest.raises(Diverged, match=r"t = 0.01 s: the controller's wrench is not finite") as stop:
        simulate(CAROCA, controller=Law, overrides=SHORT, out=tmp_path / "run")
    assert stop.value.exit_code == ExitCode.DIVERGED == 5
    assert np.isfinite(stop.value.run.wrench).all()
    assert stop.value.run.status == "diverged"
