"""cdpr.distribute: one or many, compiled or not, threads, bad rows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from conftest import ROOT

import cdpr
from cdpr import distribute
from cdpr.analysis.distribution.distributions import CHUNK
from cdpr.base.errors import CdprError, PluginError
from cdpr.cables import Pulley
from cdpr.mechanics.dynamics import required_wrench
from cdpr.mechanics.kinematics import make_state, wrench_matrix
from cdpr.model import rotations
from cdpr.plugins import CompiledSolver, TensionSolver
from cdpr.plugins.registry import registry
from cdpr.tension import Status
from cdpr_solvers.options import QpOptions
from cdpr_solvers.qp import MinimumNorm

pytestmark = pytest.mark.core

GRAVITY = np.array([0.0, 0.0, -9.81])
AT = [0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0]


@pytest.fixture(scope="module")
def robot():
    return cdpr.load_robot(ROOT / "scenarios" / "robots" / "caroca.yaml")


def made(name, robot):
    entry = registry().get("solver", name)
    return entry.make(robot, entry.read_options({"name": "clarabel"} if name == "qpsolvers" else {}))


def poses(count, seed=0):
    rng = np.random.default_rng(seed)
    position = [0.0, 0.0, 1.5] + rng.uniform(-1.0, 1.0, (count, 3)) * [6.0, 4.0, 1.5]  # some beyond the workspace
    turns = [rotations.from_rpy(*rng.uniform(-0.2, 0.2, 3)) for _ in range(count)]
    return np.hstack([position, turns])


@pytest.mark.parametrize("name", ["qp", "lp", "analytic_centre", "pseudo_inverse"])
def test_rows_equal_answers_of_the_solver(robot, name):
    at = poses(60)
    result = distribute(robot, at, solver=name)
    assert result.tension.shape == (60, 8)
    assert 0 < result.feasible.sum() < 60
    entry = registry().get("solver", name)
    solver = entry.make(robot, entry.read_options({}))
    for k, pose in enumerate(at):
        state = make_state(pose[:3], pose[3:])
        W = np.ascontiguousarray(wrench_matrix(robot, state))
        wrench = required_wrench(robot, state, GRAVITY)
        own = np.full(8, np.nan)
        status = solver.solve(W, wrench, robot.tension_min, robot.tension_max, own)
        t = result.tension[k]
        assert np.all((t >= robot.tension_min) & (t <= robot.tension_max))
        if result.status[k] == Status.OK:
            assert status == Status.OK
            np.testing.assert_allclose(t, own, atol=1e-9)  # N: the quaternion was normalised once more
            assert result.residual[k] <= 1e-9
        elif name != "pseudo_inverse":
            assert status == result.status[k]
            assert result.residual[k] > 0.0


def test_any_memory_layout_and_number_of_threads(robot):
    at = poses(3 * CHUNK // 2)
    wrench = np.tile([20.0, -10.0, 1500.0, 1.0, 2.0, 3.0], (len(at), 1))
    result = distribute(robot, at, wrench, jobs=2)
    again = distribute(robot, np.asfortranarray(at), np.asfortranarray(wrench), jobs=1)
    np.testing.assert_array_equal(result.tension, again.tension)
    np.testing.assert_array_equal(result.status, again.status)
    rounded = np.asfortranarray(wrench, dtype=np.float32)  # these numbers are exact in single precision
    np.testing.assert_array_equal(distribute(robot, at[:50], rounded[:50]).tension, result.tension[:50])


def test_one_pose_many_wrenches_and_the_reverse(robot):
    pose = poses(1)[0] * [0, 0, 1, 0, 0, 0, 0] + [0, 0, 0, 1, 0, 0, 0]
    wrench = np.array([0.0, 0, 1471.5, 0, 0, 0])
    one = distribute(robot, pose, wrench)
    assert one.tension.shape == (8,)
    assert one.status == Status.OK
    many = distribute(robot, pose, [wrench, 2 * wrench])
    np.testing.assert_array_equal(many.tension[0], one.tension)
    assert distribute(robot, [pose] * 3, wrench).tension.shape == (3, 8)
    assert distribute(robot, np.empty((0, 7))).tension.shape == (0, 8)


def test_rows_that_are_not_finite_are_reported_and_harm_no_other(robot):
    at = poses(20)
    clean = distribute(robot, at)
    at[3, 1] = np.nan
    at[5, :3] = robot.anchors[0, :3] - rotations.matrix(at[5, 3:]) @ robot.anchors[0, 3:]  # a cable without length
    for solver in ("qp", "osqp"):
        result = distribute(robot, at, solver=solver)
        assert result.status[3] == Status.BAD_INPUT
        assert np.isnan(result.tension[3]).all()
    result = distribute(robot, at)
    others = np.delete(np.arange(20), [3, 5])
    np.testing.assert_array_equal(result.tension[others], clean.tension[others])


def test_a_solver_in_python_and_one_with_options(robot):
    at = poses(30)
    wanted = distribute(robot, at)
    found = distribute(robot, at, solver="daqp")
    np.testing.assert_array_equal(found.status, wanted.status)
    np.testing.assert_allclose(found.tension, wanted.tension, atol=1e-6)
    middle = distribute(robot, at, options={"about": "middle"})
    assert (middle.tension.sum(axis=1) > wanted.tension.sum(axis=1) + 1.0).any()


class Lying(TensionSolver):
    def solve(self, W, wrench, t_min, t_max, tension):
        tension[:] = t_min
        return Status.OK


def test_no_solver_is_believed(robot):
    result = distribute(robot, poses(5), solver=Lying(robot, None))
    assert (result.status == Status.NOT_FOUND).all()


@pytest.mark.parametrize(
    ("arguments", "error", "text"),
    [
        (([0, 0, 1, 0.5, 0, 0, 0],), CdprError, r"poses\[0\]: expected a quaternion of norm 1, got norm 0.5"),
        (([0, 0, 1],), CdprError, r"poses: the shape must be \(7,\) or \(K, 7\)"),
        (
            ([AT] * 2, np.zeros((3, 6))),
            CdprError,
            "rows: poses 2, wrenches 3; give either one row or equal numbers of rows",
        ),
        (([AT] * 2, np.zeros((0, 6))), CdprError, "rows: poses 2, wrenches 0"),
        ((["a"] * 7,), CdprError, "poses: expected real numbers, got an array of <U1"),
        ((np.array(AT) + 0j,), CdprError, "poses: expected real numbers, got an array of complex128"),
        (([AT, [0.0]],), CdprError, "poses: expected numbers: .*inhomogeneous"),
        ((AT, [True] * 6), CdprError, "wrenches: expected real numbers, got an array of bool"),
    ],
)
def test_wrong_input_is_reported(robot, arguments, error, text):
    with pytest.raises(error, match=text):
        distribute(robot, *arguments)


@pytest.mark.parametrize(
    ("named", "text"),
    [
        (
            {"solver": object()},
            "solver: expected the name of a solver, or a TensionSolver of this robot, got a object",
        ),
        ({"solver": TensionSolver}, "got the class TensionSolver"),
        ({"jobs": 0}, "jobs: expected a whole number of threads, at least 1, got 0"),
        ({"jobs": -1}, "got -1"),
        ({"jobs": 1.5}, "got 1.5"),
        ({"jobs": True}, "got true"),
        ({"gravity": np.zeros((2, 3))}, r"gravity: the shape must be \(3,\), got \(2, 3\)"),
        ({"tension_max": [100.0]}, r"tension_max: the shape must be \(8,\) or \(K, 8\), got \(1,\)"),
        ({"tension_min": [-1.0] * 8}, "tension_min: below zero, but cables cannot push"),
    ],
)
def test_wrong_settings_are_reported(robot, named, text):
    with pytest.raises(CdprError, match=text):
        distribute(robot, AT, **named)


def test_a_list_is_no_robot():
    with pytest.raises(CdprError, match=r"robot: expected a Robot, a file, .* got a list"):
        distribute(["scenarios/robots/caroca.yaml"], AT)


def test_a_solver_of_another_robot_is_reported(robot):
    other = cdpr.load_robot(ROOT / "scenarios" / "robots" / "planar.yaml")
    with pytest.raises(CdprError, match="solver: was made for a robot with 4 cables and 3 degrees of freedom"):
        distribute(robot, AT, solver=made("qp", other))
    with pytest.raises(CdprError, match="options"):
        distribute(robot, AT, options=np.ones(3))
    with pytest.raises(CdprError, match="options: allowed only with the name of a solver"):
        distribute(robot, AT, solver=made("qp", robot), options={})


@pytest.mark.parametrize("solver", ["qp", "daqp"])
@pytest.mark.parametrize("one", [AT, [AT]])
def test_no_rows_give_empty_results(robot, solver, one):
    """The compiled loop once went over the one pose and wrote a row that was not there."""
    for arguments in ((one, np.zeros((0, 6))), (np.zeros((0, 7)),), (np.zeros((0, 7)), np.zeros((0, 6)))):
        result = distribute(robot, *arguments, solver=solver)
        assert result.tension.shape == (0, 8)
        assert result.status.shape == result.margin.shape == result.feasible.shape == (0,)
    assert distribute(robot, one, solver=solver, tension_max=np.zeros((0, 8))).tension.shape == (0, 8)


def test_statuses_are_integers_that_print_as_names(robot):
    at = np.array([AT] * 6)
    at[2, 0] = np.nan
    status = distribute(robot, at).status
    assert status.dtype == np.int64
    assert str(status[1:3]) == "[OK BAD_INPUT]"
    assert repr(status[2]) == "<Status.BAD_INPUT: 4>"
    assert type(status == Status.OK) is np.ndarray
    assert np.bincount(status)[4] == 1
    assert str(distribute(robot, AT).status) == "OK"


@pytest.mark.parametrize("solver", ["qp", "daqp"])
def test_limits_per_row(robot, solver):
    """Each row acts as if the robot had its limits; a contradictory row is reported and affects no other."""
    at = poses(3) * [0.1, 0.1, 0.5, 1, 1, 1, 1]
    high = np.array([[900.0] * 8, [5.0] * 8, [400.0] * 8])  # the second below the lowest, 50 N
    result = distribute(robot, at, solver=solver, tension_max=high)
    assert result.status.tolist() == [Status.OK, Status.BAD_INPUT, result.status[2]]
    for k in (0, 2):
        cables = tuple(replace(cable, tension_max=high[k, 0]) for cable in robot.cables)
        alone = distribute(replace(robot, cables=cables), at[k], solver=solver)
        assert alone.status == result.status[k]
        np.testing.assert_array_equal(alone.tension, result.tension[k])
    assert np.isnan(result.tension[1]).all()
    for k in (0, 2):  # one pose, many limits
        found = distribute(robot, at[k], solver=solver, tension_max=high)
        np.testing.assert_array_equal(found.tension[k], result.tension[k])
    none = distribute(robot, at[0], solver=solver, tension_max=[np.nan] + [900.0] * 7)
    assert none.status == Status.BAD_INPUT


def test_unknown_solver_is_reported(robot):
    with pytest.raises(PluginError, match="did you mean"):
        distribute(robot, poses(1), solver="qpp")


def test_a_matrix_of_another_robot_is_refused(robot):
    """With more rows or columns than the robot has, a kernel would write beyond its work space."""
    for name in registry().names("solver"):
        solver = made(name, robot)
        if not isinstance(solver, CompiledSolver):
            continue
        for n, m in ((robot.n + 30, robot.m), (robot.n, robot.m + 30)):
            W = np.random.default_rng(0).normal(size=(n, m))
            status = solver.solve(W, W @ np.ones(m), np.zeros(m), np.full(m, 2.0), np.full(m, np.nan))
            assert status == Status.BAD_INPUT, name


def test_arrays_that_do_not_fit_each_other_are_refused(robot):
    """Shorter limits or answers than W has columns would be read and written beyond their ends."""
    n, m = robot.n, robot.m
    fitting = [np.random.default_rng(0).normal(size=(n, m)), np.ones(n), np.zeros(m), np.full(m, 2.0), np.zeros(m)]
    for name in registry().names("solver"):
        solver = made(name, robot)
        if not isinstance(solver, CompiledSolver):
            continue
        for k in (2, 3, 4):
            arguments = [array[:-3] if i == k else array for i, array in enumerate(fitting)]
            assert solver.solve(*arguments) == Status.BAD_INPUT, (name, k)
        assert solver.solve(fitting[0], np.ones(n + 4), *fitting[2:]) == Status.BAD_INPUT, name


class Careless(TensionSolver):
    """The least squares, whatever the limits."""

    properties = {"respects_bounds": False}  # noqa: RUF012 - as a plugin's author would write it

    def solve(self, W, wrench, t_min, t_max, tension):
        tension[:] = np.linalg.pinv(W) @ wrench
        return Status.OK


@pytest.mark.parametrize("name", ["pseudo_inverse", "qp"])
def test_a_solver_declares_the_same_by_name_and_made(robot, name):
    """Answers of a solver that ignores limits are clipped, with limits given in any form."""
    pose, wrench = [0.0, 0.0, 1.5, 1.0, 0.0, 0.0, 0.0], [3000.0, 0.0, 100.0, 0.0, 0.0, 0.0]
    named = distribute(robot, pose, wrench, solver=name)
    given = distribute(robot, pose, wrench, solver=made(name, robot))
    np.testing.assert_array_equal(given.tension, named.tension)
    assert given.status == named.status


class Doubled(MinimumNorm):
    """Does more than its kernel."""

    def solve(self, W, wrench, t_min, t_max, tension):
        status = super().solve(W, wrench, t_min, t_max, tension)
        tension += np.linalg.svd(W)[2][-1]  # tensions that move nothing
        return status


@pytest.mark.parametrize("rows", [1, 200])
def test_subclasses_without_a_kernel_are_called(robot, rows):
    poses = np.tile([0.0, 0.0, 1.5, 1.0, 0.0, 0.0, 0.0], (rows, 1))
    plain = distribute(robot, poses, solver=MinimumNorm(robot, QpOptions()))
    doubled = distribute(robot, poses, solver=Doubled(robot, QpOptions()))
    assert (doubled.status == Status.OK).all()
    assert np.linalg.norm(doubled.tension - plain.tension, axis=1) == pytest.approx(1.0)


def test_a_class_of_ones_own_declares_by_itself(robot):
    pose, wrench = [0.0, 0.0, 1.5, 1.0, 0.0, 0.0, 0.0], [3000.0, 0.0, 100.0, 0.0, 0.0, 0.0]
    clipped = distribute(robot, pose, wrench, solver=Careless(robot, None))
    wanted = distribute(robot, pose, wrench, solver="pseudo_inverse")
    np.testing.assert_allclose(clipped.tension, wanted.tension, atol=1e-9)  # N


@pytest.mark.parametrize("count", [1, 40])
def test_pulleys_count(robot, count):
    """Alone, eight side by side, and by a solver that is Python."""
    pulley = Pulley(type="pulley", radius=0.2)
    on_pulleys = replace(robot, cables=tuple(replace(cable, exit=pulley) for cable in robot.cables))
    at = np.tile(AT, (count, 1))
    at[:, :2] = np.random.default_rng(4).uniform(-1.0, 1.0, (count, 2))

    class Own(TensionSolver):
        def solve(self, W, wrench, t_min, t_max, tension):
            return MinimumNorm(self.robot, QpOptions()).solve(W, wrench, t_min, t_max, tension)

    found, expected = distribute(on_pulleys, at), distribute(on_pulleys, at, solver=Own(on_pulleys, None))
    assert (found.status == Status.OK).all()
    np.testing.assert_allclose(found.tension, expected.tension, atol=1e-9)
    assert np.abs(found.tension - distribute(robot, at).tension).max() > 0.1


def test_a_scenario_gives_gravity_and_controlled_directions():
    moon = cdpr.load_scenario("caroca", overrides={"world.gravity": [0, 0, -1.62]})
    pose = moon.robot.home
    expected = cdpr.distribute(moon.robot, pose, gravity=[0, 0, -1.62])
    assert (cdpr.distribute(moon, pose).tension == expected.tension).all()
    assert (cdpr.distribute(moon, pose, gravity=[0, 0, -9.81]).tension == cdpr.distribute("caroca", pose).tension).all()
    assert (cdpr.admissible(moon, pose).wrench == cdpr.admissible(moon.robot, pose, gravity=[0, 0, -1.62]).wrench).all()
    forces = cdpr.load_scenario("caroca", overrides={"controlled": ["x", "y", "z"]})
    expected = cdpr.distribute(forces.controlled_robot, pose)
    assert (cdpr.distribute(forces, pose).tension == expected.tension).all()
    assert (expected.tension != cdpr.distribute("caroca", pose).tension).any()


def test_a_question_replaces_the_gravity_of_a_scenario():
    moon = cdpr.load_scenario("caroca", overrides={"world.gravity": [0, 0, -1.62]})
    asked = cdpr.analysis.workspace.Question(gravity=(0.0, 0.0, -9.81))
    found = cdpr.workspace(moon, "static", question=asked, cells=4)
    assert (found.value == cdpr.workspace("caroca", "static", question=asked, cells=4).value).all()
