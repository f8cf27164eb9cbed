"""Workspaces: what a pose's margin is, against linear programs; regions, files and the command."""

from __future__ import annotations

import itertools
import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog
from spread import sampled
from workspace_cases import ROBOTS, cli, poses_of, problem, robot_of

from cdpr.analysis.workspace import required as sets
from cdpr.analysis.workspace.measure import measure
from cdpr.analysis.workspace.oracle import compare
from cdpr.analysis.workspace.regions import region
from cdpr.analysis.workspace.result import load_workspace, workspace
from cdpr.base.errors import CdprError, LogError
from cdpr.mechanics.dynamics import required_wrench
from cdpr.mechanics.kinematics import make_state
from cdpr.scenario.robot_schema import CHECKED

SIX = [
    "cogiro",
    "caroca",
    "ipanema_1",
    "planar",
    "planar_point_mass",
    "point_mass",
    "twelve",
    "seven",
    "cogiro_pulleys",
]
GRAVITY = (0.0, 0.0, -9.81)
NEAR = 1e-6  # N: closer to zero, the program's tolerance decides


def feasible(W, wrench, low, high):
    return linprog(np.zeros(W.shape[1]), A_eq=W, b_eq=wrench, bounds=np.stack([low, high], axis=1)).status == 0


def farthest(W, wrench, direction, low, high):
    """How far the cables can go from a wrench along a direction: the largest s with W t = wrench + s direction."""
    m = W.shape[1]
    equal = np.hstack([W, -direction[:, None]])
    bounds = [*zip(low, high, strict=True), (None, None)]
    return linprog(np.append(np.zeros(m), -1.0), A_eq=equal, b_eq=wrench, bounds=bounds).x[m]


@sampled(lambda name: name in ("cogiro", "planar", "planar_point_mass", "point_mass"), "name", SIX)
def test_static_and_wrench_feasible_as_linear_programs_have_them(name):
    robot = robot_of(name)
    low, high = robot.tension_min, robot.tension_max
    half = np.zeros(6)
    half[robot.rows] = [8.0 if row < 3 else 1.0 for row in robot.rows]
    poses = poses_of(robot, 20)
    static, with_box = measure(robot, poses), measure(robot, poses, required=sets.box(half))
    for k, pose in enumerate(poses):
        W, carried, weights = problem(robot, pose)
        if abs(static.value[k]) > NEAR:
            assert feasible(W, carried, low, high) == (static.value[k] > 0.0)
        if k < 4 and abs(with_box.value[k]) > NEAR:
            corners = (
                carried + weights * half[robot.rows] * signs for signs in itertools.product((-1, 1), repeat=robot.n)
            )
            assert all(feasible(W, each, low, high) for each in corners) == (with_box.value[k] > 0.0)
    assert (with_box.value <= static.value + NEAR).all()


