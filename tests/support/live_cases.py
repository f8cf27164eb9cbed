"""Simulations to which something is done, for the tests of that."""

from __future__ import annotations

import numpy as np
from conftest import ROOT

import cdpr

CAROCA = str(ROOT / "scenarios" / "caroca.yaml")
WINCH = str(ROOT / "scenarios" / "winch.yaml")
# Here caroca can do without a cable; at the start it holds still.
PLACE = {"initial.position": [1.0, 0.3, 1.5], "trajectory": {"type": "hold"}}
SHORT = {"simulation.duration": 0.05}
QUIET = {**SHORT, **PLACE}


def simulation(**changes):
    return cdpr.Simulation(CAROCA, overrides={**SHORT, **changes})


def quiet(**changes):
    return cdpr.Simulation(CAROCA, overrides={**QUIET, **changes})


def simulated(*events, **changes):
    return cdpr.simulate(CAROCA, overrides={**QUIET, "events": list(events), **changes})


def busy(sim):
    """Everything, also at one sample, with what the scenario plans between."""
    sim.step(3)
    push = sim.push([30, 0, 0])
    sim.step(2, wrench=[10.0, 0, 1500, 0, 0, 0.1])
    sim.target([1.02, 0.3, 1.5], limits={"velocity": 1, "acceleration": 10, "jerk": 1000})
    sim.set("controller.kd", [11, 12, 13, 14, 15, 16])
    sim.set("controller.kp", 30)
    sim.step(5)
    sim.release(push)
    sim.step(1, tension=np.linspace(100, 300, 8) / 3.0)
    sim.step(1, tension=np.linspace(100, 300, 8) / 7.0)
    sim.jam(1, detected_after=0.003)
    sim.limits(max=2000)
    sim.step(4)
    sim.cut(1)
    sim.push(moment=[0, 0, 1 / 3], duration=0.004)
    sim.step(7)
    sim.stop()
    sim.step(5)


PLANNED = {
    "events": [
        {"type": "sine", "time": 0.0, "force": [5, 0, 0], "frequency": 30.0},
        {"type": "limits", "time": 0.012, "min": 20},
        {"type": "target", "time": 0.016, "position": [1.0, 0.31, 1.5], "duration": 0.02},
    ]
}
