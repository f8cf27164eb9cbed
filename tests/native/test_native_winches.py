"""Plants with winches of the kernel library: lanes against doubles, and the acceleration with drums against numpy."""

from __future__ import annotations

import numpy as np
import pytest
from kernel_cases import assert_same_bits, numbers, run, run_lanes
from scipy.spatial.transform import Rotation

from cdpr.cables import Pulley
from cdpr.cables.tables import CHAIN_WIDTH, SPAN, TRANSMISSION
from cdpr.model import rotations

EACH, M = 64, 6
FREE, PLANAR, BALL = (1, 1, 1, 1, 1, 1), (1, 0, 1, 0, 1, 0), (0, 0, 0, 1, 1, 1)
DRUM = np.array([[0.02, 0.1], [5e-4, 1e-2], [0.0, 0.1], [0.0, 0.5], [0.01, 0.2]])  # ranges of a drum's numbers


IDEAL = 1.0, 0.1, 0.0, 1.0, 1.0, 4.0  # numbers of a transmission


def plants(rng, kinds, pulleys, free, geared=False):
    """Inputs of a plant with these kinds (m, 2) of winches and spans, and what its arrays hold before; some hostile."""
    chains = np.zeros((EACH, M, CHAIN_WIDTH))
    chains[..., :2], chains[..., 2] = kinds, rng.choice([0.0, -np.inf])
    chains[..., 3:8] = rng.uniform(*DRUM.T, (EACH, M, 5))
    chains[..., SPAN : SPAN + 2] = rng.uniform([1e3, 0.0], [1e6, 100.0], (EACH, M, 2))
    chains[..., TRANSMISSION:SPAN] = IDEAL
    if geared:  # some of the lanes of some cables
        some = (rng.random((EACH, M, 6)) < 0.5) & (np.arange(M) % 2 == 0)[:, None]
        numbers_of_gears = rng.uniform([0.5, 0.05, 0.0, 1.0, 1.0, 1.0], [1.0, 2.0, 1e-4, 3.0, 4.0, 8.0], (EACH, M, 6))
        chains[..., TRANSMISSION:SPAN] = np.where(some, numbers_of_gears, IDEAL)
    friction = {"friction": 0.2, "bearing_friction": 0.1, "bearing_radius": 0.03} if pulleys == "friction" else {}
    lines = rng.uniform(-3.0, 3.0, (EACH, M, 17 if friction else 14 if pulleys else 6))
    lines[..., 3:6] *= 0.1
    if pulleys:
        lines[..., 6] = np.arange(M) % 2
        lines[..., 7:] = Pulley(type="pulley", radius=0.08, axis=(0.3, -0.2, 0.9), **friction).numbers()
    body, q = numbers(rng, EACH, 13), rng.normal(size=(EACH, 4))
    body[::2, 3:7] = (q / np.linalg.norm(q, axis=1)[:, None])[::2]
    body[::3, :3] *= 0.1
    body[:, 7:] = np.where(np.array(free) == 1, body[:, 7:], 0.0)
    inertia = rng.normal(size=(EACH, 3, 3))
    inertia = inertia @ inertia.swapaxes(1, 2) + 0.1 * np.eye(3)
    center = 0.0 if free == FREE else 0.1
    inertial = [rng.uniform(0.1, 100.0, (EACH, 1)), center * rng.normal(size=(EACH, 3)), inertia.reshape(EACH, 9)]
    places = np.concatenate([[0], np.cumsum(2 * kinds[:, 1])])  # two states of each cable that stretches
    winch = rng.uniform(1.0, 6.0, (EACH, places[-1]))
    winch[rng.random(EACH) < 0.5] = np.nan  # not started
    given = {
        "chains": chains,
        "lines": lines,
        "offset": np.tile([0.1, -0.2, 0.05, 1.0, 0.0, 0.0, 0.0], (EACH, 1)),
        "inertial": np.concatenate(inertial, axis=1),
        "free": np.tile(np.array(free, dtype=float), (EACH, 1)),
        "gravity": np.tile([0.0, 0.0, -9.81], (EACH, 1)),
        "command": rng.uniform(0.0, 500.0, (EACH, M)),
        "external": numbers(rng, EACH, 6),
    }
    before = {
        "body": body,
        "winch": winch,
        "tension": numbers(rng, EACH, M),
        "highest": np.abs(numbers(rng, EACH, M)),
        "length": numbers(rng, EACH, M),
        "rate": numbers(rng, EACH, M),
        "cable_work": rng.normal(size=(EACH, 1)),
        "beside": np.zeros((EACH, 6)),
        "place": np.zeros((EACH, 7)),
        "at_winch": np.ones((EACH, M)),
        "runs": numbers(rng, EACH, M, 10),
        "seen": np.full((EACH, 13), np.nan),
    }
    exits = np.arange(M) % 2 if pulleys else np.zeros(M)
    given["brakes"] = rng.choice([-1.0, -1.0, 0.0, 5.0], (EACH, M))
    tables = {"kinds": np.column_stack([kinds, exits]), "places": places}
    return given, before, {name: table.astype(np.int64) for name, table in tables.items()}