@pytest.mark.parametrize("name", ["cogiro", "planar", "twelve", "planar_point_mass"])
def test_the_margin_is_the_way_to_the_nearest_facet(name):
    robot = robot_of(name)
    poses = poses_of(robot, 60, seed=3)
    found = measure(robot, poses)
    rng = np.random.default_rng(5)
    inside = np.flatnonzero(found.value > 1.0)[:6]
    assert len(inside)
    for k in inside:
        W, carried, _ = problem(robot, poses[k])
        reach = farthest(W, carried, found.direction[k], robot.tension_min, robot.tension_max)
        assert reach == pytest.approx(found.value[k], rel=1e-7)
        for direction in rng.standard_normal((5, robot.n)):
            unit = direction / np.linalg.norm(direction)
            further = farthest(W, carried, unit, robot.tension_min, robot.tension_max)
            assert further >= found.value[k] * (1.0 - 1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("name", SIX)
def test_closure_as_a_linear_program_has_it(name):
    robot = robot_of(name)
    poses = poses_of(robot, 20, seed=1)
    found = measure(robot, poses, "closure")
    for k, pose in enumerate(poses):
        W, _, _ = problem(robot, pose)
        expected = feasible(W, np.zeros(robot.n), np.ones(robot.m), np.full(robot.m, np.inf))
        assert expected == (found.value[k] > 0.0)


@pytest.mark.parametrize("name", ["cogiro", "planar", "point_mass"])
def test_with_its_payload_the_platform_is_at_the_limit(name):
    robot = robot_of(name)
    poses = poses_of(robot, 60, seed=2)
    found = measure(robot, poses, "payload", gravity=GRAVITY)
    static = measure(robot, poses)
    known = np.flatnonzero(np.isfinite(found.value) & (found.value > 0.0))[:10]
    assert len(known)
    assert (np.isfinite(found.value) & (found.value >= 0.0)).tolist() == (static.value >= 0.0).tolist()
    for k in known:
        for share, sign in ((0.999, 1.0), (1.001, -1.0)):
            # The mass is added where the platform's own is.
            mass = robot.platform.mass + share * found.value[k]
            heavier = replace(robot, platform=replace(robot.platform, mass=mass))
            assert sign * measure(heavier, poses[k : k + 1]).value[0] > 0.0


@pytest.mark.parametrize("name", SIX)
def test_only_feasible_poses_have_a_payload(name):
    robot = robot_of(name)
    place = region(robot, cells=7)
    np.testing.assert_array_equal(workspace(robot, "payload", place).inside, workspace(robot, "static", place).inside)


def test_forms_of_required_sets_agree():
    robot = robot_of("cogiro")
    poses = poses_of(robot, 30)
    half = np.array([30.0, 20.0, 10.0, 3.0, 2.0, 1.0])
    corners = np.array(list(itertools.product((-1, 1), repeat=6))) * half
    box = measure(robot, poses, required=sets.box(half)).value
    np.testing.assert_allclose(measure(robot, poses, required=sets.vertices(corners)).value, box, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(measure(robot, poses, required=sets.zonotope(np.diag(half))).value, box, rtol=0, atol=0)
    round_ = measure(robot, poses, required=sets.ellipsoid(half)).value
    assert (round_ > box).all()
    assert (round_ < measure(robot, poses).value).all()
    # One wrench more is as far away as its point.
    point = measure(robot, poses, required=sets.point([0.0, 0.0, 40.0, 0.0, 0.0, 0.0])).value
    mass = robot.platform.mass + 40.0 / 9.81
    heavier = replace(robot, platform=replace(robot.platform, mass=mass, center_of_mass=np.zeros(3)))
    if not robot.platform.center_of_mass.any():
        np.testing.assert_allclose(point, measure(heavier, poses).value, rtol=1e-9, atol=1e-9)


def test_accelerations_are_the_wrenches_that_make_them():
    robot = robot_of("off_centre")
    poses = poses_of(robot, 20)
    half = np.array([0.5, 0.5, 0.5, 0.1, 0.2, 0.3])
    found = measure(robot, poses, required=sets.box(half, accelerations=True)).value
    for k, pose in enumerate(poses):
        state = make_state(pose[:3], pose[3:])
        zero = required_wrench(robot, state, (0.0, 0.0, 0.0))
        wrenches = [required_wrench(robot, state, (0.0, 0.0, 0.0), *np.split(a, 2)) - zero for a in np.diag(half)]
        expected = measure(robot, pose[None], required=sets.zonotope(wrenches)).value[0]
        assert found[k] == pytest.approx(expected, rel=1e-9, abs=1e-9)


@given(seed=st.integers(0, 10**6), kind=st.sampled_from(["zonotope", "ellipsoid", "vertices"]))
def test_the_fast_way_of_two_redundant_cables_is_the_general_one(seed, kind):
    """A cable that pulls nothing, and is not held, makes r = 3 of r = 2: the margin is the same."""
    robot = robot_of("cogiro")
    rng = np.random.default_rng(seed)
    pose = poses_of(robot, 1, seed)
    vectors = rng.standard_normal((3, 6)) * [20, 20, 20, 2, 2, 2]
    wanted = {"zonotope": sets.zonotope, "vertices": sets.vertices}.get(kind, lambda v: sets.Required("ellipsoid", v))
    twin = replace(robot.cables[0], name="twin")
    two = replace(robot, cables=(*robot.cables, twin))
    # Two cables side by side that share the limits of one are that one.
    halved = [
        replace(c, tension_min=0.5 * c.tension_min, tension_max=0.5 * c.tension_max) for c in (two.cables[0], twin)
    ]
    shared = replace(robot, cables=(halved[0], *robot.cables[1:], halved[1]))
    vars(shared)[CHECKED] = True  # robot files reject equal cables
    length = robot.characteristic_length
    one = measure(robot, pose, required=wanted(vectors), length=length)
    both = measure(shared, pose, required=wanted(vectors), length=length)
    assert both.value[0] == pytest.approx(one.value[0], rel=1e-8, abs=1e-6)


def test_locked_cables_are_given_and_the_others_bound_the_rest():
    robot = robot_of("cogiro")
    poses = poses_of(robot, 30)
    cables = list(robot.cables)
    cables[2] = replace(cables[2], tension_min=400.0, tension_max=400.0)
    locked = replace(robot, cables=tuple(cables))
    found = measure(locked, poses)
    for k, pose in enumerate(poses):
        W, carried, _ = problem(locked, pose)
        if abs(found.value[k]) > NEAR:
            assert feasible(W, carried, locked.tension_min, locked.tension_max) == (found.value[k] > 0.0)


@pytest.mark.slow
def test_rank_deficient_poses_have_no_margin_and_use_a_solver():
    robot = robot_of("crossed")
    pose = robot.home[None] if robot.home is not None else poses_of(robot, 1)
    robot = robot_of("caroca")
    flat = replace(robot, cables=robot.cables[:5])
    found = measure(flat, pose)
    assert found.singular.all()
    assert np.isnan(found.value).all()
    made = workspace(flat, "static", region(flat, cells=4))
    assert not made.inside.any()  # five cables hold no body in six directions
    hanging = replace(robot_of("point_mass"), cables=robot_of("point_mass").cables[:1])
    below = np.array([[*(hanging.anchors[0, :3] - [0.0, 0.0, 1.0]), 1.0, 0.0, 0.0, 0.0]])
    assert measure(hanging, below).singular.all()


def test_the_result_does_not_depend_on_the_threads():
    robot = robot_of("cogiro")
    poses = poses_of(robot, 9000)
    one, three = (measure(robot, poses, required=sets.box([9] * 6), jobs=jobs) for jobs in (1, 3))
    for a, b in zip(vars(one).values(), vars(three).values(), strict=True):
        np.testing.assert_array_equal(a, b)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "unit"), [("cogiro", "m^3"), ("planar", "m^2")])
