"""Controller and solver inside an FMU: the loop is that of `cdpr run` on `reference`."""

from __future__ import annotations

import sys

import fmpy
import numpy as np
import pytest
from conftest import ROOT
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu
from fmu.cases import ELASTIC, FMI, RIGID
from fmu.driver import Driver
from spread import spread

from cdpr import load_scenario, simulate
from cdpr.fmu.export import Controller, Plant, fmu_bytes
from cdpr.fmu.export.control import DESIRED
from cdpr.fmu.read.archive import open_archive
from cdpr.plugins.registry import registry
from cdpr.simulation.exported import control_of
from cdpr.ui.cli import main

# m, rad, m/s, rad/s, and 1e3 N of tensions. Body frames whose origins are not the platform's bring last bits, which
# the loop keeps small; elsewhere there is no difference.
CLOSED = 1e-11

HELD = ["solver.type=closed_form", "solver.infeasible=hold_tension"]
PID = ["controller={type: pid, kp: 100, kd: 20, ki: 50}"]
CASES = {
    "qp": ("caroca", []),  # the default controller and solver
    "planar qp": ("planar", []),
    "planar pid": ("planar", PID),  # that of quick tests, so that they compile one library
    "caroca": ("caroca", [*HELD, "controller.type=computed_torque"]),  # beyond what the closed form answers, too
    "pid": ("caroca", [*HELD, *PID]),
    "static": ("cogiro", [*HELD, "controller.type=static"]),
    "planar": ("planar", HELD),
    "forces alone": ("caroca", [*HELD, "controlled=[x, y, z]"]),
    "clipped": ("caroca", ["solver.type=pseudo_inverse", "robot.tension.min=600"]),
    "pulleys": ("cogiro_pulleys", ["solver.type=pseudo_inverse"]),
    "elastic": ("cogiro", [*HELD, *ELASTIC]),
    "rigid": ("cogiro", [*HELD, *RIGID]),
    "planar stop": ("planar", ["solver.infeasible=stop"]),
    "cable_length": ("planar", ["controller.type=cable_length"]),
    "slower": ("caroca", [*HELD, *PID, "simulation.control_step=0.004"]),
}
DURATION = 1.0  # s


def scenario(case):
    name, changes = CASES[case]
    changes = [*changes, f"simulation.duration={DURATION}"]
    return load_scenario(ROOT / "scenarios" / f"{name}.yaml", overrides=changes)


def closed(loaded):
    winches = loaded.robot.cable_model != "ideal"
    gravity, step = np.array(loaded.world.gravity), loaded.simulation.physics_step
    return Plant(loaded.robot, gravity, step, loaded.initial.state(), winches, control_of(loaded))


def write(model, fmi, folder, name="closed"):
    path = folder / f"{name}{fmi}.fmu"
    path.write_bytes(fmu_bytes(model, fmi))
    return path


def desire(driver, run, k):
    names = ["position", "orientation", "velocity", "angular_velocity", "acceleration", "angular_acceleration"]
    for (name, *_), column in zip(DESIRED, names, strict=True):
        driver.set(name, run[f"desired_{column}"][k])


def states(run):
    return np.concatenate([run[each] for each in ("position", "orientation", "velocity", "angular_velocity")], axis=1)


# Not exported: they wrap libraries or other programs, compute in rational numbers, or use measurements.
WITHOUT = {"exact", "fmu", "remote", "qpsolvers", "tension_feedback", "visual_servo"}


def exportable(role):
    rows = [registry().get(role, name).info for name in registry().names(role)]
    return [row.name for row in rows if not row.requires and row.name not in WITHOUT]


def follow(loaded, fmi, tmp_path):
    """Return the run of a scenario, and by how much the FMU in its place differs at most."""
    run, step = simulate(loaded), loaded.simulation.control_step
    path = write(closed(loaded), fmi, tmp_path)
    assert validate_fmu(str(path)) == []
    expected, worst = states(run), 0.0
    pull = "command" if loaded.robot.cable_model != "ideal" else "cable_tension"
    tension = run["tension"]  # of winches, their commands
    with Driver(path) as driver:
        for k in range(len(expected) - 1):
            desire(driver, run, k)
            driver.step(k * step, step)
            worst = max(worst, np.abs(driver.state() - expected[k + 1]).max())
            worst = max(worst, np.abs(driver.get(pull) - tension[k]).max() / 1e3)
    return run, worst


