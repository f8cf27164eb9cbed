"""Design files: candidates, their figures, and messages about errors."""

from __future__ import annotations

import numpy as np
import pytest
from design_cases import BOX, ONE, TWO, design_of, write_design

import cdpr
from cdpr.analysis.design import load_design
from cdpr.analysis.design.evaluate import Value
from cdpr.analysis.workspace import box, ellipsoid, measure, region, workspace
from cdpr.base.errors import CdprError, ScenarioError

HALF = [30, 30, 30, 3, 3, 3]


def test_the_start_is_the_robot_as_it_is(tmp_path):
    design = design_of(tmp_path)
    assert design.labels == ["arm", "half width", "platform.mass"]
    assert design.start.tolist() == [0.1, 2.0, 20.0]
    assert design.bounds.tolist() == [[-0.3, 1.5, 5.0], [0.3, 2.5, 40.0]]
    assert np.array_equal(design.candidate(design.start).anchors, design.robot.anchors)
    assert design.search == "differential_evolution"
    assert design_of(tmp_path, BOX + TWO).search == "nsga2"


def test_keys_move_together(tmp_path):
    design = design_of(tmp_path)
    robot = design.candidate(np.array([0.25, 1.75, 12.0]))
    assert robot.anchors[:4, 0].tolist() == [-1.75, -1.75, 1.75, 1.75]
    assert robot.anchors[4:, 0].tolist() == [-2.0, -2.0, 2.0, 2.0]
    assert robot.anchors[:3, 5].tolist() == [0.25, 0.25, 0.1]
    assert robot.platform.mass == 12.0


def test_an_offset_and_a_start_beyond_the_bounds(tmp_path):
    text = BOX.replace(
        "{key: platform.mass, bounds: [5, 40]}",
        "{name: more, bounds: [3, 9], keys: [{key: platform.mass, factor: 2, offset: 6}]}",
    )
    design = design_of(tmp_path, text + ONE)
    assert design.start[2] == 7.0
    assert design.candidate(np.array([0.1, 2.0, 4.0])).platform.mass == 14.0
    text = BOX.replace("key: platform.mass, bounds: [5, 40]", "key: platform.mass, bounds: [25, 40]")
    assert design_of(tmp_path, text + ONE).start[2] == 25.0
    text = BOX.replace("key: platform.mass, bounds: [5, 40]", "key: cable.axial_stiffness, bounds: [1e5, 3e5]")
    assert design_of(tmp_path, text + ONE).start[2] == 2e5, "the file has none: the middle"


def test_figures_are_those_of_workspaces(tmp_path):
    text = """
region: {cells: [3, 4, 5], orientations: [{rpy_deg: [0, 0, 0]}, {rpy_deg: [0, 0, 20]}]}
vary: [{key: platform.mass, bounds: [5, 40]}]
figures:
  volume: {volume: wrench-feasible, wrench_box: [30, 30, 30, 3, 3, 3], at_least: 5}
  least: {least: wrench-feasible, wrench_ellipsoid: [30, 30, 30, 3, 3, 3], length: 0.5}
  mean: {mean: payload}
  stiff: {least: stiffness, axial_stiffness: 2.0e+5, direction: z}
  size: {extent: y}
  mass: {key: platform.mass}
  limit: {key: "tension.max"}
goal: {maximise: volume}
"""
    design = design_of(tmp_path, text)
    found = design.measure(np.array([30.0]))
    robot = cdpr.load_robot(design.robot_file, overrides={"platform.mass": 30.0})
    where = region(robot, cells=[3, 4, 5], orientations=[[1, 0, 0, 0], [np.cos(np.pi / 18), 0, 0, np.sin(np.pi / 18)]])
    asked = workspace(robot, "wrench-feasible", where, required=box(HALF), at_least=5.0)
    assert found["volume"] == Value(asked.volume)
    poses = design.place.poses
    assert poses.shape == (120, 7)
    margins = measure(robot, poses, "margin", ellipsoid(HALF), length=0.5).value
    assert found["least"] == Value(margins.min())
    payloads = measure(robot, poses, "payload").value
    known = payloads[np.isfinite(payloads)]
    assert found["mean"] == Value(known.mean(), 1.0 - len(known) / 120)
    assert found["stiff"].value is not None
    assert found["stiff"].missing > 0.0, "where the cables cannot hold the platform it has no stiffness"
    assert found["size"] == Value(3.0)
    assert (found["mass"], found["limit"]) == (Value(30.0), Value(800.0))


def test_poses_instead_of_a_region(tmp_path):
    text = """
poses: [{position: [0, 0, 1]}, {position: [0.5, 0, 1], orientation: {rpy: [0, 0, 0.1]}}]
vary: [{key: platform.mass, bounds: [5, 40]}]
figures: {margin: {least: static}}
goal: {maximise: margin}
"""
    design = design_of(tmp_path, text)
    poses = np.array([[0, 0, 1, 1, 0, 0, 0], [0.5, 0, 1, np.cos(0.05), 0, 0, np.sin(0.05)]])
    assert design.place.poses == pytest.approx(poses)
    margins = measure(design.robot, poses, "margin").value
    assert design.measure(None)["margin"].value == pytest.approx(margins.min(), rel=1e-12)


