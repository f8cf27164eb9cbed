"""Poses at rest: known statics, random robots against an independent minimisation, and wrong lengths."""

from __future__ import annotations

import itertools
import os

import numpy as np
import pytest
from conftest import ROOT
from resting_robots import G, energy_of, path_lengths, random_case
from scipy.optimize import fsolve, least_squares, minimize
from scipy.spatial.transform import Rotation

import cdpr
from cdpr.base.errors import CdprError
from cdpr.mechanics.equilibrium import find_equilibrium
from cdpr.mechanics.kinematics import lengths, make_state
from cdpr.mechanics.potential import Potential

DOWN = (0.0, 0.0, -G)
ROBOTS = ROOT / "scenarios" / "robots"


def path(robot, pose):
    return lengths(robot, make_state(pose[:3], pose[3:]))


def softer(name, axial):
    robot = cdpr.load_robot(ROBOTS / f"{name}.yaml")
    return robot.replace(cables=[cable.replace(axial_stiffness=axial) for cable in robot.cables])


def statics(anchors, target, axial, mass):
    """Rest (3,) of a point on elastic lines with the lengths of a target, by least squares of the forces."""
    unwound = np.linalg.norm(anchors - target, axis=1)

    def force(point):
        d = anchors - point
        length = np.linalg.norm(d, axis=1)
        pull = np.maximum(axial * (length - unwound) / unwound, 0.0)
        return (d / length[:, None]).T @ pull - [0.0, 0.0, mass * G]

    return least_squares(force, target - [0.0, 0.0, 1e-3], xtol=1e-15, ftol=1e-15, gtol=1e-15).x


@pytest.mark.core
@pytest.mark.parametrize(
    ("name", "target", "axial", "low", "slack"),
    [  # mm, as measured in the statics of the reports on camera robots and Hangprinters
        ("camera_robot", [0.8, 0.5, 1.5], 2e3, 143.279, []),
        ("camera_robot", [0.8, 0.5, 1.5], 2e4, 15.658, []),
        ("camera_robot", [0.8, 0.5, 1.5], 2e5, 1.582, []),
        ("hangprinter", [0.4, 0.2, 0.6], 2e4, 13.111, [2]),
    ],
)
def test_robots_with_given_lengths_rest_at_the_pose_of_the_statics(name, target, axial, low, slack):
    robot, target = softer(name, axial), np.array(target)
    pose = np.array([*target, 1.0, 0.0, 0.0, 0.0])
    found = cdpr.equilibrium(robot, lengths=path(robot, pose), start=pose)
    expected = statics(robot.anchors[:, :3], target, axial, robot.platform.mass)
    assert found.converged
    np.testing.assert_allclose(found.pose[:3], expected, atol=1e-9)
    assert 1e3 * np.linalg.norm(found.pose[:3] - target) == pytest.approx(low, abs=5e-4)
    assert np.flatnonzero(found.slack).tolist() == slack
    assert found.stability == "stable"


def test_stiffer_cables_approach_the_inextensible_one_in_proportion():
    target = np.array([0.8, 0.5, 1.5, 1.0, 0.0, 0.0, 0.0])
    rigid = cdpr.load_robot(ROBOTS / "camera_robot.yaml", overrides={"cable.model": "rigid", "winch.type": "torque"})
    unwound = path(rigid, target)[:3]

    def rest(model, axial):
        cables = [cable.replace(model=model, axial_stiffness=axial) for cable in rigid.cables[:3]]
        return cdpr.equilibrium(rigid.replace(cables=cables), lengths=unwound, start=target).pose[:3]

    exact = rest("ideal", 1.0)
    np.testing.assert_allclose(exact, target[:3], atol=1e-12)
    error = [np.linalg.norm(rest("elastic", axial) - exact) for axial in (1e5, 1e6, 1e7)]
    assert error[0] / error[1] == pytest.approx(10.0, rel=0.02)
    assert error[1] / error[2] == pytest.approx(10.0, rel=0.02)


COUNT = 40
THOUSANDS = int(os.environ.get("CDPR_THOUSANDS", "1"))  # of random robots


