"""Kinds of workspaces beside those of what cables can exert; thresholds, obstacles, workspaces made of two."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest
from workspace_cases import ROBOTS, cli, robot_of

from cdpr import load_scenario
from cdpr.analysis.workspace.combine import combine
from cdpr.analysis.workspace.kinds import KINDS
from cdpr.analysis.workspace.regions import region
from cdpr.analysis.workspace.required import box
from cdpr.analysis.workspace.result import FORMAT, load_workspace, verdicts, workspace
from cdpr.base.errors import CdprError, LogError
from cdpr.mechanics.clearance import clearance
from cdpr.ui.cli import workspace_compare

CAROCA = ROBOTS / "caroca.yaml"
ASKED = {
    "wrench-feasible": {"required": box([50, 50, 50, 5, 5, 5])},
    "dynamic": {"required": box([1, 1, 1, 0, 0, 0], accelerations=True)},
    "ifcow": {"diameter": 0.01},
    "stiffness": {"axial_stiffness": 1e5},
    "frequency": {"axial_stiffness": 1e5},
}


def middles(found):
    """Poses (K, 7) of all cells, in the first attitude."""
    here = found.region
    turned = np.repeat(here.orientations[:1], here.cells, axis=0)
    return np.concatenate([here.positions(np.arange(here.cells)), turned], axis=1)


@pytest.mark.parametrize("kind", KINDS)
def test_all_kinds_are_stored_and_evaluated_again(tmp_path, kind):
    robot = robot_of("caroca")
    found = workspace(robot, kind, region(robot, cells=6), **ASKED.get(kind, {}))
    found.save(tmp_path / "w.npz")
    again = load_workspace(tmp_path / "w.npz")
    assert again.summary() == found.summary()
    assert json.dumps(again.summary(), allow_nan=False)
    inside, value, _ = verdicts(again, robot, middles(again))
    assert np.array_equal(inside, found.inside.ravel())
    assert np.array_equal(value, found.value.ravel(), equal_nan=True)


@pytest.mark.parametrize(
    ("kind", "level"), [("static", 300.0), ("frequency", 2.0), ("ifcow", 0.11), ("dexterity", 0.2)]
)
def test_inside_is_from_a_value_on(kind, level):
    robot = robot_of("caroca")
    found = workspace(robot, kind, region(robot, cells=8), at_least=level, **ASKED.get(kind, {}))
    with np.errstate(invalid="ignore"):
        assert np.array_equal(found.inside, found.value >= level)
    assert 0 < found.inside.sum() < found.inside.size
    assert found.summary()["at_least"] == level


def test_the_limiting_direction_has_the_smallest_margin():
    """If only an upward force is too large, the direction is upward."""
    robot = robot_of("planar_point_mass")
    strong = workspace(robot, "wrench-feasible", region(robot, cells=12), required=box([0, 0, 400, 0, 0, 0]))
    told = strong.summary()["outside_by"]
    assert sum(told.values()) == (~strong.inside).sum()
    assert max(told, key=told.get) in ("+z", "-z")


def test_blocking_files_are_named():
    robot = robot_of("caroca")
    found = workspace(robot, "ifcow", region(robot, cells=10), diameter=0.01)
    among = clearance(robot, diameter=0.01)
    values, which = among.at(middles(found))
    assert np.array_equal(found.value.ravel(), values)
    outside = [among.name(number) for number in which[values <= 0.0].tolist()]
    assert found.summary()["outside_by"] == {name: outside.count(name) for name in set(outside)}
    (note,) = found.summary()["notes"]
    assert note.startswith("share an anchor, so their other ends count: cable_1 and cable_2, ")


def test_too_few_cables_are_named_as_the_reason():
    robot = robot_of("caroca")
    few = dataclasses.replace(robot, cables=robot.cables[:5])
    (note,) = workspace(few, "static", region(few, cells=3)).summary()["notes"]
    assert note == "5 cables for 6 degrees of freedom: the wrench matrix is rank-deficient at every pose"
    assert workspace(robot, "static", region(robot, cells=3)).summary()["notes"] == []


def test_obstacles_of_a_scenario_are_in_the_way(tmp_path):
    (tmp_path / "caroca.yaml").write_text(CAROCA.read_text())
    (tmp_path / "s.yaml").write_text(
        """robot: caroca.yaml