@spread("case, fmi", list(CASES), [2, 3])
@pytest.mark.usual("planar pid-3")
def test_plant_and_controller_in_one_run_as_cdpr_does(case, fmi, tmp_path):
    run, worst = follow(scenario(case), fmi, tmp_path)
    assert worst < CLOSED
    assert np.ptp(states(run), axis=0).max() > 0.01
    if case in ("caroca", "clipped"):
        assert (run["status"] != 0).any()  # the policy is at work, too


@pytest.mark.slow
@pytest.mark.parametrize("robot", ["caroca", "planar"])
@pytest.mark.parametrize(
    ("role", "name"), [(role, name) for role in ("controller", "solver") for name in exportable(role)]
)
def test_every_controller_and_solver_runs_as_in_cdpr(role, name, robot, tmp_path):
    """With all that its own options need; unless the robot has too many or too few cables for it."""
    changes = [f"{role}.type={name}", "simulation.duration=0.2"]
    loaded = load_scenario(ROOT / "scenarios" / f"{robot}.yaml", overrides=changes)
    run, worst = follow(loaded, 3, tmp_path)
    assert worst < CLOSED
    assert np.isfinite(run["tension"]).all()


@pytest.mark.slow
@pytest.mark.parametrize("policy", ["best_effort", "hold_tension"])
@pytest.mark.parametrize("name", ["qp", "closed_form", "pseudo_inverse"])
def test_policies_act_as_in_cdpr(name, policy, tmp_path):
    """Motion with a temporarily infeasible wrench."""
    changes = [f"solver={{type: {name}, infeasible: {policy}}}", "simulation.duration=0.2", "robot.tension.max=150"]
    loaded = load_scenario(ROOT / "scenarios" / "caroca.yaml", overrides=changes)
    run, worst = follow(loaded, 3, tmp_path)
    assert worst < CLOSED
    assert (run["status"] != 0).any()


@pytest.mark.slow
def test_the_host_may_step_as_it_likes(tmp_path):
    """It decides once in each control step: many short steps, or one long, are the same as long as desires are."""
    path = write(closed(scenario("slower")), 3, tmp_path)
    ends = []
    for steps, duration in ((8, 0.004), (32, 0.001), (2, 0.016), (1, 0.032)):
        with Driver(path) as driver:
            start = driver.state()
            driver.set("desired_position", [start[0] + 0.05, *start[1:3]])  # so that each decision is another
            for k in range(steps):
                driver.step(k * duration, duration)
            ends.append(np.concatenate([driver.state(), driver.get("cable_tension")]))
    for end in ends[1:]:
        assert np.allclose(end, ends[0], rtol=1e-12, atol=1e-14)
    assert ends[0][13:].min() > 0.0
    assert ends[0][0] > start[0] + 1e-4


@pytest.mark.slow
@FMI
def test_saved_and_reset_it_continues_to_the_bit(fmi, tmp_path):
    loaded = scenario("planar pid")
    run, step = simulate(loaded, overrides=None), loaded.simulation.control_step
    with Driver(write(closed(loaded), fmi, tmp_path)) as driver:

        def go(first, last):
            for k in range(first, last):
                desire(driver, run, k)
                driver.step(k * step, step)
            return np.concatenate([driver.state(), driver.get("cable_tension")])

        go(0, 30)
        saved = driver.save()
        end = go(30, 60)
        driver.restore(saved)
        assert (go(30, 60) == end).all()
        driver.fmu.reset()
        driver.initialise({}, {})
        assert (go(0, 60) == end).all()


@FMI
@pytest.mark.slow
def test_a_controller_alone_drives_cdpr_like_the_one_it_is(fmi, tmp_path):
    """It is what `controller: {type: fmu}` takes."""
    loaded = scenario("planar pid")
    path = write(Controller(control_of(loaded)), fmi, tmp_path, "controller")
    assert validate_fmu(str(path)) == []
    ours = simulate(loaded)
    given = {"type": "fmu", "file": str(path), "sha256": open_archive(path).sha256}
    changes = {"simulation.duration": DURATION, "controller": given}
    theirs = simulate(ROOT / "scenarios" / "planar.yaml", overrides=changes)
    assert np.abs(states(theirs) - states(ours)).max() < CLOSED
    assert (ours["status"] == 0).any()