@pytest.mark.parametrize(
    "seeds",
    [range(COUNT), *(pytest.param(range(1000 * k, 1000 * (k + 1)), marks=pytest.mark.slow) for k in range(THOUSANDS))],
)
def test_random_robots_are_at_rest_at_a_minimum_of_their_energy(seeds):
    """Force below 1e-9 of the load; no lower energy nearby, by numpy alone; lengths kept by inextensible cables."""
    rests = 0
    for seed in seeds:
        robot, unwound, tension, start = random_case(seed)
        found = find_equilibrium(robot, unwound, tension, start, DOWN)
        if not found.converged:
            assert "no pose near the start" in found.problem or "into its exit" in found.problem, seed
            continue
        rests += 1
        assert found.residual <= 1e-9 * found.load
        length = path_lengths(robot, found.pose)
        stretches = np.array([cable.model == "elastic" for cable in robot.cables]) & ~np.isnan(unwound)
        rigid = ~stretches & ~np.isnan(unwound)
        size = float(np.abs(robot.anchors).max())
        assert (length - unwound)[rigid].max(initial=0.0) <= 1e-8 * size
        assert (np.abs(length - unwound) <= 1e-8 * size)[rigid & ~found.slack].all()
        if found.stability == "unstable":
            continue
        # the tensions of inextensible cables are the multipliers of an augmented Lagrangian with this minimum
        held, free = np.where(stretches, unwound, np.nan), np.where(stretches, np.nan, tension)
        energy = energy_of(robot, held, np.nan_to_num(free), found.pose)
        rng, at_rest = np.random.default_rng(seed), Potential(robot, DOWN, unwound, tension)
        for h in (1e-3, 1e-4):
            pose = at_rest.moved(found.pose, h * size * rng.normal(size=robot.n))
            excess = np.where(rigid, path_lengths(robot, pose) - unwound, 0.0)
            change = energy_of(robot, held, np.nan_to_num(free), pose) - energy
            over, hard = np.maximum(excess, 0.0), 1e4 * at_rest.weight / size
            work = found.tension @ over + 0.5 * hard * over @ over  # to stretch them
            assert not change + work < -1e-3 * h * h * at_rest.weight * size - 1e-9 * at_rest.weight * size, seed
    assert rests > 0.95 * len(seeds)


@pytest.mark.parametrize("seeds", [range(12), pytest.param(range(12, 12 + 100 * THOUSANDS), marks=pytest.mark.slow)])
def test_scipy_finds_no_lower_energy_nearby_and_returns_to_stable_poses(seeds):
    """Elastic robots of all kinds, released a little beside their rest; the energy is that of numpy."""
    compared = 0
    for seed in seeds:
        robot, unwound, tension, start = random_case(seed)
        if any(cable.model != "elastic" for cable in robot.cables):
            continue
        found = find_equilibrium(robot, unwound, tension, start, DOWN)
        at_rest = Potential(robot, DOWN, unwound, tension)
        unit = at_rest.weight * at_rest.size

        def energy(step, at_rest=at_rest, pose=found.pose, given=(robot, unwound, tension), unit=unit):
            return energy_of(*given, at_rest.moved(pose, at_rest.size * step)) / unit

        beside = 1e-3 * np.random.default_rng(seed).normal(size=robot.n)
        other = minimize(energy, beside, method="BFGS", options={"gtol": 1e-9})
        assert other.fun >= energy(np.zeros(robot.n)) - 1e-9, seed
        soft = found.eigenvalues[0] * at_rest.size / at_rest.weight  # scipy gets as near as its differences allow
        # If a cable is just taut, poses beside it with the cable slack may have the same energy.
        just_taut = (np.abs(path_lengths(robot, found.pose) - unwound) < 1e-12 * at_rest.size).any()
        if found.stability == "stable" and soft > 0.1 and not just_taut:
            assert np.linalg.norm(other.x) < 1e-3, seed
            compared += 1
    assert compared > 0.1 * len(seeds)