def test_a_workspace_is_kept_as_it_is(tmp_path, name, unit):
    robot = robot_of(name)
    made = workspace(robot, "static", region(robot, cells=9))
    made.save(tmp_path / "w.npz")
    again = load_workspace(tmp_path / "w.npz")
    assert again.summary() == made.summary()
    assert again.region.unit == unit
    np.testing.assert_array_equal(again.value, made.value)
    told = compare(again, robot, 40)
    assert told.different == []
    assert told.bisected > 0
    for content in (b"", b"PK\3\4", (tmp_path / "w.npz").read_bytes()[:-200]):
        (tmp_path / "bad.npz").write_bytes(content)
        with pytest.raises(LogError, match=r"bad\.npz"):
            load_workspace(tmp_path / "bad.npz")


def test_the_volume_is_that_of_a_box_where_all_of_it_is_inside():
    robot = robot_of("planar")
    lower, upper = [-0.2, 0.0, 1.0], [0.3, 0.0, 1.4]
    made = workspace(robot, "static", region(robot, lower=lower, upper=upper, cells=[5, 1, 4]))
    assert made.inside.all()
    assert made.volume == pytest.approx(0.5 * 0.4)
    assert made.summary()["bounds"][0][0] == pytest.approx(-0.2)


def test_several_attitudes_are_all_or_any_of_them():
    robot = robot_of("cogiro")
    turned = [[1.0, 0.0, 0.0, 0.0], [np.cos(0.3), 0.0, 0.0, np.sin(0.3)]]
    each = [workspace(robot, "static", region(robot, cells=10, orientations=q)) for q in turned]
    place = region(robot, cells=10, orientations=turned)
    np.testing.assert_array_equal(workspace(robot, "static", place).inside, each[0].inside & each[1].inside)
    np.testing.assert_array_equal(workspace(robot, "static", place, over="any").inside, each[0].inside | each[1].inside)