def test_gains_are_tunable(tmp_path):
    with Driver(write(closed(scenario("planar pid")), 3, tmp_path)) as driver:
        start = driver.state()
        driver.set("desired_position", [start[0] + 0.05, *start[1:3]])
        driver.step(0.0, 0.01)
        before = driver.get("cable_tension")
        driver.set("controller.kp", driver.get("controller.kp") * 2.0)
        driver.step(0.01, 0.01)
        assert np.abs(driver.get("cable_tension") - before).max() > 1.0
        with pytest.raises(FMICallException):
            driver.set("cable_tension", np.zeros(4))  # it is decided inside


@pytest.mark.slow  # another policy is another library to compile
def test_policy_stop_after_a_failure(tmp_path, capfd):
    with Driver(write(closed(scenario("planar stop")), 3, tmp_path)) as driver:
        driver.set("desired_acceleration", [500.0, 0.0, 0.0])
        with pytest.raises(FMICallException):
            driver.step(0.0, 0.001)
    assert "exported with solver.infeasible hold_tension or best_effort" in capfd.readouterr().out


def test_policy_best_effort_after_a_failure(tmp_path, capfd):
    """It continues with the tensions nearest to the wrench, and warns once."""
    with Driver(write(closed(scenario("planar pid")), 3, tmp_path)) as driver:
        driver.step(0.0, 0.001)
        driver.set("desired_position", [1e6, 0.0, 0.0])
        for k in range(1, 4):
            driver.step(k * 0.001, 0.001)
        assert capfd.readouterr().out.count("no tensions within the limits") == 1
        driver.set("desired_position", [np.nan, 0.0, 0.0])
        with pytest.raises(FMICallException):
            driver.step(0.004, 0.001)
    assert "not finite" in capfd.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["caroca.yaml", "--controller", "--set", "solver.type=osqp"], "the solver 'osqp' has no compiled operation"),
        (["caroca.yaml", "--with-controller", "--set", "solver.type=exact"], "(--set solver.type=NAME)"),
        (["robots/caroca.yaml", "--controller"], "a controller is that of a scenario"),
        (["caroca.yaml", "--controller", "--with-winch"], "exports only a controller"),
        (["caroca.yaml", "--with-controller", "--only-winch"], "requires a plant"),
        (["believed.yaml", "--controller"], "believed"),
        (["winch_fmu.yaml", "--with-controller"], "actuators"),
    ],
)
def test_unsupported_exports_are_reported(arguments, said, tmp_path, monkeypatch, capsys):
    file, *rest = arguments
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    command = ["cdpr", "fmu", "export", str(ROOT / "scenarios" / file), "-o", str(tmp_path / "a.fmu"), *rest]
    monkeypatch.setattr(sys, "argv", command)
    with pytest.raises(SystemExit) as left:
        main()
    assert left.value.code == 2
    assert said in " ".join(capsys.readouterr().err.split())
    assert not (tmp_path / "a.fmu").exists()


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("spherical", "left out: events: not exported (wrench at 1.6 s)"),
        ("spherical", "left out: trajectory: the desired motion is an input of the FMU"),
        ("winch", "exported without --with-winch"),
    ],
)
def test_remaining_files_are_reported(name, said, tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    file = str(ROOT / "scenarios" / f"{name}.yaml")
    options = ["--with-controller", "--source-only", "--set", "solver.type=closed_form"]
    monkeypatch.setattr(sys, "argv", ["cdpr", "fmu", "export", file, "-o", str(tmp_path / "a.fmu"), *options])
    with pytest.raises(SystemExit) as left:
        main()
    assert left.value.code == 0
    assert said in capsys.readouterr().err


def test_its_terminals_and_dependencies(tmp_path):
    about = fmpy.read_model_description(str(write(closed(scenario("planar pid")), 3, tmp_path)))
    at_once = {unknown.variable.name: {v.name for v in unknown.dependencies} for unknown in about.outputs}
    assert at_once["cable_tension"] == set()  # held from decision to decision
    assert at_once["acceleration"] == {"external_force", "external_moment"}
    assert not about.coSimulation.providesDirectionalDerivative
    opened = open_archive(write(Controller(control_of(scenario("planar pid"))), 3, tmp_path, "alone"))
    assert set().union(*(set(each) for each in opened.description.terminals)) >= {
        "desired_position",
        "position",
        "command",
    }
