"""Motions in the kernel library: against numpy, on each instruction set, and with rubbish in what they write."""

from __future__ import annotations

import doctest
import pickle
from importlib import import_module

import numpy as np
import pytest
from kernel_cases import HOSTILE, assert_same_bits, numbers, run

from cdpr.gcode.pace import pace
from cdpr.gcode.polygon_splines import polygon_splines
from cdpr.model import rotations
from cdpr.native.bind import bind
from cdpr.trajectory import Stopping, Trajectory
from cdpr.trajectory.block_tridiagonal import solve_block_tridiagonal
from cdpr.trajectory.trajectory import sample_segments

COUNT = 600


def motions(rng, count, segments):
    """Tables of segments, of each three the first usual: they follow each other, and attitudes are unit quaternions."""
    found = numbers(rng, count, segments, 42)
    usual = np.arange(count) % 3 == 0
    duration = rng.uniform(0.1, 1.0, (count, segments))
    attitude = rng.normal(size=(count, segments, 4))
    attitude /= np.linalg.norm(attitude, axis=2, keepdims=True)
    found[usual, :, 0] = (np.cumsum(duration, axis=1) - duration - rng.uniform(0, segments, (count, 1)) / 2)[usual]
    found[usual, :, 1], found[usual, :, 38:] = duration[usual], attitude[usual]
    found[::9, :, 20:38] *= 10.0 ** rng.uniform(-9, 0, (len(found[::9]), 1, 1))  # also hardly turning
    return found, usual


def expected(motion, time):
    """Position, velocity, acceleration and attitude, by numpy's polynomials and rotations."""
    begun = np.flatnonzero(motion[:, 0] <= time)
    row = motion[begun[-1] if len(begun) else 0]
    share = np.clip((time - row[0]) / row[1], 0.0, 1.0)
    rest = not 0.0 <= time - row[0] <= row[1] + 1e-9
    quintics = [np.polynomial.Polynomial(c) for c in row[2:38].reshape(6, 6)]
    x, v, a = (
        np.array([quintic.deriv(order)(share) if order else quintic(share) for quintic in quintics]) / row[1] ** order
        for order in range(3)
    )
    half = 0.5 * np.linalg.norm(x[3:])
    q = rotations.multiply(row[38:], np.array([np.cos(half), *(0.5 * np.sinc(half / np.pi) * x[3:])]))
    return x[:3], q, *(0.0 * each[:3] if rest else each[:3] for each in (v, a))


@pytest.mark.parametrize("segments", [1, 5])
def test_samples(segments):
    rng = np.random.default_rng(segments)
    given, usual = motions(rng, COUNT, segments)
    found, _ = run("desired_motion", {"segments": given}, {"desired": (19,)})
    for motion, sample in zip(given[usual], found["desired"][usual], strict=True):
        x, q, v, a = expected(motion, 0.0)
        for got, want in ((sample[:3], x), (sample[3:7], q), (sample[7:10], v), (sample[13:16], a)):
            np.testing.assert_allclose(got, want, atol=1e-10 * (1 + np.abs(want).max()))
    which = np.arange(COUNT)
    each = sample_segments(given[:, 0], which, np.zeros(COUNT))
    if segments == 1:
        assert_same_bits(each, found["desired"])


def test_attitudes_and_their_rates_fit():
    """By central differences of the attitude."""
    rng, h = np.random.default_rng(3), 1e-5
    for motion in (Trajectory(each) for each in motions(rng, 60, 1)[0][::3]):
        time = 0.5 * (motion.start + motion.end)
        before, here, after = (motion.sample(time + k * h) for k in (-1, 0, 1))
        turned = rotations.multiply(after[3:7], rotations.conjugate(before[3:7]))
        rate = rotations.rotation_vector(turned) / (2 * h)
        scale = np.abs(motion.segments[0, 20:38]).max() * (1 + 1 / motion.segments[0, 1] ** 3)
        np.testing.assert_allclose(here[10:13], rate, atol=1e-8 + 1e-5 * scale**3)
        np.testing.assert_allclose(here[16:], (after[10:13] - before[10:13]) / (2 * h), atol=1e-8 + 1e-4 * scale**3)


