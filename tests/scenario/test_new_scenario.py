"""New scenarios of robots with elastic cables: gains and steps are tested and stable."""

from __future__ import annotations

import os

import numpy as np
import pytest
import yaml
from command_line import cdpr_here

from cdpr import load_scenario, simulate
from cdpr.base.errors import Infeasible
from cdpr.scenario.template import Sizes, robot_text
from cdpr.simulation.linearised import decay_rate
from cdpr.simulation.loop_problems import loop_problems
from cdpr.simulation.trial_runs import scenario_with_trials
from cdpr.ui.gui.editor import Editor

ROBOTS = int(os.environ.get("CDPR_TEST_CASES", "2"))  # random ones

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
    return scenario_with_trials(str(folder / "s.yaml"), str(folder / "robot.yaml"), Sizes())


# Vibrations of less are round-off: of the highest tension limit.
RESOLVED = 1e-6
SLOW = {"stiffness": 311184.0, "mass": 13.447, "damping": 0.37406, "radius": 0.03472, "inertia": 0.000643}


def longer(folder, text, times=5.0):
    """Run a written scenario for several times its duration."""
    scenario = load_scenario(folder / "s.yaml", text=text)
    return simulate(scenario, overrides={"simulation.duration": times * scenario.simulation.duration})


def swings(run, text):
    """Return the largest swing of a tension (N) in the first and in the last quarter of the rest after the move."""
    rest = run.cable_tension[run.time > yaml.safe_load(text)["trajectory"]["duration"]]
    quarters = [float(np.ptp(part, axis=0).max()) for part in np.array_split(rest, 4)]
    return quarters[0], quarters[-1]


def test_a_lightly_damped_robot_gets_gains_that_are_stable(tmp_path):
    trial = written(tmp_path)
    assert trial.stable
    assert trial.note.startswith("tried: stable with kp 25, kd 10, errors up to ")
    run = longer(tmp_path, trial.text)
    assert run.summary()["position_error_m"]["max"] < 0.01  # 1.4 m with the default gains
    assert run.summary()["slack_samples"] == 0


@pytest.mark.slow
def test_a_vibration_that_grows_slowly_is_found(tmp_path):
    trial = written(tmp_path, **SLOW)
    controller = yaml.safe_load(trial.text)["controller"]
    assert trial.stable
    assert controller["kd"] < 1.0
    scenario = load_scenario(tmp_path / "s.yaml", text=trial.text)
    start = scenario.initial.state()[:7]
    assert decay_rate(scenario, start) > 1e-3
    slow = scenario.with_changes({"controller.kp": 0.390625, "controller.kd": 1.25})
    growth = np.log(199.0 / 3.5) / 26.0  # 1/s, of the swings of tensions in a run: 3.5 N at 12 s, 199 N at 38 s
    assert -decay_rate(slow, start) == pytest.approx(growth, rel=0.05)


@pytest.mark.slow
def test_growth_of_a_run_is_that_of_the_linearised_loop(tmp_path):
    trial = written(tmp_path, **SLOW)
    changes = {"controller.kp": 6.25, "controller.kd": 5.0, "trajectory": {"type": "hold"}}
    scenario = load_scenario(tmp_path / "s.yaml", text=trial.text).with_changes(changes)
    rate = decay_rate(scenario, scenario.initial.state()[:7])
    pushed = {"initial.velocity": [1e-4, 2e-4, 3e-4], "simulation.duration": 5.0}
    run = simulate(scenario, overrides=pushed)
    third, fifth = (np.ptp(run.cable_tension[(run.time > t) & (run.time < t + 1.0)], axis=0).max() for t in (2.0, 4.0))
    assert np.log(fifth / third) / 2.0 == pytest.approx(-rate, rel=0.1)


def test_the_command_reports_it(tmp_path):
    (tmp_path / "robot.yaml").write_text(yaml.safe_dump(robot()))
    done = cdpr_here("new", "scenario", "s.yaml", "--robot", "robot.yaml", cwd=tmp_path)
    assert "tried: stable with kp 25, kd 10" in done.stderr
    assert "kp: 25" in (tmp_path / "s.yaml").read_text()


def test_robots_with_ideal_cables_keep_the_defaults(tmp_path):
    trial = scenario_with_trials(str(tmp_path / "s.yaml"), "caroca", Sizes())
    assert (trial.note, trial.stable) == ("", True)
    assert "kp: 100.0" in trial.text