simulation: {duration: 0.1}
world:
  obstacles:
  - {name: pillar, cylinder: {radius: 0.3, height: 3.5}, position: [1.5, 0.5, 1.75]}
  - {box: [0.5, 0.5, 0.5], position: [-1, -1, 3], orientation: {rpy_deg: [0, 0, 30]}}
  - {sphere: 0.2, position: [0, 1, 2]}
"""
    )
    loaded = load_scenario(tmp_path / "s.yaml")
    assert [each.name for each in loaded.obstacles] == ["pillar", "obstacle 2", "obstacle 3"]
    done = cli("workspace", "ifcow", tmp_path / "s.yaml", "--cable-diameter", "0.01", "--cells", "8", "--json")
    told = json.loads(done.stdout)
    free = workspace(loaded.robot, "ifcow", region(loaded.robot, cells=8), diameter=0.01)
    assert told["volume"] < free.volume
    assert any(name.endswith("and pillar") for name in told["outside_by"])
    done = cli(
        "workspace",
        "ifcow",
        tmp_path / "s.yaml",
        "--cable-diameter",
        "0.01",
        "--cells",
        "8",
        "--out",
        tmp_path / "i.npz",
    )
    kept = load_workspace(tmp_path / "i.npz")
    inside, value, _ = verdicts(kept, loaded.robot, middles(kept))
    assert np.array_equal(inside, kept.inside.ravel())
    assert np.array_equal(value, kept.value.ravel())


@pytest.mark.parametrize(
    ("obstacle", "said"),
    [
        ("{sphere: 0.2}", "position"),
        (
            "{sphere: 0.2, box: [1, 1, 1], position: [0, 0, 0]}",
            "expected exactly one of box, sphere, cylinder, mesh",
        ),
        ("{sphere: -1, position: [0, 0, 0]}", "sphere"),
    ],
)
def test_bad_obstacles_are_reported_with_their_line(tmp_path, obstacle, said):
    (tmp_path / "caroca.yaml").write_text(CAROCA.read_text())
    text = "robot: caroca.yaml\nsimulation: {duration: 0.1}\nworld:\n  obstacles:\n  - "
    (tmp_path / "s.yaml").write_text(f"{text}{obstacle}\n")
    done = cli("validate", tmp_path / "s.yaml")
    assert done.returncode == 2
    assert "s.yaml:5" in done.stderr
    assert said in done.stderr


@pytest.fixture(scope="module")
def two(tmp_path_factory):
    """Files of two workspaces over the same cells."""
    folder, robot = tmp_path_factory.mktemp("two"), robot_of("caroca")
    place = region(robot, cells=10)
    for kind in ("static", "ifcow"):
        found = workspace(robot, kind, place, **ASKED.get(kind, {}))
        found.about["source"] = {"robot": CAROCA.read_text(), "changes": [], "file": str(CAROCA)}
        found.save(folder / f"{kind}.npz")
    return folder


@pytest.mark.parametrize(
    ("how", "meant"),
    [("and", lambda a, b: a & b), ("or", lambda a, b: a | b), ("minus", lambda a, b: a & ~b)],
)
def test_of_two(two, how, meant):
    done = cli("workspace", "combine", two / "static.npz", how, two / "ifcow.npz", "--out", two / f"{how}.npz")
    assert done.returncode == 0, done.stderr
    first, second, both = (load_workspace(two / f"{name}.npz") for name in ("static", "ifcow", how))
    assert np.array_equal(both.inside, meant(first.inside, second.inside))
    assert both.inside.any()
    assert not both.inside.all()
    assert f"caroca: static {how} ifcow workspace" in done.stdout
    again = combine(both, "minus", first)  # of what was made of two
    assert again.inside.sum() == (both.inside & ~first.inside).sum()


def test_mismatches_are_reported(two):
    robot = robot_of("caroca")
    static = load_workspace(two / "static.npz")
    with pytest.raises(CdprError, match="different cells"):
        combine(static, "and", workspace(robot, "static", region(robot, cells=9)))
    turned = region(robot, cells=10, orientations=[1.0, 0.0, 0.0, 1e-4] / np.linalg.norm([1.0, 0.0, 0.0, 1e-4]))
    with pytest.raises(CdprError, match="different attitudes"):
        combine(static, "and", workspace(robot, "static", turned))
    with pytest.raises(CdprError, match="how: expected one of and, or, minus, got 'xor'"):
        combine(static, "xor", static)
    done = cli("workspace", "compare", two / "ifcow.npz")
    assert (done.returncode, done.stderr.splitlines()[-1]) == (
        2,
        "ifcow: not supported by the oracle of linear programs; allowed: static, wrench-feasible, dynamic, closure",
    )


def test_cables_without_a_diameter_have_the_assumed_one_with_a_note():
    done = cli("workspace", "ifcow", CAROCA, "--cells", "4")
    assert "with an assumed cable diameter of 10 mm" in done.stdout
    assumed, given, thin = (
        workspace("caroca", "ifcow", cells=4, **options) for options in ({}, {"diameter": 0.01}, {"diameter": 0.0})
    )
    notes, others = assumed.summary()["notes"], given.summary()["notes"]
    assert notes == ["with an assumed cable diameter of 10 mm", *others]
    assert np.array_equal(assumed.value, given.value)
    assert (assumed.value < thin.value).all()
    robot = robot_of("caroca")
    thick = robot.replace(cables=[cable.replace(diameter=0.3) for cable in robot.cables])
    assert workspace(thick, "ifcow", cells=4).summary()["notes"] == others


def test_rigid_legs_have_no_assumed_diameter():
    legs = robot_of("caroca").replace(unilateral=False)
    with pytest.raises(CdprError, match=r"has no diameter: give the robot cable.diameter, or a `diameter`"):
        workspace(legs, "ifcow", cells=3)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["stiffness"], "cable 'cable_1' has no axial_stiffness: give the robot cable.axial_stiffness"),
        (
            ["stiffness", "--axial-stiffness", "1e5", "--direction", "up"],
            "direction: expected one of x, y, z, rx, ry, rz",
        ),
        (["stiffness", "--axial-stiffness", "0"], "--axial-stiffness"),
        (["static", "--cable-diameter", "0.01"], "No such option"),
        (["static", "--at-least", "nan"], "at_least: expected a finite number, got nan"),
    ],
)
def test_invalid_words_are_reported(words, said):
    kind, *rest = words
    done = cli("workspace", kind, CAROCA, "--cells", "3", *rest)
    assert done.returncode == 2
    assert said in done.stderr
    assert "Traceback" not in done.stderr


def test_unsupported_arguments_of_a_kind_are_reported():
    robot = robot_of("caroca")
    with pytest.raises(CdprError, match="static: does not accept diameter; only ifcow"):
        workspace(robot, "static", region(robot, cells=3), diameter=0.01)
    with pytest.raises(CdprError, match="diametre: unknown argument; allowed: required, gravity, "):
        workspace(robot, "ifcow", region(robot, cells=3), diametre=0.01)


def test_a_file_of_an_older_format_is_reported(tmp_path, two):
    with np.load(two / "static.npz") as kept:
        parts = dict(kept)
    parts["about"] = np.array(str(parts["about"]).replace(FORMAT, "cdpr workspace 1"))
    np.savez(tmp_path / "old.npz", **parts)
    with pytest.raises(LogError, match="cannot be read as a workspace"):
        load_workspace(tmp_path / "old.npz")


def test_the_help_of_compare_lists_the_kinds_to_which_linear_programs_apply():
    text = " ".join((workspace_compare.command.help or "").split())
    listed = ", ".join(name for name, kind in KINDS.items() if kind.programs)
    assert f"one of these kinds: {listed}." in text