def test_obstacles_are_what_cables_must_keep_clear_of(tmp_path):
    beside = "obstacles: [{sphere: 0.1, position: [-1, -0.75, 2.25]}, {box: [0.1, 0.1, 0.1], position: [9, 9, 9]}]"
    free, blocked = (
        design_of(tmp_path, text).measure(None)["clearance"].value for text in (BOX + ONE, BOX + ONE + beside)
    )
    assert free > 0.0
    assert blocked < free


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("cells: 4", "cells: 0", r"design.yaml:3:59: region.cells"),
        (
            "lower: [-2,",
            "lower: [2,",
            r"design.yaml:3:9: region: box: x of lower, 2 m, must be below that of upper, 2 m",
        ),
        ("volume: wrench-feasible", "volume: wrench-feasable", r"5:20: figures.volume.volume: .*did you mean"),
        (
            ", wrench_box: [30, 30, 30, 3, 3, 3]",
            "",
            r"5:20: figures.volume.volume: wrench-feasible: requires a set of wren",
        ),
        (
            "{least: ifcow}",
            "{least: ifcow, wrench_box: [1, 1, 1, 1, 1, 1]}",
            r"clearance.least: ifcow: does not accept required",
        ),
        (
            "{least: ifcow}",
            "{least: static, diameter: 0.1}",
            r"figures.clearance.least: static does not accept diameter",
        ),
        (
            "{least: ifcow}",
            "{least: stiffness}",
            r"6:14: figures.clearance: cable 'cable_1' has no axial_stiffness: .*, or set the figure axial_stiff",
        ),
        (
            "{least: ifcow}",
            "{least: ifcow, extent: x}",
            r"expected one of volume, least, mean, extent, key, got least",
        ),
        ("{least: ifcow}", "{key: platform.shape}", r"6:20: figures.clearance.key: the robot file has no number there"),
        ("{least: ifcow}", "{key: platform..shape}", r"figures.clearance.key.*|a key such as"),
        ("maximise: volume", "maximise: volum", r"goal.maximise: unknown figure 'volum': did you mean 'volume'"),
        ("figure: clearance", "figure: room", r"constraints\[0\].figure: unknown figure 'room'"),
        ("cables[2].frame[0]", "cables[9].frame[0]", r"14:15: cables: there is no item \[9\]"),
        ("key: platform.mass", "key: platform.mas", r"17:11: platform.mas: unknown key 'mas': did you mean 'mass'"),
        (
            "key: platform.mass",
            'key: "cables[2].frame[0]"',
            r"17:11: vary\[2\].key: cables\[2\].frame\[0\] is set twice",
        ),
        ("bounds: [5, 40]", "bounds: [40, 5]", r"17:5: vary\[2\]: bounds: the lowest value, 40, must be below 5"),
        ("name: half width", "name: volume", r"two variables or figures are named 'volume'"),
        ("name: half width", "name: goal", r"cannot be named goal: the table already has this column"),
        ("goal: {maximise: volume}", "goal: {}", r"goal: expected one of maximise and minimise"),
        ("goal: {maximise: volume}", "", r"expected one of goal and goals"),
        ("evaluations: 40", "evaluations: 0", r"optimizer.evaluations"),
        ("evaluations: 40", "type: ant_colony", r"optimizer.type"),
        ("robot: ", "robot: no/", r"design.yaml:1:8: robot: "),
    ],
)
def test_mistakes_are_reported_at_their_position(tmp_path, old, new, message):
    path = write_design(tmp_path)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(ScenarioError, match=message):
        load_design(path)


def test_several_goals_want_another_search(tmp_path):
    for kind in ("differential_evolution", "cma"):
        with pytest.raises(
            ScenarioError, match=rf"optimizer.type: {kind} supports one goal; nsga2 and random support several"
        ):
            design_of(tmp_path, BOX + TWO, f"type: {kind}")


def test_a_volume_wants_a_region(tmp_path):
    text = BOX.replace(BOX.splitlines()[1], "poses: [{position: [0, 0, 1]}]")
    with pytest.raises(ScenarioError, match=r"figures.volume.volume: a volume requires a region, not poses"):
        design_of(tmp_path, text + ONE)


def test_a_number_of_evaluations(tmp_path):
    path = write_design(tmp_path)
    assert load_design(path, evaluations=7).section.optimizer.evaluations == 7
    with pytest.raises(CdprError, match="evaluations: expected a whole number from 1 to"):
        load_design(path, evaluations=0)


def test_a_clearance_requires_a_diameter(tmp_path):
    design = {
        "robot": "caroca",
        "goal": {"maximise": "clearance"},
        "poses": [{"position": [0, 0, 1.2]}],
        "vary": [{"key": "platform.mass", "bounds": [100, 200]}],
        "figures": {"clearance": {"least": "ifcow"}},
    }
    with pytest.raises(CdprError, match=r"cable_1' has no diameter: give .*, or the figure its diameter \(m\)"):
        cdpr.design(design, tmp_path / "without", evaluations=1)
    design["figures"]["clearance"]["diameter"] = 0.01
    assert len(cdpr.design(design, tmp_path / "with", evaluations=1).rows) == 2