@pytest.mark.parametrize("name", ["caroca_winches", "hangprinter", "cogiro_pulleys", "seven", "planar", "point_mass"])
def test_the_platform_rests_where_the_lengths_are_compensated_for(name):
    robot, rng = cdpr.load_robot(name), np.random.default_rng(2)
    poses = np.tile(robot.home, (5, 1))
    slides = [row for row in robot.rows if row < 3]
    poses[:, slides] += rng.uniform(-0.1, 0.1, (5, len(slides)))
    wanted = cdpr.compensated_lengths(robot, poses)
    for pose, unwound, tension, feasible in zip(poses, wanted.lengths, wanted.tension, wanted.feasible, strict=True):
        assert feasible
        found = cdpr.equilibrium(robot, lengths=unwound)
        assert found.converged
        np.testing.assert_allclose(found.pose, pose, atol=1e-9)
        if name in ("caroca_winches", "hangprinter"):  # tensions of inextensible cables may be others
            np.testing.assert_allclose(found.tension, tension, rtol=1e-6, atol=1e-6 * tension.max())


def test_a_pendulum_swings_with_its_frequency_and_may_swing_freely():
    body = cdpr.Platform(2.0, np.eye(3) * 0.1, [0.0, 0.0, -0.2])
    robot = cdpr.Robot(body, [cdpr.Cable([0, 0, 3.0], [0, 0, 0.0], 0.0, 1e3)], ["ry"], home=[0.0, 0.0, 1.0])
    found = cdpr.equilibrium(robot, lengths=[2.5])
    inertia = 0.1 + 2.0 * 0.2**2
    assert found.slack.all()
    assert found.frequencies == pytest.approx([np.sqrt(2.0 * G * 0.2 / inertia) / (2.0 * np.pi)])
    np.testing.assert_allclose(np.abs(found.free_directions), [[0, 0, 0, 0, 1, 0]])
    above = [0.0, 0.0, 1.0, np.cos(1.5), 0.0, np.sin(1.5), 0.0]
    assert cdpr.equilibrium(robot, lengths=[2.5], start=above).pose[3:] == pytest.approx([1, 0, 0, 0], abs=1e-9)


@pytest.mark.parametrize("name", ["hangprinter", "v_plotter", "point_mass", "caroca_winches"])
def test_sensitivities_are_those_of_differences(name):
    robot = cdpr.load_robot(name)
    pose = robot.home.copy()
    pose[0] += 0.05
    unwound = cdpr.compensated_lengths(robot, robot.home).lengths
    found, h = cdpr.equilibrium(robot, lengths=unwound), 1e-5
    for i in range(robot.m):
        ends = [cdpr.equilibrium(robot, lengths=unwound + sign * h * np.eye(robot.m)[i]).pose for sign in (1.0, -1.0)]
        turn = cdpr.model.rotations.between(ends[1][3:], ends[0][3:])
        change = np.concatenate([ends[0][:3] - ends[1][:3], turn]) / (2.0 * h)
        if robot.cables[i].model == "ideal" or name == "point_mass":
            np.testing.assert_allclose(found.sensitivity[:, i], change, rtol=1e-4, atol=1e-4)
        else:
            np.testing.assert_allclose(found.sensitivity[:, i], change, rtol=2e-3, atol=2e-3)


def test_given_tensions_balance_and_mix_with_lengths():
    frame = [[-1.0, 0.0, 2.0], [1.0, 0.0, 2.0], [0.0, 0.0, -1.0]]
    robot = cdpr.Robot.from_points(frame, [[0.0, 0.0, 0.0]] * 3, mass=2.0, dof=["x", "z"])
    found = cdpr.equilibrium(robot, lengths=[1.25, 1.25, np.nan], tensions=[np.nan, np.nan, 30.0])
    assert found.pose[2] == pytest.approx(1.25)
    assert found.tension == pytest.approx([(2 * G + 30) / 1.2, (2 * G + 30) / 1.2, 30.0])
    pulled = cdpr.equilibrium(robot, tensions=[30.0, 30.0, 10.0])
    assert pulled.converged
    u = (np.array(frame) - pulled.pose[:3]) / pulled.length[:, None]
    np.testing.assert_allclose(u.T @ [30.0, 30.0, 10.0], [0.0, 0.0, 2.0 * G], atol=1e-7)