@pytest.mark.parametrize(
    ("do", "words"),
    [
        (lambda r: measure(r, [[0, 0, 1, 2, 0, 0, 0]]), "quaternion"),
        (lambda r: measure(r, [[0, 0, np.nan, 1, 0, 0, 0]]), "finite"),
        (lambda r: measure(r, [[0, 0, 1, 1, 0, 0, 0]], "volume"), "mode"),
        (lambda r: measure(r, [[0, 0, 1, 1, 0, 0, 0]], length=0.0), "length"),
        (lambda r: region(r, lower=[0, 0, 2], upper=[1, 1, 1]), "z of lower"),
        (lambda r: region(r, cells=[3, 3]), "cells"),
        (lambda r: region(r, cells=10**6), "too many"),
        (lambda r: region(r, orientations=[[2, 0, 0, 0]]), "unit quaternions"),
        (lambda r: workspace(r, "statik", region(r)), "did you mean 'static'"),
        (lambda r: workspace(r, "dynamic", region(r), required=sets.box([1] * 6)), "accelerations"),
        (lambda r: workspace(r, "static", region(r), required=sets.box([1] * 6)), "does not accept required"),
        (lambda r: sets.box([1, 1, 1, 1, 1, -1]), "at least 0"),
        (lambda r: sets.vertices(np.zeros((0, 6))), "corner"),
    ],
)
def test_bad_input_is_reported(do, words):
    with pytest.raises(CdprError, match=words):
        do(robot_of("cogiro"))


def test_a_held_direction_is_not_looked_along():
    robot = robot_of("planar")
    assert region(robot).shape[1] == 1
    with pytest.raises(CdprError, match="cannot rotate"):
        region(robot, orientations=[[np.cos(0.1), np.sin(0.1), 0.0, 0.0]])


@pytest.mark.slow
def test_the_command_writes_a_file_for_compare(tmp_path):
    out = tmp_path / "w.npz"
    done = cli(
        "workspace",
        "wrench-feasible",
        ROBOTS / "cogiro.yaml",
        "--wrench-box",
        "9,9,9,1,1,1",
        "--cells",
        "9",
        "--out",
        out,
        "--json",
    )
    told = json.loads(done.stdout)
    assert told["file"] == str(out)
    assert told["volume"] == load_workspace(out).volume > 100.0
    checked = json.loads(cli("workspace", "compare", out, "--count", "10", "--json").stdout)
    assert checked["poses"] == 10
    assert checked["different"] == []
    for words, expected in (
        (["workspace", "dynamic", ROBOTS / "cogiro.yaml"], "--acceleration-box"),
        (["workspace", "static", ROBOTS / "cogiro.yaml", "--out", tmp_path / "w.csv"], ".npz"),
        (["workspace", "static", ROBOTS / "cogiro.yaml", "--cells", "a"], "--cells"),
        (["workspace", "compare", ROBOTS / "cogiro.yaml"], "cannot be read as a workspace"),
    ):
        bad = cli(*words)
        assert bad.returncode in (2, 8)
        assert expected in bad.stderr
        assert "Traceback" not in bad.stderr
