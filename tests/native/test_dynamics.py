"""Bodies, guides and integrators of the kernel library, against numpy, and each lane against doubles."""

from __future__ import annotations

import numpy as np
import pytest
from kernel_cases import assert_same_bits, numbers, run, run_lanes

from cdpr.cables import Pulley
from cdpr.mechanics.body_frame import BodyFrame, body_state, platform_state, wrench_on_body
from cdpr.mechanics.spherical import pack
from cdpr.native.bind import bind
from cdpr.tension.status import Status

GRAVITY = np.array([0.1, 0.0, -9.81])
STEP = 0.01
BEGINNINGS = ("reference_begin", "spherical_begin", "body_state")  # before the first step: never in lanes


def states(rng, *shape):
    """States, those of usual sizes with quaternions of length one."""
    found = numbers(rng, *shape, 13)
    found[::3, 3:7] /= np.linalg.norm(found[::3, 3:7], axis=1)[:, None]
    return found


def rubbing(rng, count, m):
    """Inputs of the operations of cables on pulleys with friction."""
    lines = np.concatenate([numbers(rng, count, m, 6), np.zeros((count, m, 11))], axis=2)
    lines[..., 6] = 1.0 if m == 8 else np.arange(m) % 2
    pulley = Pulley(radius=0.08, axis=(0.3, -0.2, 0.9), friction=0.2, bearing_friction=0.1, bearing_radius=0.03)
    lines[..., 7:] = pulley.numbers()
    command, external, gravity = (numbers(rng, count, *shape) for shape in ((m,), (6,), (3,)))
    body = states(rng, count)
    push = {"external": external, "offset": numbers(rng, count, 7), "inertial": numbers(rng, count, 4)}
    moving = {"body": body, "momentum": numbers(rng, count, 3), "cable_work": numbers(rng, count, 1)}
    moving["highest"] = np.abs(numbers(rng, count, m))
    moving["last"] = np.full((count, 2 * m + 20), np.nan)
    step = {"lines": lines, "gravity": gravity, "command": command, **push}
    return [
        ("friction_step", step, moving, {"state": 13}, {"step": STEP, "steps": 2}),
        (
            "exit_tensions",
            {"lines": lines, "body": body, "command": command},
            {},
            {"tension": m, "last": 2 * m + 20},
            {},
        ),
    ]


def cases(rng, count, m):
    """Inputs of all integrators."""
    lines, command, external, gravity = (numbers(rng, count, *shape) for shape in ((m, 6), (m,), (6,), (3,)))
    cables = {"lines": lines, "gravity": gravity, "command": command, "external": external}
    body, momentum, motion = states(rng, count), numbers(rng, count, 3), numbers(rng, count, 8)
    full, packed, inertial = numbers(rng, count, 13), numbers(rng, count, 21), numbers(rng, count, 4)
    guide = np.zeros((count, 6))
    guide[:, [0, 2]] = 1.0
    guide[::2, 4] = 1.0
    offset = {"offset": numbers(rng, count, 7)}
    once, twice = {"step": STEP}, {"step": STEP, "steps": 2}
    applied, on_guide = {"gravity": gravity, "applied": external}, {"guide": guide, "inertial": full}
    pull = {"lines": lines, **offset, "tension": command, "external": external, "body": body}
    moving = {"body": body, "momentum": momentum}
    return [
        ("reference_step", cables | offset | {"inertial": inertial}, moving, {"state": 13}, twice),
        ("guided_step", cables | on_guide, {"motion": motion}, {"state": 13}, twice),
        ("spherical_step", cables | {"packed": packed}, {"momentum": momentum, "state": body}, {}, twice),
        ("euler_free_step", applied | {"inertial": inertial}, {"body": body}, {}, once),
        ("euler_spherical_step", applied | {"packed": packed}, {"body": body}, {}, once),
        ("euler_guided_step", applied | on_guide, {"motion": motion}, {"body": 13}, once),
        ("reference_begin", offset | {"moments": gravity}, {"state": body}, {"body": 13, "momentum": 3}, {}),
        ("spherical_begin", {"packed": packed, "state": body}, {}, {"momentum": 3}, {}),
        ("body_state", offset | {"state": body}, {}, {"body": 13}, {}),
        ("platform_state", offset | {"body": body}, {}, {"state": 13}, {}),
        ("applied_wrench", pull, {}, {"applied": 6}, {}),
    ]


