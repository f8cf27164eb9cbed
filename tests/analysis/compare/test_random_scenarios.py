"""Sound engines agree in random scenarios; CDPR_SCENARIOS=N tries N instead of a few."""

from __future__ import annotations

import os
from dataclasses import replace

import pytest
import random_scenarios
from compare_cases import ENGINES, Here

from cdpr.analysis.compare.comparison import compare
from cdpr.analysis.compare.engines import field
from cdpr.analysis.compare.job import summarise
from cdpr.analysis.compare.refinement import refine

COUNT = int(os.environ.get("CDPR_SCENARIOS", "2"))
# Of a scheme that only MuJoCo has; it holds external wrenches over a step, so with one it is of first order.
RK4 = {"backend_options.mujoco": {"cables": "native", "integrator": "rk4"}, "events": []}


def verdicts(seed):
    """Outcome of the comparison, refined, and why."""
    scenario = random_scenarios.scenario(seed)
    own = scenario.robot.cable_model == "ideal" and all(cable.exit is None for cable in scenario.robot.cables)
    if own and "mujoco" in ENGINES:
        scenario = random_scenarios.scenario(seed, **RK4)
    runs, chosen = Here(scenario), field(scenario, ENGINES)
    *others, last = chosen.engines
    chosen = replace(chosen, engines=(*others, replace(last, scheme="")))  # judged as if its scheme were unknown
    groups = compare(runs, chosen, ["qp"], named=True)
    orders = {"qp": refine(runs, chosen, "qp")}
    figures = summarise({"scenario": scenario.name}, groups, orders).figures
    (group,) = figures["groups"]
    told = [f"{row['label']}: {row['outcome']}: {row['reason']}" for row in group["engines"]]
    told += [f"{each['backend']}: order {each['order']}: {each['outcome']}" for each in group["orders"]]
    return figures["agrees"], group["problem"], told


@pytest.mark.parametrize("seed", range(COUNT))
def test_sound_engines_agree(seed):
    agrees, problem, told = verdicts(seed)
    assert agrees is True or "the judge, reference, diverged" in problem, (problem, told)
