"""The controller `adaptive`: its law, the decrease of its Lyapunov function, and convergence of the estimates."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import GRAVITY, ROOT, random_state
from plants import installed
from restarts import assert_restarts_give

import cdpr
from cdpr.base.errors import CdprError
from cdpr.mechanics import dynamics
from cdpr.model import rotations
from cdpr.tension import Status
from cdpr_controllers import AdaptiveOptions
from cdpr_controllers.adaptive import Adaptive

CAROCA = str(ROOT / "scenarios" / "caroca.yaml")
STEP = 1e-3
EXACT = 1e-9  # N, of wrenches of the order of 1e3
MASS, INERTIA = 150.0, np.diag([6.5, 20.0, 22.5])  # of CAROCA, kg and kg m^2
EVERY = 20  # samples: within one, the sampled law can raise V by 1e-5 of its start
LOAD, PLACE = 40.0, np.array([0.15, -0.1, 0.12])  # kg and m, point mass


def skew(v):
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def inertia_about_origin(mass, center, inertia):
    return inertia + mass * skew(center) @ skew(center).T


def mass_matrix(mass, h, inertia):
    """Of a rigid body about its origin, with first moment h; (6, 6)."""
    return np.block([[mass * np.eye(3), -skew(h)], [skew(h), inertia]])


def coriolis(h, inertia, omega):
    """C with C (v, omega) the velocity-dependent wrench, and M' - 2 C skew: half of M', and a skew matrix."""
    rate = np.block(
        [
            [np.zeros((3, 3)), -skew(np.cross(omega, h))],
            [skew(np.cross(omega, h)), skew(omega) @ inertia - inertia @ skew(omega)],
        ]
    )
    turning = skew(np.cross(omega, h))
    rest = 0.5 * np.block([[np.zeros((3, 3)), -turning], [-turning, -skew(inertia @ omega)]])
    np.testing.assert_allclose(rest, -rest.T, atol=1e-12)
    return 0.5 * rate + rest


def law(body, theta, state, desired, slope, kd):
    """Wrench, and the derivative of s . wrench by (mass, first moment in platform axes), by differences."""
    mass0, center0, inertia0 = body
    R = rotations.matrix(state[3:7])
    omega, turn = (
        state[10:13],
        rotations.rotation_vector(rotations.multiply(desired[3:7], rotations.conjugate(state[3:7]))),
    )
    rate = desired[7:13] - state[7:13]
    s = rate + slope * np.concatenate([desired[:3] - state[:3], turn])
    reference, acceleration = state[7:13] + s, desired[13:] + slope * rate
    acceleration[:3] -= GRAVITY
    inertia = R @ inertia_about_origin(mass0, center0, inertia0) @ R.T

    def model(values):
        h = R @ values[1:]
        return mass_matrix(values[0], h, inertia) @ acceleration + coriolis(h, inertia, omega) @ reference

    damping = kd * np.concatenate([mass0 * s[:3], inertia @ s[3:]])
    slopes = [s @ (model(theta + step) - model(theta)) for step in np.eye(4)]  # linear in theta
    return model(theta) + damping, np.array(slopes), s


def test_the_law_and_its_adaptation(offset_robot):
    rng = np.random.default_rng(5)
    platform = offset_robot.platform
    options = AdaptiveOptions(slope=4.0, kd=6.0, mass_gain=0.03, center_gain=0.002, center_max=2.0)
    controller = Adaptive(offset_robot, GRAVITY, STEP, options)
    columns = {"estimated_mass": np.zeros(1), "estimated_center": np.zeros(3)}
    controller.log(columns)
    body = platform.mass, platform.center_of_mass, platform.inertia
    theta = np.concatenate([[platform.mass], platform.mass * platform.center_of_mass])
    gains = platform.mass * np.array([0.03, 0.002, 0.002, 0.002])
    for _ in range(20):
        state = random_state(rng)
        desired = np.concatenate([random_state(rng), rng.normal(size=6)])
        out = np.zeros(6)
        controller.control(0.0, state, desired, out)
        expected, slopes, _ = law(body, theta, state, desired, 4.0, 6.0)
        np.testing.assert_allclose(out, expected, rtol=1e-10, atol=EXACT)
        assert columns["estimated_mass"][0] == pytest.approx(theta[0], rel=1e-12)
        np.testing.assert_allclose(columns["estimated_center"], theta[1:] / theta[0], atol=1e-12)
        theta += STEP * gains * slopes
    assert abs(theta[0] / platform.mass - 1.0) > 1e-3


def test_the_model_of_the_tests_is_that_of_a_rigid_body(offset_robot):
    """With the reference velocity equal to the velocity."""
    rng, platform = np.random.default_rng(6), offset_robot.platform
    theta = np.concatenate([[platform.mass], platform.mass * platform.center_of_mass])
    for _ in range(5):
        state = random_state(rng)
        desired = np.concatenate([state, rng.normal(size=6)])
        body = platform.mass, platform.center_of_mass, platform.inertia
        expected = dynamics.required_wrench(offset_robot, state, GRAVITY, desired[13:16], desired[16:])
        np.testing.assert_allclose(law(body, theta, state, desired, 3.0, 2.0)[0], expected, atol=EXACT)


def test_it_does_not_adapt_while_the_cables_cannot_follow(offset_robot):
    rng = np.random.default_rng(7)
    state, desired = random_state(rng), np.concatenate([random_state(rng), rng.normal(size=6)])
    controller, report = Adaptive(offset_robot, GRAVITY, STEP, AdaptiveOptions(center_max=2.0)), np.zeros(4)
    controller.connect(report)
    answers = np.zeros((4, 6))
    report[0] = Status.INFEASIBLE
    for out in answers[:3]:
        controller.control(0.0, state, desired, out)
    report[0] = Status.OK
    controller.control(0.0, state, desired, answers[2])
    controller.control(0.0, state, desired, answers[3])
    assert np.array_equal(answers[0], answers[1])
    assert np.array_equal(answers[1], answers[2])
    assert np.abs(answers[3] - answers[2]).max() > 0.1


def test_the_estimates_stay_within_their_range(offset_robot):
    state = np.zeros(19)
    state[3] = 1.0
    desired = state.copy()
    desired[:3], desired[3:7] = [1.0, 1.0, 5.0], rotations.from_rpy(1.0, 1.0, 0.0)
    for sign, mass in ((1.0, 3.0), (-1.0, 0.5)):
        options = AdaptiveOptions(mass_gain=10.0, center_gain=10.0, mass_min=0.5, mass_max=3.0, center_max=0.4)
        controller, columns = Adaptive(offset_robot, GRAVITY, STEP, options), (np.zeros(1), np.zeros(3))
        controller.log({"estimated_mass": columns[0], "estimated_center": columns[1]})
        target = desired.copy()
        target[:3] *= sign
        for _ in range(500):
            controller.control(0.0, state[:13], target, np.zeros(6))
        assert columns[0][0] == pytest.approx(mass * offset_robot.platform.mass)
        assert np.abs(columns[1]).max() == pytest.approx(0.4)
    with pytest.raises(CdprError, match=r"a coordinate of 0\.\d+ m, .* set center_max above it, now 0.001 m"):
        Adaptive(offset_robot, GRAVITY, STEP, AdaptiveOptions(center_max=0.001))


def loaded(duration, exciting, **law):
    """CAROCA carries a load that the controller does not know, in a motion that tilts it or does not."""
    points = [(1.0, 0.4, 0.3, 0.0), (2.0, -0.3, 0.0, 0.3), (3.0, 0.3, -0.3, -0.2), (4.0, 0.0, 0.2, -0.3)]
    waypoints = [
        {"time": 4.0 * lap + time, "position": [x, -x / 2, 1.2 + x / 2], "orientation": {"rpy": [roll, pitch, 0.0]}}
        for lap in range(int(duration // 4))
        for time, x, roll, pitch in points
    ]
    motion = {"type": "waypoints", "points": waypoints} if exciting else {"type": "hold"}
    center = LOAD * PLACE / (MASS + LOAD)
    own = INERTIA + MASS * LOAD / (MASS + LOAD) * skew(PLACE) @ skew(PLACE).T
    # The nominal inertia about the origin is the true one, as the proof requires.
    nominal = inertia_about_origin(MASS + LOAD, center, own)
    indices = ([0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2])
    changes = {
        "robot.platform": {"mass": MASS + LOAD, "center_of_mass": center.tolist(), "inertia": own[indices].tolist()},
        "believed": {"platform": {"mass": MASS, "center_of_mass": [0, 0, 0], "inertia": nominal[indices].tolist()}},
        "trajectory": motion,
        "simulation.duration": duration,
        "controller": {"type": "adaptive", **law},
    }
    run = cdpr.simulate(CAROCA, overrides=changes)
    return run, np.array([MASS + LOAD, *(LOAD * PLACE)]), nominal


def lyapunov(run, truth, nominal, slope, gains):
    values = []
    for k in range(0, len(run.time), EVERY):
        R, q = rotations.matrix(run.orientation[k]), run.orientation[k]
        turn = rotations.rotation_vector(rotations.multiply(run.desired_orientation[k], rotations.conjugate(q)))
        rate = np.concatenate(
            [run.desired_velocity[k] - run.velocity[k], run.desired_angular_velocity[k] - run.angular_velocity[k]]
        )
        s = rate + slope * np.concatenate([run.desired_position[k] - run.position[k], turn])
        M = mass_matrix(truth[0], R @ truth[1:], R @ nominal @ R.T)
        mass = run["estimated_mass"][k].item()
        error = np.array([mass, *(mass * run["estimated_center"][k])]) - truth
        values.append(0.5 * s @ M @ s + 0.5 * error @ (error / gains))
    return np.array(values)


def test_the_lyapunov_function_falls_and_the_estimates_converge():
    law = {"slope": 5.0, "kd": 10.0, "mass_gain": 0.2, "center_gain": 0.03}
    run, truth, nominal = loaded(40.0, True, **law)
    V = lyapunov(run, truth, nominal, 5.0, MASS * np.array([0.2, 0.03, 0.03, 0.03]))
    assert np.diff(V).max() < 1e-6 * V[0]  # at the end, sampling keeps V at 2e-5 of its start
    assert V[-1] < 1e-3 * V[0]
    mass = run["estimated_mass"][-1].item()
    assert mass == pytest.approx(truth[0], rel=2e-3)
    np.testing.assert_allclose(run["estimated_center"][-1], truth[1:] / truth[0], atol=1e-3)  # m


def test_without_excitation_the_height_of_the_centre_is_not_found_but_the_error_vanishes():
    run, truth, _ = loaded(6.0, False)
    assert np.linalg.norm(run.position_error[-1]) < 1e-5
    assert run["estimated_mass"][-1].item() == pytest.approx(truth[0], rel=1e-3)
    np.testing.assert_allclose(run["estimated_center"][-1, :2], truth[1:3] / truth[0], atol=1e-3)
    assert abs(run["estimated_center"][-1, 2] - truth[3] / truth[0]) > 0.01


@pytest.mark.parametrize("backend", installed("reference", "mujoco"))
def test_snapshots_resets_and_rollouts_have_the_same_bits(backend):
    overrides = {"simulation.duration": 0.05, "controller.type": "adaptive", "believed.platform.mass": 130.0}
    overrides |= {"simulation.backend": backend}
    whole = cdpr.simulate(CAROCA, overrides=overrides)
    assert whole.interpreted == ()
    assert_restarts_give(whole.rows.tobytes(), CAROCA, overrides)
    columns = ["position", "wrench", "estimated_mass", "estimated_center"]
    batch = cdpr.rollout(
        CAROCA, 9, vary={"controller.mass_gain": [0.1 * k for k in range(9)]}, overrides=overrides, columns=columns
    )
    for i in (0, 8):
        single = cdpr.simulate(CAROCA, overrides={**overrides, "controller.mass_gain": 0.1 * i})
        assert all(batch[name][i].tobytes() == np.ascontiguousarray(single[name]).tobytes() for name in columns)