def test_a_platform_that_nothing_holds_falls():
    robot = cdpr.Robot.from_points([[0.0, 0.0, 2.0]], [[0.0, 0.0, 0.0]], mass=2.0, dof=["x", "y", "z"])
    start = [0.1, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0]
    found = cdpr.equilibrium(robot, tensions=[5.0], start=start)
    assert not found.converged
    assert "moves away" in found.problem
    into = cdpr.equilibrium(robot, tensions=[50.0], start=start)
    assert not into.converged
    assert "into its exit" in into.problem


@pytest.mark.parametrize("wrong", [0, 3, 7])
def test_a_wrong_length_of_inextensible_cables_is_found(wrong):
    robot = cdpr.load_robot("crossed")
    unwound = path(robot, robot.home)
    unwound[wrong] -= 0.2
    found = cdpr.equilibrium(robot, lengths=unwound)
    assert not found.converged
    assert found.misfit > 0.01
    assert found.suspect == wrong
    assert f"without cable 'cable_{wrong + 1}'" in found.problem


def suspended(seed, m):
    """Anchors on a circle, of a platform with its centre of mass off its origin, and lengths."""
    rng = np.random.default_rng(seed)
    angle = np.arange(m) * 2.0 * np.pi / m + rng.uniform(-0.3, 0.3, m)
    A = np.column_stack([2.0 * np.cos(angle), 2.0 * np.sin(angle), 3.0 + rng.uniform(-0.2, 0.2, m)])
    B = np.column_stack([0.4 * np.cos(angle), 0.4 * np.sin(angle), rng.uniform(-0.1, 0.2, m)])
    return A, B, rng.uniform(-0.1, 0.1, 3), rng.uniform(1.8, 3.0, m), rng


def search(A, B, center, L, rng, count):
    """Poses (12,) at rest with any taut cables, by roots of the equations of force, moment and lengths."""
    found = []
    for size in range(1, len(A) + 1):
        for taut in map(list, itertools.combinations(range(len(A)), size)):

            def equations(y, taut=taut):
                R = Rotation.from_rotvec(y[3:6]).as_matrix()
                b = B[taut] @ R.T
                d = A[taut] - y[:3] - b
                length = np.linalg.norm(d, axis=1)
                u = d / length[:, None]
                moment = np.cross(b, u).T @ y[6:] + np.cross(R @ center, [0.0, 0.0, -1.0])
                return np.concatenate([u.T @ y[6:] - [0.0, 0.0, 1.0], moment, length - L[taut]])

            for _ in range(count):
                turn = Rotation.random(random_state=int(rng.integers(2**31))).as_rotvec()
                first = [*rng.uniform(-1.5, 1.5, 2), rng.uniform(-1.0, 5.0), *turn, *rng.uniform(0.0, 1.0, size)]
                y = fsolve(equations, first, xtol=1e-13, full_output=True)[0]
                R = Rotation.from_rotvec(y[3:6]).as_matrix()
                length = np.linalg.norm(A - y[:3] - B @ R.T, axis=1)
                good = np.abs(equations(y)).max() < 1e-10 and y[6:].min() > 1e-9 and (length < L + 1e-9).all()
                key = np.concatenate([y[:3], R.ravel()])
                if good and all(np.abs(key - other).max() > 1e-5 for other in found):
                    found.append(key)
    return found


