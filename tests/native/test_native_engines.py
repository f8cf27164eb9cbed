"""Operations between engines and our states: against rotations by scipy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cdpr.native.bind import bind

RNG = np.random.default_rng(3)
Q = Rotation.random(rng=np.random.default_rng(4))
w, x, y, z = Q.as_quat(scalar_first=True).tolist()
BODY, WRENCH, TURN = RNG.normal(size=13), RNG.normal(size=6), Rotation.from_rotvec([0.6, 0.5, 0.4])


def state(**given):
    return np.concatenate([given["p"], given["q"], given["v"], given["w"]])


def test_states_of_joints_of_mujoco():
    body, rates, home = np.empty(13), RNG.normal(size=6), RNG.normal(size=3)
    bind("mujoco_free_state", coordinates=np.array([1.0, 2.0, 3.0, w, x, y, z]), rates=rates, body=body)()
    expected = state(p=[1.0, 2.0, 3.0], q=[w, x, y, z], v=rates[:3], w=Q.apply(rates[3:]))
    np.testing.assert_allclose(body, expected, atol=1e-15)
    bind("mujoco_ball_state", home=home, coordinates=np.array([w, x, y, z]), rates=rates[:3].copy(), body=body)()
    np.testing.assert_allclose(body, state(p=home, q=[w, x, y, z], v=np.zeros(3), w=Q.apply(rates[:3])), atol=1e-15)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_states_of_bodies_of_bullet(sign):
    body = np.zeros(13)
    body[3:7] = sign * np.array([w, x, y, z])  # the sign that is kept
    base, home, axes = RNG.normal(size=13), RNG.normal(size=3), Rotation.random(rng=np.random.default_rng(5))
    base[3:7] = x, y, z, w
    bind("bullet_base_state", base=base, body=body)()
    expected = state(p=base[:3], q=sign * np.array([w, x, y, z]), v=base[7:10], w=base[10:])
    np.testing.assert_array_equal(body, expected)
    rate = RNG.normal(size=3)
    joint = np.concatenate([(axes.inv() * Q * axes).as_quat(), rate])
    bind("bullet_ball_state", home=home, axes=axes.as_quat(scalar_first=True), joint=joint, body=body)()
    turned = (Q * axes).apply(rate)
    np.testing.assert_allclose(body, state(p=home, q=expected[3:7], v=np.zeros(3), w=turned), atol=1e-15)


def test_forces_of_joints_of_dart():
    body = BODY.copy()
    body[3:7] = w, x, y, z
    kept = np.concatenate([TURN.as_quat(scalar_first=True), np.zeros(3)])
    free, ball, guided = np.empty(6), np.empty(3), np.empty(2)
    wrench = WRENCH.copy()
    given = {"body": body, "applied": wrench}
    calls = [
        bind("dart_free_forces", **given, forces=free),
        bind("dart_ball_forces", kept=kept, **given, forces=ball),
        bind("dart_guide_forces", rows=np.array([2, 4]), **given, forces=guided),
    ]
    assert [call() for call in calls] == [0, 0, 0]
    np.testing.assert_array_equal(free, np.concatenate([wrench[3:], wrench[:3]]))
    np.testing.assert_allclose(ball, (Q * TURN).inv().apply(wrench[3:]), atol=1e-15)
    np.testing.assert_array_equal(guided, wrench[[2, 4]])
    for bad in (np.nan, 2e12):  # DART must not step then
        wrench[0] = bad
        for call in calls:
            call()
        assert np.isnan([free[0], ball[0], guided[0]]).all()


def test_dart_s_attitude_follows_by_the_exact_turn():
    step, body = 0.01, BODY.copy()
    body[3:7] = w, x, y, z
    rates, coordinates = RNG.normal(size=6), RNG.normal(size=6)
    kept, position = TURN.as_quat(scalar_first=True), coordinates[3:].copy()
    code = bind("dart_follow_free", kept=kept, rates=rates, coordinates=coordinates, body=body, step=step)()
    turned = Rotation.from_rotvec(step * rates[:3]) * Q
    expected = state(p=position, q=turned.as_quat(scalar_first=True), v=rates[3:], w=rates[:3])
    np.testing.assert_allclose(body[3:7] * np.sign(body[3] * expected[3]), expected[3:7], atol=1e-15)
    np.testing.assert_array_equal(np.delete(body, slice(3, 7)), np.delete(expected, slice(3, 7)))
    vector = (turned * TURN).as_rotvec()
    np.testing.assert_allclose(coordinates, [*vector, *position], atol=1e-14)
    assert code == (np.linalg.norm(vector) < 0.2)

    body[3:7] = w, x, y, z
    kept = np.concatenate([Q.inv().as_quat(scalar_first=True), np.zeros(3)])  # DART's axes lie along the world's
    given = {"kept": kept, "rates": rates[:3].copy(), "coordinates": np.empty(3), "body": body, "step": step}
    given["coordinates"][:] = 1.0
    assert bind("dart_follow_ball", **given)() == 1
    np.testing.assert_allclose(given["coordinates"], step * rates[:3], atol=1e-14)
    np.testing.assert_allclose(body[10:], rates[:3], atol=1e-15)


def test_signals_of_an_fmu():
    place, index = np.array([3, 0]), np.array([1, 2])
    scale, offset = np.array([0.5, 2.0]), np.array([10.0, 0.0])
    values, signals = np.array([1.0, 2.0, 3.0]), np.full(4, 7.0)
    joined = {"place": place, "index": index, "scale": scale, "offset": offset}
    bind("gather_signals", **joined, values=values, signals=signals)()
    np.testing.assert_array_equal(signals, [6.0, 7.0, 7.0, 11.0])
    back = np.full(3, 5.0)
    bind("scatter_signals", **joined, signals=signals, values=back)()
    np.testing.assert_array_equal(back, [5.0, 2.0, 3.0])


@pytest.mark.parametrize(("length", "expected"), [(1.0 + 1e-7, 1.0), (1.0 + 1e-14, 1.0 + 1e-14), (1.1, 1.1)])
def test_only_what_is_nearly_a_unit_quaternion_is_scaled(length, expected):
    body = BODY.copy()
    body[3:7] = length * np.array([w, x, y, z])
    bind("normalise_attitude", state=body, near=1e-6)()
    np.testing.assert_allclose(np.linalg.norm(body[3:7]), expected, rtol=1e-15)