def test_a_motion_that_stops():
    rng, h = np.random.default_rng(4), 1e-6
    given, usual = motions(rng, COUNT, 3)
    for begin, duration in ((-0.3, 1.0), (0.2, 0.5), *((hostile, 1.0) for hostile in HOSTILE), (0.0, 0.0)):
        run("stopping_motion", {"segments": given[:30]}, {"desired": (19,)}, begin=begin, duration=duration)
    for segments in given[usual][:20]:
        motion = Stopping(Trajectory(segments), segments[0, 0] + 0.05, 0.4)
        before, here, after = (motion.sample(motion.begin + 0.1 + k * h) for k in (-1, 0, 1))
        if abs(segments[:, 0] - motion.begin).min() > 0.1:
            np.testing.assert_allclose(here[7:10], (after[:3] - before[:3]) / (2 * h), atol=1e-4)
        assert not motion.sample(motion.begin + 0.4)[7:].any()


def test_a_motion_samples_itself_again_where_it_was_copied():
    motion = Trajectory(motions(np.random.default_rng(5), 3, 4)[0][0])
    first, kept = motion.sample(0.1), motion.sample(0.2)
    again = pickle.loads(pickle.dumps(motion))
    again.segments[:, 2:20] += 1.0
    assert (again.sample(0.1)[:3] != first[:3]).any()
    assert_same_bits(motion.sample(0.1), first)
    assert_same_bits(motion.sample(0.2), kept)