def shapes(before, written):
    return {key: value.shape[1:] for key, value in before.items()} | {key: (n,) for key, n in written.items()}


@pytest.mark.parametrize("m", [3, 8])
def test_each_lane_has_the_bits_of_a_double(m):
    rng = np.random.default_rng(m)
    for name, inputs, before, written, values in (*cases(rng, 48, m), *rubbing(rng, 48, m)):
        outputs = shapes(before, written)
        one, codes = run(name, inputs, outputs, before, **values)
        assert not codes.any()
        if name in BEGINNINGS:
            continue
        eight, groups = run_lanes(name, inputs, outputs, before, **values)
        assert not groups.any()
        for key in outputs:
            assert_same_bits(eight[key], one[key])
        assert np.isfinite(one[next(iter(outputs))]).all(axis=1).sum() > 5


@pytest.mark.parametrize("m", [8, 16, 19])
def test_cables_side_by_side_have_the_bits_of_one_after_the_other(m):
    """A further column, by which all leave from points, leads through the other path."""
    rng, count = np.random.default_rng(m), 48
    step, *_, pull = cases(rng, count, m)
    columns = {"lines": step[1]["lines"], "state": step[2]["body"]}, {}, {"length": m, "rate": m}, {}
    for name, inputs, before, written, values in (step, pull, ("geometry", *columns)):
        outputs = shapes(before, written) | ({"matrix": (6, m)} if name == "geometry" else {})
        wide = np.concatenate([inputs["lines"], np.zeros((count, m, 1))], axis=2)
        found, _ = run(name, inputs, outputs, before, **values)
        wanted, _ = run(name, inputs | {"lines": wide}, outputs, before, **values)
        for key in outputs:
            assert_same_bits(found[key], wanted[key])


def turn(q):
    """I + 2 w [a] + 2 [a]^2, a rotation where q is of length one; stages of Runge-Kutta leave that."""
    w, x, y, z = q
    a = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + 2.0 * w * a + 2.0 * a @ a


def cable_forces(anchors, state, tension):
    """Force and moment about the origin."""
    levers = anchors[:, 3:] @ turn(state[3:7]).T
    chords = anchors[:, :3] - state[:3] - levers
    forces = tension[:, None] * chords / np.linalg.norm(chords, axis=1)[:, None]
    return forces.sum(axis=0), np.cross(levers, forces).sum(axis=0)


def rate_of_attitude(q, omega):
    w, x, y, z = q
    return 0.5 * np.array([[-x, -y, -z], [w, z, -y], [-z, w, x], [y, -x, w]]) @ omega


def runge_kutta(slope, y, h):
    a = slope(y)
    b = slope(y + h / 2 * a)
    c = slope(y + h / 2 * b)
    d = slope(y + h * c)
    return y + h / 6 * (a + 2 * b + 2 * c + d)


def test_frames_and_wrench_are_those_of_rigid_bodies(offset_robot):
    rng, frame = np.random.default_rng(1), BodyFrame(offset_robot)
    state = np.concatenate([[0.1, 0.2, 1.0], rng.normal(size=10)])
    state[3:7] /= np.linalg.norm(state[3:7])
    body = body_state(frame.offset, state)
    center = turn(state[3:7]) @ offset_robot.platform.center_of_mass
    np.testing.assert_allclose(body[:3], state[:3] + center, atol=1e-12)
    np.testing.assert_allclose(body[7:10], state[7:10] + np.cross(state[10:], center), atol=1e-12)
    np.testing.assert_allclose(platform_state(frame.offset, body), state, atol=1e-12)
    tension, external = rng.uniform(1.0, 9.0, offset_robot.m), rng.normal(size=6)
    force, moment = cable_forces(offset_robot.anchors, state, tension)
    force, moment = force + external[:3], moment + external[3:]
    applied = wrench_on_body(frame.line_table, frame.offset, tension, external, body)
    np.testing.assert_allclose(applied[:3], force, atol=1e-11)
    np.testing.assert_allclose(applied[3:], moment - np.cross(center, force), atol=1e-11)
    with pytest.raises(ValueError, match=r"body_state: state: expected shape \(13,\)"):
        body_state(frame.offset, state[:7])