@pytest.mark.slow
@pytest.mark.parametrize("m", [3, 4])
@pytest.mark.parametrize("seed", range(max(1, THOUSANDS)))
def test_all_equilibria_of_suspended_robots_are_found(m, seed):
    A, B, center, L, rng = suspended(seed, m)
    cables = [cdpr.Cable(a, b, 0.0, 1e4) for a, b in zip(A, B, strict=True)]
    robot = cdpr.Robot(cdpr.Platform(5.0, np.eye(3) * 0.3, center), cables, home=[0.0, 0.0, 1.0])
    mine = [
        np.concatenate([one.pose[:3], cdpr.model.rotations.matrix(one.pose[3:]).ravel()])
        for one in cdpr.equilibria(robot, lengths=L)
    ]
    others = search(A, B, center, L, rng, 40)
    assert others
    for other in others:
        assert min(np.abs(other - one).max() for one in mine) < 1e-5


@pytest.mark.slow
def test_equilibria_of_a_v_plotter_are_below_and_above():
    found = cdpr.equilibria("v_plotter", lengths=[1.2, 1.3], starts=10)
    assert [one.stability for one in found] == ["stable", "unstable"]
    assert found[0].pose == pytest.approx(cdpr.equilibrium("v_plotter", lengths=[1.2, 1.3]).pose, abs=1e-9)
    again = cdpr.equilibria("v_plotter", lengths=[1.2, 1.3], starts=10)
    np.testing.assert_array_equal(found[1].pose, again[1].pose)


def test_drum_angles_count_from_home():
    robot = cdpr.load_robot("hangprinter")
    radius = robot.cables[0].winch.drum_radius
    unwound = path(robot, robot.home)
    angles = np.array([0.3, -0.2, 0.1, -0.4])
    found = cdpr.equilibrium(robot, drum_angles=angles)
    np.testing.assert_allclose(found.unwound, unwound - radius * angles, rtol=1e-15)


GOOD = [1.2, 1.3]


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({}, "cable 'left': expected one value in lengths, tensions or drum_angles, got none"),
        ({"lengths": GOOD, "tensions": GOOD}, "got 2"),
        ({"lengths": [1.0]}, r"lengths: the shape must be \(2,\)"),
        ({"lengths": [1.0, -1.0]}, "^lengths: cable 'right': expected an unwound length of .* m, got -1$"),
        ({"lengths": [1.0, 1e300]}, "an unwound length of more than 0 and at most 1e\\+09 m, got 1e\\+300"),
        (
            {"drum_angles": [1.0, 1e4]},
            r"^drum_angles: cable 'right': expected an unwound length of .* got -\d+(\.\d+)? at 10000 rad$",
        ),
        ({"lengths": [1.0, np.inf]}, "lengths: expected finite numbers"),
        ({"tensions": [1.0, -1.0]}, "cable 'right': expected at least 0 N"),
        ({"lengths": GOOD, "start": np.zeros(7)}, "quaternion of length 1"),
        ({"lengths": GOOD, "start": [0, 0, 1, 0, 1, 0, 0]}, "rotations about the axes of x, z, ry only"),
        ({"lengths": GOOD, "start": [-0.65, 0, 2 - 0.02, 1, 0, 0, 0], "gravity": [0, 0, np.nan]}, "gravity"),
    ],
)
def test_wrong_arguments_are_refused(given, text):
    with pytest.raises(CdprError, match=text):
        cdpr.equilibrium("v_plotter", **given)


@pytest.mark.filterwarnings("ignore:lengths:UserWarning")
@pytest.mark.parametrize("value", [1e-300, 1e-9, 1e6])
@pytest.mark.parametrize("name", ["v_plotter", "cogiro_pulleys", "crossed"])
def test_extreme_values_end_with_a_result(name, value):
    robot = cdpr.load_robot(name)
    for given in ("lengths", "tensions"):
        found = cdpr.equilibrium(robot, **{given: np.full(robot.m, value)})
        assert found.converged == (not found.problem)


def test_drum_angles_need_a_drum_and_searches_whole_numbers():
    with pytest.raises(CdprError, match=r"expected a winch with a drum radius \(winch.drum_radius\), got none"):
        cdpr.equilibrium("caroca", drum_angles=np.zeros(8))
    for name in ("starts", "seed"):
        with pytest.raises(CdprError, match=f"equilibria\\({name}=\\): expected a whole number"):
            cdpr.equilibria("v_plotter", lengths=GOOD, **{name: -1})
