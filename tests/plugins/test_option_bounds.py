"""Numbers in the options of built-in plugins have bounds, as those of sections do."""

from __future__ import annotations

import pytest

import cdpr
from cdpr.base.errors import ScenarioError


@pytest.mark.parametrize(
    ("options", "place"),
    [
        ({"controller": {"type": "computed_torque", "kp": 1e300}}, "controller.kp"),
        ({"controller": {"type": "pid", "kd": [1.0, 1e13, 1.0, 1.0, 1.0, 1.0]}}, r"controller.kd\[1\]"),
        ({"controller": {"type": "cable_length", "pretension": 1e300}}, "controller.pretension"),
        ({"solver": {"type": "dykstra", "iterations": 10**30}}, "solver.iterations"),
        ({"solver": {"type": "daqp", "iterations": 10**30}}, "solver.iterations"),
        ({"solver": {"type": "osqp", "iterations": 2**40}}, "solver.iterations"),
        ({"solver": {"type": "qp", "change": 1e300}}, "solver.change"),
        ({"solver": {"type": "qp", "weights": [1e300] * 8}}, r"solver.weights\[0\]"),
    ],
)
def test_a_huge_number_is_rejected(options, place):
    with pytest.raises(ScenarioError, match=f"{place}: must be at most"):
        cdpr.load_scenario("caroca", overrides=options)


def test_a_huge_gain_is_rejected_during_a_run():
    with cdpr.Simulation("caroca", overrides={"simulation.duration": 0.02}) as sim:
        with pytest.raises(cdpr.base.errors.CdprError, match="set: value: must be at most"):
            sim.set("controller.kp", 1e300)
        sim.step(2)
