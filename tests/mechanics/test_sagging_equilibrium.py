"""Poses at rest, stiffness and compensated lengths of robots on heavy cables."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT
from sagging_robots import G, random_sagging, remaining
from scipy.optimize import root
from scipy.spatial.transform import Rotation

import cdpr
from cdpr.base.errors import CdprError
from cdpr.cables.pulley import Pulley
from cdpr.mechanics.equilibrium import find_equilibrium
from cdpr.mechanics.potential import Potential, rest_lengths
from cdpr.mechanics.stiffness import stiffness

DOWN = (0.0, 0.0, -G)
SAGGING = ROOT / "scenarios" / "sagging.yaml"
COGIRO = ROOT / "scenarios" / "robots" / "cogiro_sagging.yaml"
M, W, EA = 20.0, 3.0 * G, 1e5  # kg, N/m, N: a mass on one rope


def nothing(m):
    return np.full(m, np.nan)


def hanging(dof=("z",), mass=M, above=10.0):
    winch = cdpr.model.Winch(drum_radius=0.05, inertia=0.01)
    given = {"model": "catenary", "axial_stiffness": EA, "linear_density": W / G, "winch": winch}
    cable = cdpr.Cable([0.0, 0.0, above], [0.0, 0.0, 0.0], 1.0, 1e6, **given)
    return cdpr.Robot(cdpr.Platform(mass, np.eye(3)), [cable], dof, home=[0.0, 0.0, 5.0])


def test_a_mass_on_a_heavy_rope_hangs_as_in_closed_form():
    """The rope stretches by (M g L + w L^2 / 2) / EA, and swings up and down with EA / L."""
    L = 4.0
    found = cdpr.equilibrium(hanging(), lengths=[L])
    assert found.converged
    assert found.stability == "stable"
    assert found.pose[2] == pytest.approx(10.0 - L - (M * G * L + 0.5 * W * L * L) / EA, abs=1e-12)
    assert found.tension == pytest.approx([M * G + W * L], rel=1e-12)
    assert found.frequencies == pytest.approx([np.sqrt(EA / (L * M)) / (2.0 * np.pi)], rel=1e-9)
    k = 1.0 + (M * G + W * L) / EA  # a longer rope also carries more of itself
    assert found.sensitivity[2] == pytest.approx([-k], rel=1e-9)


def test_a_rope_at_constant_tension_holds_its_mass_at_one_height_but_not_stably():
    """T = M g + w L: lower down, the rope is heavier and pulls less."""
    L = 4.0
    (found,) = cdpr.equilibria(hanging(), tensions=[M * G + W * L], starts=5)
    assert found.unwound == pytest.approx([L], rel=1e-9)
    assert found.stability == "unstable"
    with pytest.raises(CdprError, match="cable 'cable_1': 10 N cannot carry its weight"):
        cdpr.equilibrium(hanging(), tensions=[10.0])


@pytest.mark.parametrize("seeds", [range(25), pytest.param(range(25, 600), marks=pytest.mark.slow)])
def test_random_robots_are_at_rest_by_irvine_and_scipy(seeds):
    for seed in seeds:
        robot, unwound, start = random_sagging(seed)
        found = find_equilibrium(robot, unwound, nothing(robot.m), start, DOWN)
        assert found.converged, (seed, found.problem)
        assert found.residual <= 1e-9 * found.load
        left = remaining(robot, found.pose, unwound)[list(robot.rows)]
        stiff = 1e-13 * robot.cables[0].axial_stiffness  # round-off of the oracle
        assert np.abs(left).max() <= 1e-9 * found.load * float(np.abs(robot.anchors).max()) + stiff, seed


@pytest.mark.parametrize("seed", [0, 2, 5])
def test_scipy_finds_the_same_pose(seed):
    robot, unwound, start = random_sagging(seed)
    found = find_equilibrium(robot, unwound, nothing(robot.m), start, DOWN)
    at = Potential(robot, DOWN, unwound, nothing(robot.m))
    load = found.load * at.size

    def miss(step):
        return remaining(robot, at.moved(found.pose, step), unwound)[list(robot.rows)] / load

    step = 1e-4 * at.size * np.random.default_rng(seed).normal(size=robot.n)
    other = root(miss, step, tol=1e-13).x
    assert found.stability == "stable"
    assert np.abs(other).max() < 1e-7 * at.size


@pytest.mark.parametrize("pulleys", [False, True])
def test_random_robots_are_at_rest_on_pulleys_too(pulleys):
    for seed in range(100, 108):
        robot, unwound, start = random_sagging(seed, pulleys)
        found = find_equilibrium(robot, unwound, nothing(robot.m), start, DOWN)
        assert found.converged, (seed, found.problem)
        assert found.residual <= 1e-9 * found.load


def test_the_energy_has_the_force_as_its_gradient():
    robot, unwound, start = random_sagging(2)
    tension = nothing(robot.m)
    tension[1], unwound[1] = 3.0 * G * robot.platform.mass, np.nan
    at = Potential(robot, DOWN, unwound, tension)
    _, gradient, hessian = at.evaluate(start)
    h = 1e-6 * at.size
    for j, e in enumerate(h * np.eye(robot.n)):
        more, less = at.evaluate(at.moved(start, e)), at.evaluate(at.moved(start, -e))
        assert (more[0] - less[0]) / (2.0 * h) == pytest.approx(gradient[j], rel=1e-5, abs=1e-6 * at.load())
        np.testing.assert_allclose((more[1] - less[1])[j] / (2.0 * h), hessian[j, j], rtol=1e-5)


def test_cables_without_weight_are_elastic():
    for seed in range(10):
        robot, unwound, start = random_sagging(seed)
        light = robot.replace(cables=[cable.replace(linear_density=0.0) for cable in robot.cables])
        elastic = robot.replace(cables=[cable.replace(model="elastic") for cable in robot.cables])
        one, other = (find_equilibrium(each, unwound, nothing(robot.m), start, DOWN) for each in (light, elastic))
        assert one.converged
        assert other.converged
        if other.stability == "stable":
            np.testing.assert_allclose(one.pose, other.pose, atol=1e-7)
            np.testing.assert_allclose(one.frequencies, other.frequencies, rtol=1e-5)
            assert one.slack.tolist() == other.slack.tolist()


def test_the_scenario_rests_where_its_run_ends():
    run = cdpr.simulate(SAGGING, backend="reference", overrides={"simulation.duration": 9.0})
    assert np.abs(run.velocity[-1]).max() < 1e-5
    start = np.array([*run.position[-1], *run.orientation[-1]])
    found = cdpr.equilibrium(SAGGING, lengths=run["unstretched_length"][-1], start=start)
    assert found.converged
    np.testing.assert_allclose(found.pose, start, atol=1e-7)
    np.testing.assert_allclose(found.tension, run.cable_tension[-1], rtol=1e-5)


def wrench_at(robot, at, unwound):
    """Wrench (6,) of the cables at a pose with given unwound lengths, by the kernel of single cables."""
    from cdpr.cables.tables import chain_table, exits, line_table
    from cdpr.native.bind import bind

    tips = at[:3] + robot.anchors[:, 3:] @ Rotation.from_quat(at[3:], scalar_first=True).as_matrix().T
    leaving, _, wrapped = exits(line_table(robot), tips)
    force, tension = np.zeros((robot.m, 3)), np.zeros(robot.m)
    ends = {"chord": leaving - tips, "exit_to_anchor": robot.anchors[:, :3] - leaving, "wrapped_length": wrapped}
    given = {"chains": chain_table(robot), "gravity": np.array(DOWN), "unwound": unwound}
    bind("bent_cables", **given, **ends, stretching=np.zeros(robot.m), force=force, tension=tension)()
    weight = np.array([0.0, 0.0, -G * robot.platform.mass])
    arm = Rotation.from_quat(at[3:], scalar_first=True).apply(robot.platform.center_of_mass.copy())
    return np.concatenate([force.sum(axis=0), np.cross(tips - at[:3], force).sum(axis=0) + np.cross(arm, weight)])


@pytest.mark.parametrize("exit", [None, Pulley(radius=0.2)])
@pytest.mark.parametrize("tension", [400.0, 3000.0])
def test_the_stiffness_is_the_derivative_of_the_wrench_at_constant_lengths(exit, tension):
    robot = cdpr.load_robot(COGIRO)
    body = cdpr.Platform(90.0, np.diag([9.0, 8.0, 7.0]), [0.1, -0.05, 0.2])
    robot = robot.replace(cables=[cable.replace(exit=exit) for cable in robot.cables], platform=body)
    turned = Rotation.from_rotvec([0.05, -0.1, 0.2]).as_quat(scalar_first=True)
    pose = np.concatenate([robot.home[:3] + np.array([0.5, -0.3, 0.2]), turned])
    given = np.full((1, robot.m), tension)
    K, _ = stiffness(robot, pose[None], given)
    unwound = rest_lengths(robot, pose[None], given)[0]

    def moved(j, h):
        step = h * np.eye(6)[j]
        turn = Rotation.from_rotvec(step[3:]) * Rotation.from_quat(pose[3:], scalar_first=True)
        return wrench_at(robot, np.array([*(pose[:3] + step[:3]), *turn.as_quat(scalar_first=True)]), unwound)

    def slope(j, h):
        return (moved(j, h) - moved(j, -h)) / (2.0 * h)

    h = 2e-5
    differences = np.array([-(4.0 * slope(j, h) - slope(j, 2.0 * h)) / 3.0 for j in range(6)]).T
    np.testing.assert_allclose(K[0], differences, atol=1e-6 * np.abs(K).max())
    elastic = robot.replace(cables=[cable.replace(model="elastic") for cable in robot.cables])
    softer = stiffness(elastic, pose[None], given)[0]
    assert np.abs(K - softer).max() > 1e-3 * np.abs(K).max()


def test_the_platform_rests_at_the_compensated_pose():
    robot = cdpr.load_robot(COGIRO)
    poses = np.tile(robot.home, (3, 1))
    poses[1:, :3] += [[1.0, -0.5, 0.3], [-2.0, 1.0, 0.5]]
    wanted = cdpr.compensated_lengths(robot, poses)
    assert wanted.feasible.all()
    for pose, lengths, tension in zip(poses, wanted.lengths, wanted.tension, strict=True):
        found = cdpr.equilibrium(robot, lengths=lengths, start=pose)
        assert found.converged
        np.testing.assert_allclose(found.pose, pose, atol=1e-8)
        np.testing.assert_allclose(found.tension, tension, rtol=1e-6)
    single = cdpr.compensated_lengths(robot, poses[1])
    np.testing.assert_array_equal(single.lengths, wanted.lengths[1])
    heavy = robot.replace(cables=[cable.replace(linear_density=8.0) for cable in robot.cables])
    beyond = cdpr.compensated_lengths(heavy, robot.home)
    assert not beyond.feasible
    assert np.isnan(beyond.lengths).any()


def test_sensitivities_are_those_of_differences():
    robot = cdpr.load_robot(COGIRO)
    unwound = cdpr.compensated_lengths(robot, robot.home).lengths
    unwound[2] += 0.02
    found, h = cdpr.equilibrium(robot, lengths=unwound), 1e-5
    for i in (0, 2):
        ends = [cdpr.equilibrium(robot, lengths=unwound + sign * h * np.eye(robot.m)[i]).pose for sign in (1.0, -1.0)]
        turn = cdpr.model.rotations.between(ends[1][3:], ends[0][3:])
        change = np.concatenate([ends[0][:3] - ends[1][:3], turn]) / (2.0 * h)
        np.testing.assert_allclose(found.sensitivity[:, i], change, rtol=1e-4, atol=1e-4)
