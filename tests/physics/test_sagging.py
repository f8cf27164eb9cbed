"""Runs of a robot on heavy cables: forces, energy, engines, batches, snapshots and exported FMUs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from conftest import ROOT
from plants import installed
from scipy.spatial.transform import Rotation

import cdpr
from cdpr.base.errors import CdprError, ScenarioError, SimulationStopped
from cdpr.fmu.export import Actuator
from cdpr.mechanics.kinematics import wrench_matrix
from cdpr.mechanics.sag import curves, least_tensions, too_loose
from cdpr.native.bind import bind
from cdpr.plugins.registry import registry
from cdpr.scenario import load_any, load_scenario

SAGGING = ROOT / "scenarios" / "sagging.yaml"
SHORT = {"simulation.duration": 0.1, "initial.velocity": [0.3, -0.2, 0.1]}
# Pulleys and a centre of mass off the origin.
PULLEYS = {"robot.cable.exit": {"type": "pulley", "radius": 0.05}, "robot.platform.center_of_mass": [0.1, 0.05, 0.3]}
HEAVY = {"robot.cable.linear_density": 8.0}  # kg/m: then a cable needs more than tension.min


@pytest.fixture(scope="module")
def short():
    return cdpr.simulate(SAGGING, backend="reference", overrides={**SHORT, **PULLEYS})


def end_forces(robot, state, unwound, gravity):
    """Return anchors on the platform (m, 3) and forces there, by the kernel of single cables."""
    from cdpr.cables.tables import chain_table, exits, line_table

    tips = state[:3] + robot.anchors[:, 3:] @ Rotation.from_quat(state[3:7], scalar_first=True).as_matrix().T
    leaving, _, wrapped = exits(line_table(robot), tips)
    force, tension = np.zeros((robot.m, 3)), np.zeros(robot.m)
    ends = {"chord": leaving - tips, "exit_to_anchor": robot.anchors[:, :3] - leaving, "wrapped_length": wrapped}
    rows = chain_table(robot).copy()
    rows[:, 13] = 0.0  # damping
    given = {"chains": rows, "gravity": np.array(gravity), "unwound": unwound, "stretching": np.zeros(robot.m)}
    bind("bent_cables", **given, **ends, force=force, tension=tension)()
    return tips, force, tension


def test_the_wrench_is_that_of_the_cables_ends(short):
    """`bending_wrench` is what the forces at the platform's end exceed W t by; about half of the cables' weight."""
    overrides = {**SHORT, **PULLEYS, "robot.cable.damping": 0.0}
    run = cdpr.simulate(SAGGING, backend="reference", overrides=overrides)
    scenario = load_scenario(SAGGING, overrides=overrides)
    for k in (0, 57, 100):
        state = np.concatenate([run.position[k], run.orientation[k], np.zeros(6)])
        tips, force, tension = end_forces(scenario.robot, state, run["unstretched_length"][k], scenario.gravity)
        np.testing.assert_allclose(tension, run.cable_tension[k], rtol=1e-9)
        whole = np.concatenate([force.sum(axis=0), np.cross(tips - run.position[k], force).sum(axis=0)])
        along = wrench_matrix(scenario.robot, state) @ tension
        np.testing.assert_allclose(run["bending_wrench"][k], whole - along, atol=1e-7)
    weight = 0.256 * 9.81 * run["unstretched_length"][0].sum()
    down = -run["bending_wrench"][:, 2]
    assert (0.3 * weight < down).all()
    assert (down < 0.7 * weight).all()


def test_energy_balances(short):
    """The work of the cables is that of their forces, not only of the tensions along their chords."""
    gained = short.kinetic + short.potential - short.cable_work
    turned = np.abs(np.diff(short.kinetic)).sum() + np.abs(np.diff(short.potential)).sum()
    assert np.ptp(gained) < 1e-6 * turned


def test_cases_of_a_batch_have_the_bits_of_runs():
    masses = np.linspace(85.0, 95.0, 8)
    found = cdpr.rollout(
        SAGGING, 8, vary={"robot.platform.mass": masses}, overrides=SHORT, columns=("position", "unstretched_length")
    )
    for k in (0, 7):
        run = cdpr.simulate(SAGGING, backend="reference", overrides={**SHORT, "robot.platform.mass": masses[k]})
        assert np.array_equal(found.position[k], run.position)
        assert np.array_equal(found["unstretched_length"][k], run["unstretched_length"])


def test_the_true_wrench_of_a_robot_with_another_nominal_model():
    believed = {"believed": {"platform": {"mass": 95.0}}}
    run = cdpr.simulate(SAGGING, backend="reference", overrides={**SHORT, **believed})
    robot = load_scenario(SAGGING).robot
    for k in (0, 100):
        state = np.concatenate([run.position[k], run.orientation[k], np.zeros(6)])
        along = wrench_matrix(robot, state) @ run.cable_tension[k]
        np.testing.assert_allclose(run.true_wrench[k], along + run["bending_wrench"][k], atol=1e-9)


def test_a_start_below_the_least_tension_names_the_cable_and_the_remedy():
    rows = []
    load_any(SAGGING, overrides=HEAVY, warnings=rows)
    (warning,) = [str(row) for row in rows if "too low for the weight" in str(row)]
    assert "cable 'cable_5' (and 7 more cables)" in warning
    assert "raise tension.min" in warning
    with pytest.raises(SimulationStopped, match=r"cable 'cable_\d' \(and \d more\): .* N cannot carry its weight"):
        cdpr.simulate(SAGGING, backend="reference", overrides={**HEAVY, **SHORT})


def test_least_tensions_of_a_robot():
    scenario = load_scenario(SAGGING)
    pose = scenario.initial.state()[None, :7]
    given = scenario.robot, pose[:, :3], pose[:, 3:], scenario.gravity
    least = least_tensions(*given)
    assert least.shape == (1, 8)
    assert (least > 10.0).all()
    light = load_scenario(SAGGING, overrides={"robot.cable.model": "elastic"}).robot
    assert not least_tensions(light, *given[1:]).any()
    about = scenario.robot, pose[0, :3], pose[0, 3:], scenario.gravity
    assert too_loose(*about, least[0]) == ""
    assert "cable_5" in too_loose(*about, least[0] - 0.1)
    assert too_loose(light, *about[1:], np.zeros(8)) == ""


def test_curves_of_a_run(short):
    scenario = load_scenario(SAGGING, overrides=PULLEYS)
    lines = curves(
        scenario.robot, short.position[50], short.orientation[50], short["unstretched_length"][50], scenario.gravity, 21
    )
    assert list(lines) == list(range(8))
    for points in lines.values():
        straight = points[0] + np.linspace(0.0, 1.0, 21)[:, None] * (points[-1] - points[0])
        assert (points[1:-1, 2] < straight[1:-1, 2]).all()
        assert 1e-3 < np.abs(points - straight).max() < 0.5


def test_results_along_chords_are_marked(short):
    from cdpr.analysis.sizing import Duty, sizing
    from cdpr.analysis.workspace.answers import notes
    from cdpr.analysis.workspace.question import Question
    from cdpr.ui.report.pages.run import render

    scenario = load_scenario(SAGGING, overrides=SHORT)
    light = load_scenario(SAGGING, overrides={**SHORT, "robot.cable.model": "elastic"})
    for one, sags in ((scenario, True), (light, False)):
        assert ("use the chords" in " ".join(notes(one.robot, Question(), bodies=False))) is sags
        assert ("sag" in sizing([Duty.of_scenario(one, "one")]).to_dict()) is sags
    old = replace(short, header=replace(short.header, spans=()))
    for run, straight in ((short, False), (old, True)):
        assert ("Cables that sag are drawn as straight lines" in render(run)) is straight


def test_uses_that_reject_heavy_cables():
    """Legs push; winches alone know no direction of a chord."""
    with pytest.raises(ScenarioError, match="rigid legs push, and cables of the model catenary cannot"):
        load_scenario(SAGGING, overrides={"robot.unilateral": False})
    with pytest.raises(CdprError, match="has model catenary: it sags"):
        Actuator(load_scenario(SAGGING).robot, 1e-3).variables()


@pytest.mark.slow
def test_engines_agree():
    found = cdpr.compare(SAGGING, overrides={**SHORT, **PULLEYS}, backends=installed("mujoco", "bullet", "dart"))
    assert found.figures["agrees"] is True


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes", [{}, PULLEYS, {"robot.cables[2].model": "rigid"}], ids=["points", "pulleys", "mixed"]
)
def test_an_exported_plant_moves_as_reference_does(changes, tmp_path):
    from fmu.cases import plant_of, write
    from fmu.driver import Driver

    scenario = load_scenario(SAGGING, overrides={**SHORT, **changes})
    backend = registry().get("backend", "reference").make(scenario.robot, scenario.gravity, 1e-3, None)
    backend.reset(scenario.initial.state())
    command = 350.0 + 40.0 * np.sin(np.arange(8.0))
    backend.command[:] = command
    with Driver(write(plant_of(scenario), 3, tmp_path)) as driver:
        driver.set("command", command)
        before = driver.get("velocity"), driver.get("angular_velocity")
        slopes = driver.get("acceleration"), driver.get("angular_acceleration")
        for k in range(100):
            driver.step(1e-3 * k, 1e-3)
            backend.step(1)
            assert np.abs(driver.state() - backend.state).max() < 1e-12  # principal axes differ by round-off
            if k == 0:
                for was, slope, name in zip(before, slopes, ("velocity", "angular_velocity"), strict=True):
                    np.testing.assert_allclose((driver.get(name) - was) / 1e-3, slope, rtol=0.05, atol=0.05)
        assert np.ptp(driver.get("cable_tension")) > 10.0


def test_clearances_of_runs_follow_the_curves():
    """At the end of the motion, two ropes are about 2 cm nearer than their chords."""
    from cdpr.mechanics.clearance import clearance

    brief = {"simulation.duration": 1.6, "trajectory.duration": 1.5, "simulation.control_step": 0.002}
    scenario = load_scenario(SAGGING)
    run = cdpr.simulate(SAGGING, backend="reference", overrides=brief)
    poses = np.concatenate([run.position, run.orientation], axis=1)
    among = clearance(scenario.robot, scenario.obstacles, gravity=scenario.gravity)
    curved, _ = among.at(poses, unwound=run["unstretched_length"])
    straight, _ = among.at(poses)
    assert run.summary()["clearance_min_m"] == curved.min()
    assert curved.min() < straight.min() - 0.015
    edge = float(0.5 * (curved.min() + straight.min()))
    first = int(np.argmax(curved <= edge))
    contact = {"type": "contact", "clearance": edge}
    watched = cdpr.simulate(SAGGING, backend="reference", overrides={**brief, "events": [contact]})
    (event,) = [event for event in watched.events if event.kind == "contact"]
    assert event.time == run.time[first]
    with pytest.raises(SimulationStopped, match=r"the least clearance is 0\.\d+ m, of cable_2 and cable_4") as stop:
        cdpr.simulate(SAGGING, backend="reference", overrides={**brief, "events": [{**contact, "then": "stop"}]})
    assert len(stop.value.run.time) == first + 1


def test_clearances_and_stiffness_without_a_run():
    """Curves at the static tensions; straight cables, with a remark, where these do not carry the cables."""
    from cdpr.ui.report.view import analysed

    def least(density, model="catenary"):
        coarse = {"simulation.control_step": 0.05}
        changes = {**coarse, "robot.cable.linear_density": density, "robot.cable.model": model}
        scenario = load_scenario(SAGGING, overrides=changes)
        figures, *_ = analysed(scenario, scenario.gravity, scenario.initial.state()[:7], "initial")
        return figures["pose"], figures["motion"]["least"]

    _, straight = least(0.256, "elastic")
    pose, motion = least(0.256)
    assert motion["clearance"]["value"] < straight["clearance"]["value"] - 0.015
    assert motion["clearance"]["by"] == "cable_2 and cable_4"
    pose, motion = least(6.0)
    remark = ", with straight cables, as no tensions hold the platform"
    assert motion["clearance"]["value"] == straight["clearance"]["value"]
    assert motion["clearance"]["by"] == "cable_2 and cable_4" + remark
    assert pose["clearance_by"].endswith(remark)
    assert "stiffness" not in motion
