"""Results of robots that differ only in size and force: dimensionless results are equal."""

from __future__ import annotations

import json

import numpy as np
import pytest
from command_line import cdpr_here

import cdpr
from cdpr.tension.status import Status
from cdpr_solvers.closed_form import closed_form_tension

SAME = 1e-9  # relative: round-off of a few thousand operations
TENSION = (10.0, 900.0)  # N


def written(path, length, force):
    """Write a robot of 4 m and 20 kg, scaled."""
    cables = [
        {"frame": [2.0 * a, 1.5 * b, 1.25 + 1.25 * c], "platform": [-0.2 * a, 0.15 * b * c, -0.1 * c]}
        for c in (1, -1)
        for a in (-1, 1)
        for b in (-1, 1)
    ]
    for cable in cables:
        for key, place in cable.items():
            cable[key] = [length * x for x in place]
    inertia = [0.2, 0.3, 0.4, 0, 0, 0]
    data = {
        "platform": {"mass": 20 * force, "inertia": [length**2 * force * x for x in inertia]},
        "tension": {"min": TENSION[0] * force, "max": TENSION[1] * force},
        "home": {"position": [0, 0, 1.25 * length]},
        "cables": cables,
    }
    path.write_text(json.dumps(data))
    return cdpr.load_robot(path)


@pytest.mark.parametrize(
    "solver", ["qp", *(pytest.param(name, marks=pytest.mark.slow) for name in ("lp", "exact", "closed_form"))]
)
@pytest.mark.parametrize(("length", "force"), [(2.5e-4, 1e-8), (250.0, 1e5)], ids=["1 mm, 1e-7 N", "1 km, 1e8 N"])
def test_tensions_are_in_proportion(tmp_path, length, force, solver):
    pose = "--pose={},{},{}"
    told = []
    for name, size, pull in (("one", 1.0, 1.0), ("other", length, force)):
        written(tmp_path / f"{name}.yaml", size, pull)
        at = pose.format(0.1 * size, -0.2 * size, 1.4 * size)
        done = cdpr_here("tension", tmp_path / f"{name}.yaml", "--solver", solver, at, "--json")
        told.append((json.loads(done.stdout), pull))
    (one, _), (other, pull) = told
    assert one["solvers"][0]["status"] == other["solvers"][0]["status"] == "OK"
    first, second = (np.array(each["solvers"][0]["tension_N"]) for each in (one, other))
    assert np.abs(second / pull - first).max() < SAME * TENSION[1]


@pytest.mark.parametrize("force", [1.0, 2.0**17])
def test_a_tension_is_moved_onto_its_limit_at_any_force(force):
    W, low, high = np.array([[1.0, -1.0]]), np.full(2, 10.0 * force), np.full(2, 1000.0 * force)
    for beyond, status in ((5e-11, Status.OK), (5e-10, Status.INFEASIBLE)):  # shares of the tensions
        tension = force * np.array([1000.0 * (1.0 + beyond), 1000.0])
        low[1] = high[1] = tension[1]  # locked, so that the other one is determined
        assert closed_form_tension(W, W @ tension, low, high)[1] == status


def test_limits_below_a_newton_are_no_hindrance(tmp_path):
    written(tmp_path / "small.yaml", 1.0, 1e-3)
    shown = cdpr_here("tension", tmp_path / "small.yaml").stdout
    assert "0.01 to 0.9 N, all cables" in shown
    assert "feasible             yes" in shown


def test_a_diameter_of_ideal_cables_counts_as_used(tmp_path):
    robot = tmp_path / "robot.yaml"
    written(robot, 1.0, 1.0)
    robot.write_text(json.dumps({**json.loads(robot.read_text()), "cable": {"diameter": 0.006}}))
    done = cdpr_here("validate", robot)
    assert "not used" not in done.stderr + done.stdout
    said = cdpr_here("info", robot)
    assert "not used" not in said.stderr + said.stdout
    assert "assumed cable diameter" not in said.stderr + said.stdout
    assert "clearance" in said.stdout