@pytest.mark.slow
def test_random_elastic_robots_are_stable_or_reported(tmp_path):
    rng = np.random.default_rng(int(os.environ.get("CDPR_TEST_SEED", "3")))
    stable = 0
    for _ in range(ROBOTS):
        mass, stiffness = 10 ** rng.uniform(0.5, 2.5), 10 ** rng.uniform(4.0, 6.0)
        critical = 2.0 * np.sqrt(mass * stiffness / 2.5)
        trial = written(
            tmp_path,
            stiffness=float(stiffness),
            mass=float(mass),
            damping=float(critical * 10 ** rng.uniform(-4.0, 0.0)),
            radius=float(rng.uniform(0.03, 0.1)),
            inertia=float(10 ** rng.uniform(-4.0, -2.0)),
            friction=float(rng.choice([0.0, 10 ** rng.uniform(-4.0, -1.0)])),
        )
        if not trial.stable:
            assert trial.note.startswith(("warning: no stable gains were found", "warning: these cables need physics"))
            continue
        stable += 1
        run = longer(tmp_path, trial.text)
        first, last = swings(run, trial.text)
        assert last <= max(first, RESOLVED * 100.0 * mass)
        assert run.summary()["position_error_m"]["max"] < 0.05 * np.linalg.norm([4.0, 3.0, 2.5])
        assert run.summary()["slack_samples"] == 0
    assert stable >= 0.8 * ROBOTS


@pytest.mark.slow
@pytest.mark.parametrize(
    ("sizes", "stiffness"),
    [((1, 20.0), 1e5), ((1, 20.0), 5e3), ((1, 20.0), 1e3), ((10, 200.0), 1e5), ((10, 200.0), 3e4), ((30, 2000.0), 3e5)],
)
def test_new_robots_with_elastic_cables_get_stable_gains(tmp_path, sizes, stiffness):
    """With the default gains, all of them vibrate with growing amplitudes."""
    scale, mass = sizes
    frame = tuple(scale * part for part in (4.0, 3.0, 2.5))
    data = yaml.safe_load(robot_text("robot.yaml", Sizes(frame=frame, mass=mass), "robot"))
    data["cable"] = {"model": "elastic", "axial_stiffness": stiffness, "damping": 6.0}
    data["winch"] = {"drum_radius": 0.05, "inertia": 0.002}
    (tmp_path / "robot.yaml").write_text(yaml.safe_dump(data))
    trial = scenario_with_trials(str(tmp_path / "s.yaml"), str(tmp_path / "robot.yaml"), Sizes())
    scenario = load_scenario(tmp_path / "s.yaml", text=trial.text)
    assert trial.stable
    assert loop_problems(scenario) == ("stable", [])
    assert longer(tmp_path, trial.text).summary()["position_error_m"]["max"] < 0.01
    known, found = loop_problems(scenario.with_changes({"controller.kp": 100.0, "controller.kd": 20.0}))
    assert known == "unstable"
    assert "it is stable with controller.kp" in found[0][1]


@pytest.mark.slow
def test_cables_without_damping_are_reported(tmp_path):
    trial = written(tmp_path, damping=0.0)
    assert not trial.stable
    assert "a vibration grows by" in trial.note
    assert "give robot.cable.damping" in trial.note


@pytest.mark.slow
def test_the_window_shows_the_note_until_the_next_edit(tmp_path):
    trial = written(tmp_path, damping=0.0)
    editor = Editor("caroca")
    editor.new("scenario", file=str(tmp_path / "s.yaml"), robot=str(tmp_path / "robot.yaml"))
    editor.apply()
    assert f"warning: {editor.form()['warnings'][0]['text']}" == trial.note
    editor.edit("controller.kp", 1.0)
    assert all(warning["text"] not in trial.note for warning in editor.form()["warnings"])


def test_a_scenario_with_ideal_cables_that_stops_is_reported(tmp_path, monkeypatch):
    def stop(scenario):
        raise Infeasible("t = 1 s: no tensions")

    monkeypatch.setattr("cdpr.simulation.trial_runs.simulate", stop)
    trial = scenario_with_trials(str(tmp_path / "s.yaml"), "caroca", Sizes())
    assert trial.note == "warning: this scenario was tried: t = 1 s: no tensions"
    assert not trial.stable


def test_trials_end_with_their_cpu_time(tmp_path, monkeypatch):
    monkeypatch.setattr("cdpr.simulation.trial_runs.BUDGET", 0.0)
    found = written(tmp_path)
    assert not found.stable
    assert found.note.startswith("warning: not tried to the end: the trials of gains reached their limit of 0 s")