@pytest.mark.parametrize("m", [5, 8])
def test_a_step_of_the_reference_is_that_of_numpy(m):
    rng, offset = np.random.default_rng(m), np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    anchors, tension, external = rng.uniform(-4.0, 4.0, (m, 6)), rng.uniform(1.0, 9.0, m), rng.normal(size=6)
    body = np.concatenate([rng.normal(size=3), [0.5, 0.5, -0.5, 0.5], rng.normal(size=6)])
    momentum, state, inertial = np.empty(3), body.copy(), np.array([3.0, 0.4, 0.5, 0.6])
    R = turn(body[3:7])
    momentum[:] = R @ (inertial[1:] * (R.T @ body[10:]))

    def slope(y):
        R = turn(y[3:7])
        force, moment = cable_forces(anchors, y, tension)
        omega = R @ (turn(y[3:7] * [1, -1, -1, -1]) @ y[10:] / inertial[1:])
        return np.concatenate(
            [y[7:10], rate_of_attitude(y[3:7], omega), (force + external[:3]) / 3.0 + GRAVITY, moment + external[3:]]
        )

    wanted = runge_kutta(slope, np.concatenate([body[:10], momentum]), STEP)
    bind(
        "reference_step", lines=anchors, offset=offset, inertial=inertial, gravity=GRAVITY, command=tension,
        external=external, body=body, momentum=momentum, state=state, step=STEP, steps=1,
    )()  # fmt: skip
    np.testing.assert_allclose(body[:3], wanted[:3], rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(body[3:7], wanted[3:7] / np.linalg.norm(wanted[3:7]), rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(body[7:10], wanted[7:10], rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(momentum, wanted[10:], rtol=1e-12, atol=1e-12)
    np.testing.assert_array_equal(state, body)


def test_rows_that_no_wrench_has_are_bad_input():
    applied, forces = np.arange(6.0), np.zeros(2)
    for rows, code in (([0, 5], Status.OK), ([0, 6], Status.BAD_INPUT), ([-1, 0], Status.BAD_INPUT)):
        assert bind("guide_forces", rows=np.array(rows), applied=applied, forces=forces)() == code
    assert bind("guide_forces", rows=np.array([4, 1]), applied=applied, forces=forces)() == Status.OK
    np.testing.assert_array_equal(forces, [4.0, 1.0])


def test_joint_coordinates_become_a_body_state():
    body, home = np.empty(13), np.array([1.0, 2.0, 3.0])
    guide = np.array([1.0, 0.0, 1.0, 0.0, 1.0, 0.0])
    coordinate, rate = np.array([0.1, -0.2, 0.6]), np.array([4.0, 5.0, 6.0])
    bind("guide_state", guide=guide, rows=np.array([0, 2, 4]), home=home, coordinate=coordinate, rate=rate, body=body)()
    angle = [np.cos(0.3), 0.0, np.sin(0.3), 0.0]
    np.testing.assert_allclose(body, [1.1, 2.0, 2.8, *angle, 4.0, 0.0, 5.0, 0.0, 6.0, 0.0])


def test_a_ball_s_momentum_is_that_of_the_inertia_about_the_origin(offset_robot):
    rng, momentum, state = np.random.default_rng(3), np.empty(3), np.zeros(13)
    q = rng.normal(size=4)
    state[3:7], state[10:] = q / np.linalg.norm(q), rng.normal(size=3)
    bind("spherical_begin", packed=pack(offset_robot), state=state, momentum=momentum)()
    R, c, mass = turn(state[3:7]), offset_robot.platform.center_of_mass, offset_robot.platform.mass
    inertia = offset_robot.platform.inertia + mass * (c @ c * np.eye(3) - np.outer(c, c))
    np.testing.assert_allclose(momentum, R @ inertia @ R.T @ state[10:], atol=1e-12)