def written(before, *more):
    return {key: value.shape[1:] for key, value in before.items()} | {
        "applied": (6,),
        "matrix": (6, M),
        **dict(more),
    }


@pytest.mark.parametrize("free", [FREE, PLANAR, BALL])
@pytest.mark.parametrize("pulleys", [False, True, "friction"])
def test_a_lane_has_the_bits_of_a_plant_alone(free, pulleys):
    rng = np.random.default_rng(1)
    operations = {
        "settle_winches": ({}, ()),
        "step_winches": ({"step": 1e-3}, ()),
        "winch_runge_kutta": ({"step": 1e-3, "steps": 2}, [("state", (13,))]),
        "read_drums": ({}, [(name, (M,)) for name in ("angle", "speed", "torque", "power")]),
    }
    for name, (values, more) in operations.items():
        given, before, tables = plants(rng, rng.integers(0, 2, (M, 2)), pulleys, free, geared=True)
        shapes = written(before, *more)
        alone, _ = run(name, given, shapes, before, **tables, **values)
        lanes, _ = run_lanes(name, given, shapes, before, **tables, **values)
        reads = name == "read_drums"
        result = "speed" if reads else "applied"
        assert np.isfinite(alone[result]).any(axis=1).sum() > EACH // 8
        for key in dict(more) if reads else shapes:
            assert_same_bits(lanes[key], alone[key])


@pytest.mark.parametrize("free", [FREE, PLANAR, BALL])
def test_drums_go_with_the_platform(free):
    """Newton and Euler of platform and drums together, by numpy: T = u - f/r - J/r^2 l'', some cables slack."""
    rng = np.random.default_rng(2)
    given, before, tables = plants(rng, np.tile([1, 0], (M, 1)), False, free)
    given["chains"][..., 2], given["chains"][..., 5:7], given["external"][:] = 0.0, 0.0, 0.0
    q, body = rng.normal(size=(EACH, 4)), before["body"]
    body[:] = rng.uniform(-1.0, 1.0, (EACH, 13)) * ([1.0] * 7 + list(free))
    body[:, 3:7] = q / np.linalg.norm(q, axis=1)[:, None]
    found, _ = run("settle_winches", given, written(before), before, **tables)
    rows, slack = np.flatnonzero(free), 0
    for k in range(EACH):
        R, omega = rotations.matrix(body[k, 3:7]), body[k, 10:]
        mass, center, inertia = given["inertial"][k, 0], R @ given["inertial"][k, 1:4], given["inertial"][k, 4:]
        inertia = R @ inertia.reshape(3, 3) @ R.T
        shift = np.array([[0, center[2], -center[1]], [-center[2], 0, center[0]], [center[1], -center[0], 0]])
        M6 = np.block([[mass * np.eye(3), mass * shift], [mass * shift.T, inertia + mass * shift.T @ shift]])
        push = mass * (np.cross(omega, np.cross(omega, center)) - given["gravity"][k])
        bias = np.concatenate([push, np.cross(omega, inertia @ omega) + np.cross(center, push)])
        W, tension, drums = found["matrix"][k], found["tension"][k], given["chains"][k, :, 3:5]
        applied = W @ tension
        np.testing.assert_allclose(found["applied"][k], applied, rtol=1e-9, atol=1e-6)
        twist = np.zeros(6)
        twist[rows] = np.linalg.solve(M6[np.ix_(rows, rows)], (applied - bias)[rows])
        length_acceleration = -W.T @ twist - rate_of_matrix(given["lines"][k], body[k]).T @ body[k, 7:]
        expected = given["command"][k] + drums[:, 1] / drums[:, 0] ** 2 * length_acceleration
        np.testing.assert_allclose(tension, np.maximum(expected, 0.0), rtol=1e-6, atol=1e-6)
        slack += (expected < 0.0).sum()
    assert slack > 0


def rate_of_matrix(lines, body, h=1e-6):
    """The time derivative (6, m) of the wrench matrix, by differences."""

    def matrix(time):
        R = Rotation.from_rotvec(time * body[10:]).as_matrix() @ rotations.matrix(body[3:7])
        arms = lines[:, 3:6] @ R.T
        line = lines[:, :3] - body[:3] - time * body[7:10] - arms
        u = line / np.linalg.norm(line, axis=1)[:, None]
        return np.concatenate([u, np.cross(arms, u)], axis=1).T

    return (matrix(h) - matrix(-h)) / (2.0 * h)