@pytest.mark.parametrize("blocks", [1, 2, 9])
def test_block_tridiagonal_systems(blocks):
    rng = np.random.default_rng(blocks)
    factor = rng.normal(size=(COUNT, blocks, 2, 2))
    diagonal = factor @ np.swapaxes(factor, -1, -2) + 6 * np.eye(2)
    upper, right = rng.uniform(-1, 1, (COUNT, blocks - 1, 2, 2)), rng.normal(size=(COUNT, blocks, 2))
    inputs = {"diagonal": diagonal, "upper": upper, "right": right}
    found, _ = run("block_tridiagonal", inputs, {"solution": (blocks, 2)})
    for k in range(20):
        whole = np.zeros((2 * blocks, 2 * blocks))
        for i in range(blocks):
            whole[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = diagonal[k, i]
        for i in range(blocks - 1):
            whole[2 * i : 2 * i + 2, 2 * i + 2 : 2 * i + 4] = upper[k, i]
            whole[2 * i + 2 : 2 * i + 4, 2 * i : 2 * i + 2] = upper[k, i].T
        solution = np.linalg.solve(whole, right[k].ravel()).reshape(-1, 2)
        np.testing.assert_allclose(found["solution"][k], solution, rtol=1e-9, atol=1e-12)
        assert_same_bits(solve_block_tridiagonal(diagonal[k], upper[k], right[k]), found["solution"][k])
    hostile = {name: numbers(rng, *array.shape) for name, array in inputs.items() if array.size}
    run("block_tridiagonal", inputs | hostile, {"solution": (blocks, 2)})


def test_paces_have_the_same_bits_on_each_instruction_set_and_with_rubbish():
    rng, sections = np.random.default_rng(6), 12
    starts = np.cumsum(10.0 ** rng.uniform(-4, 0, (COUNT, sections + 1)), axis=1)
    share = rng.choice([1.0, 0.6, 0.1], (COUNT, sections))
    inputs = {"starts": starts, "caps": 10.0 ** rng.uniform(-3, 0.3, share.shape)}
    inputs |= {"accelerations": 2.0 * share, "jerks": 20.0 * share}
    for k, name in enumerate(inputs):
        inputs[name][k::30, 5] = np.resize(HOSTILE, len(inputs[name][k::30]))
    chains = np.array([0, 1, 7, 12])
    shapes = {"phases": (8 * 12 + 7 * 3, 5)}
    found = []
    for _ in range(2):
        rows = np.full(4, -7)
        found.append(
            run("pace", inputs, shapes, chains=chains, rows=rows, trees=np.full((2, 24), -99), c=3)[0]["phases"]
        )
    for k in range(COUNT):
        phases, rows = pace(*(array[k] for array in inputs.values()), chains)
        assert_same_bits(found[0][k, : rows[-1]], phases)


def polygons(rng, kind):
    """Vertices of three polygons: at random, along a circle in decimals, or there and back."""
    if kind == 0:
        return rng.uniform(-1, 1, (24, 3))
    if kind == 1:
        angle = np.cumsum(rng.uniform(0.001, 0.02, 24))
        return np.stack([np.cos(angle), np.sin(angle), 0.1 * angle], axis=1).round(4) + 1e-7 * rng.normal(size=(24, 3))
    return np.cumsum(rng.choice([-1.0, 1.0], (24, 3)) * 10.0 ** rng.uniform(-6, -1, (24, 1)), axis=0)


def test_splines_stay_within_their_tolerance():
    rng, runs = np.random.default_rng(7), np.array([0, 3, 12, 24])
    ends = np.isin(np.arange(24), [0, 2, 3, 11, 12, 23])
    made = 0
    for k in range(60):
        points = polygons(rng, k % 3)
        steps = np.diff(points, axis=0)
        chord = np.concatenate([[0.0], np.linalg.norm(steps, axis=1)])
        turn = np.zeros(24)
        turn[1:-1] = np.linalg.norm(np.diff(steps / chord[1:, None], axis=0), axis=1)
        turn[ends] = 0.0
        tolerance = 10.0 ** rng.uniform(-5, -2)
        missing = np.where(ends, np.inf, tolerance)
        allowed = 6.0 * missing / np.maximum(turn, 1e-9)
        wanted = np.where(ends, 0.0, 3.0 * np.sqrt(turn / 200.0))
        parted = rng.random(24) < 0.3
        pieces, rows = polygon_splines(
            points, chord, turn, wanted, allowed, np.full(24, tolerance), missing, parted, runs
        )
        for run_of in range(3):
            mine = pieces[rows[run_of] : rows[run_of + 1]]
            corner = points[runs[run_of] : runs[run_of + 1]]
            if not len(mine):
                continue
            made += 1
            for share in (0.0, 0.3, 0.7, 1.0):
                h = mine[:, 1] - mine[:, 0]
                x = (share * h)[:, None]
                third = (mine[:, 11:14] - mine[:, 8:11]) / h[:, None]
                place = mine[:, 2:5] + x * (mine[:, 5:8] + x * (0.5 * mine[:, 8:11] + x * third / 6.0))
                assert distance(place, corner).max() <= tolerance * (1 + 1e-6)
            np.testing.assert_allclose(place[:-1], mine[1:, 2:5], atol=1e-9)
            np.testing.assert_allclose(place[-1], corner[-1], atol=1e-9)
    assert made > 100


def distance(points, vertices):
    """Distance of points from a polygon."""
    begin, step = vertices[:-1], np.diff(vertices, axis=0)
    share = np.clip(np.sum((points[:, None] - begin) * step, axis=2) / np.sum(step**2, axis=1), 0.0, 1.0)
    return np.linalg.norm(points[:, None] - begin - share[..., None] * step, axis=2).min(axis=1)


def test_mismatches_are_rejected():
    line, three = np.zeros((3, 3)), np.zeros(3)
    for runs in ([0, 2], [1, 3], [0, 1, 3], [0, 3, 2]):
        with pytest.raises(ValueError, match="runs: expected"):
            polygon_splines(line, three, three, three, three, three, three, [False] * 3, runs)
    for chains in ([0, 2], [1, 3], [0, 2, 2, 3], [3, 0]):
        with pytest.raises(ValueError, match="chains: expected"):
            pace(np.arange(4.0), np.ones(3), np.ones(3), np.ones(3), chains)
    with pytest.raises(ValueError, match=r"segment_samples: which: expected rows 0 to 1, got \[2\]"):
        sample_segments(np.zeros((2, 42)), [2], [0.0])
    with pytest.raises(ValueError, match=r"desired_motion: segments: expected shape \(k >= 1, 42\)"):
        bind("desired_motion", segments=np.empty((0, 42)), desired=np.empty(19))


@pytest.mark.parametrize("module", ["trajectory.block_tridiagonal", "gcode.pace", "gcode.polygon_splines"])
def test_examples_of_the_documentation(module):
    done = doctest.testmod(import_module(f"cdpr.{module}"))
    assert done.attempted
    assert not done.failed
