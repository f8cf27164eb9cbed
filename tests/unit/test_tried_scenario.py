"""New scenarios for robots with elastic cables: tried before they are offered, and stable."""

from __future__ import annotations

import os

import numpy as np
import pytest
import yaml
from command_line import cdpr_here

from cdpr import load_scenario, simulate
from cdpr.scenario.template import Sizes
from cdpr.simulation.tried import tried_scenario

ROBOTS = int(os.environ.get("CDPR_TEST_CASES", "1"))  # random ones

CORNERS = [(x, y, z) for z in (2.5, 0.0) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]


def robot(stiffness=1e5, damping=6.324555, mass=10.0, radius=0.05, inertia=0.001, friction=0.0):
    """Return the plain data of a crossed robot in a frame of 4 x 3 x 2.5 m; the defaults are lightly damped."""
    cables = []
    for i, (x, y, z) in enumerate(CORNERS):
        high = i < 4
        end = [-0.2 * x, 0.15 * y, -0.1] if high else [0.2 * x, -0.15 * y, 0.1]
        cables.append({"frame": [2.0 * x, 1.5 * y, z], "platform": end})
    return {
        "name": "elastic",
        "platform": {
            "mass": mass,
            "inertia": [mass * part / 12.0 for part in (0.13, 0.2, 0.25, 0.0, 0.0, 0.0)],
            "shape": {"box": [0.4, 0.3, 0.2]},
        },
        "tension": {"min": mass, "max": 100.0 * mass},
        "home": {"position": [0, 0, 1.25]},
        "cable": {"model": "elastic", "axial_stiffness": stiffness, "damping": damping},
        "winch": {"drum_radius": radius, "inertia": inertia, "viscous_friction": friction},
        "cables": cables,
    }


def written(folder, **values):
    (folder / "robot.yaml").write_text(yaml.safe_dump(robot(**values)))
    return tried_scenario(str(folder / "s.yaml"), str(folder / "robot.yaml"), Sizes())


def longer(folder, text):
    """Run a written scenario for three times its duration."""
    scenario = load_scenario(folder / "s.yaml", text=text)
    return simulate(scenario, overrides={"simulation.duration": 3.0 * scenario.simulation.duration})


def test_a_lightly_damped_robot_gets_gains_that_are_stable(tmp_path):
    tried = written(tmp_path)
    assert tried.stable
    assert tried.note.startswith("tried: stable with kp 25, kd 10, errors up to ")
    run = longer(tmp_path, tried.text)
    assert run.summary()["position_error_m"]["max"] < 0.01  # 1.4 m with the default gains
    assert run.summary()["slack_samples"] == 0


def test_the_command_says_so(tmp_path):
    (tmp_path / "robot.yaml").write_text(yaml.safe_dump(robot()))
    done = cdpr_here("new", "scenario", "s.yaml", "--robot", "robot.yaml", cwd=tmp_path)
    assert "tried: stable with kp 25, kd 10" in done.stderr
    assert "kp: 25" in (tmp_path / "s.yaml").read_text()


def test_robots_with_ideal_cables_keep_the_defaults(tmp_path):
    tried = tried_scenario(str(tmp_path / "s.yaml"), "caroca", Sizes())
    assert (tried.note, tried.stable) == ("", True)
    assert "kp: 100.0" in tried.text


def test_random_elastic_robots_are_stable_or_said_not_to_be(tmp_path):
    rng = np.random.default_rng(int(os.environ.get("CDPR_TEST_SEED", "3")))
    stable = 0
    for _ in range(ROBOTS):
        mass, stiffness = 10 ** rng.uniform(0.5, 2.5), 10 ** rng.uniform(4.0, 6.0)
        critical = 2.0 * np.sqrt(mass * stiffness / 2.5)
        tried = written(
            tmp_path,
            stiffness=float(stiffness),
            mass=float(mass),
            damping=float(critical * 10 ** rng.uniform(-4.0, 0.0)),
            radius=float(rng.uniform(0.03, 0.1)),
            inertia=float(10 ** rng.uniform(-4.0, -2.0)),
            friction=float(rng.choice([0.0, 10 ** rng.uniform(-4.0, -1.0)])),
        )
        if not tried.stable:
            assert tried.note.startswith(("warning: no stable gains were found", "warning: these cables need physics"))
            continue
        stable += 1
        run = longer(tmp_path, tried.text)
        assert run.summary()["position_error_m"]["max"] < 0.05 * np.linalg.norm([4.0, 3.0, 2.5])
        assert run.summary()["slack_samples"] == 0
    assert stable >= 0.8 * ROBOTS


@pytest.mark.parametrize("damping", [0.0])
def test_cables_without_damping_are_told(tmp_path, damping):
    tried = written(tmp_path, damping=damping)
    assert tried.stable or "give robot.cable.damping" in tried.note


def test_trials_end_with_their_cpu_time(tmp_path, monkeypatch):
    monkeypatch.setattr("cdpr.simulation.tried.BUDGET", 0.0)
    found = written(tmp_path)
    assert not found.stable
    assert found.note.startswith("warning: not tried to the end: the trials of gains reached their limit of 0 s")
