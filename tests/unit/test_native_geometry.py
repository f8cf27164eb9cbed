"""Cable geometry of the kernel library: the bits of the numba kernels, and those of one lane in eight."""

from __future__ import annotations

import struct
from dataclasses import replace

import numba
import numpy as np
import pytest
from kernel_cases import COUNT, assert_same_bits, numbers, run, run_lanes

from cdpr.cables import Pulley
from cdpr.cables.lines import NUMBERS, lines, rows
from cdpr.cables.tables import exits, line_table
from cdpr.mechanics import geometry
from cdpr.mechanics.cable_geometry import cable_geometry, cable_wrench, wrench_matrix_rate
from cdpr.model.jit import kernel
from cdpr.model.kernels import quaternion, store, vector
from cdpr.native import library
from cdpr.native.operations import operations
from cdpr.tension.status import Status

compiled = pytest.mark.skipif(
    numba.config.DISABLE_JIT, reason="interpreted kernels raise where compiled ones divide by 0"
)

PULLEY = Pulley(type="pulley", radius=0.1, axis=(0.3, -0.2, 0.9))
OWN = len(PULLEY.numbers())


@kernel
def wrench_of(table, state, tension, wrench):
    """Call the kernel that returns tuples."""
    force, moment = geometry.cable_wrench(table, vector(state, 0), quaternion(state, 3), tension)
    store(force, wrench, 0)
    store(moment, wrench, 3)


def tables(rng, count, m, width):
    """Anchors, and exits for some cables where there is room: the same table for numba and for the library."""
    ours, theirs = numbers(rng, count, m, width), np.zeros((count, m, 6 if width == 6 else NUMBERS + width - 7))
    theirs[:, :, :6] = ours[:, :, :6]
    if width == 6:
        return ours, theirs
    pulleys = rng.random(m) < 0.7
    ours[:, :, 6] = pulleys
    calls = rows(np.zeros((1, 6)), [PULLEY])[0, 6:NUMBERS]
    sound = np.arange(count) % 3 == 0
    ours[sound, :, 7:] = PULLEY.numbers()
    theirs[:, pulleys, 6:NUMBERS] = calls
    theirs[:, :, NUMBERS:] = ours[:, :, 7:]
    return ours, theirs


@compiled
@pytest.mark.parametrize("width", [6, 7 + OWN])
def test_geometry_has_the_bits_of_numba_and_of_each_lane(width):
    rng, count = np.random.default_rng(1), COUNT // 24  # of each m, and there are 12 of them, with and without exits
    for m in range(1, 13):
        ours, theirs = tables(rng, count - count % 8, m, width)
        state, tension = numbers(rng, len(ours), 13), numbers(rng, len(ours), m)
        state[::3, 3:7] /= np.linalg.norm(state[::3, 3:7], axis=1)[:, None]
        state[::4, :3] = ours[::4, 0, :3]  # a cable without length, with the lever zero
        ours[::4, 0, 3:6] = theirs[::4, 0, 3:6] = 0.0
        shapes = {"matrix": (6, m), "length": (m,), "rate": (m,), "matrix_rate": (6, m), "wrench": (6,)}
        wanted = {key: np.empty((len(ours), *shape)) for key, shape in shapes.items()}
        for k in range(len(ours)):
            geometry.cable_geometry(theirs[k], state[k], wanted["matrix"][k], wanted["length"][k], wanted["rate"][k])
            geometry.wrench_matrix_rate(theirs[k], state[k], wanted["matrix_rate"][k])
            wrench_of(theirs[k], state[k], tension[k], wanted["wrench"][k])
        for go in (run, run_lanes):
            found = go("geometry", {"lines": ours, "state": state}, {"matrix": (6, m), "length": (m,), "rate": (m,)})[0]
            for key, answer in found.items():
                assert_same_bits(answer, wanted[key])
            found = go("matrix_rate", {"lines": ours, "state": state}, {"rate": (6, m)})[0]
            assert_same_bits(found["rate"], wanted["matrix_rate"])
            given = {"lines": ours, "pose": np.ascontiguousarray(state[:, :7]), "tension": tension}
            assert_same_bits(go("cable_wrench", given, {"wrench": (6,)})[0]["wrench"], wanted["wrench"])


def calls(table):
    """The Python functions of tables of anchors."""
    m = len(table)
    return [
        lambda: cable_geometry(table, np.zeros(13)),
        lambda: wrench_matrix_rate(table, np.zeros(13)),
        lambda: cable_wrench(table, np.zeros(7), np.zeros(m)),
        lambda: exits(table, np.zeros((m, 3))),
    ]


@pytest.mark.parametrize("width", range(6))
def test_a_row_without_both_anchors_is_one_clear_error(width):
    for call in calls(np.zeros((200, width))):
        with pytest.raises(ValueError, match=rf"lines: expected shape \(m, w >= 6\), got \(200, {width}\)\."):
            call()


@pytest.mark.parametrize("width", range(6))
@pytest.mark.parametrize("name", ["geometry", "matrix_rate", "cable_wrench", "exits"])
def test_a_compiled_pipeline_gets_bad_input_for_such_a_row(name, width):
    """Packed by hand: `bind` would reject it. Nothing is read or written, for all addresses are 0."""
    for suffix, code in (("", Status.BAD_INPUT), ("_lanes", 0xFF)):
        operation = operations()[name + suffix]
        sizes = {"m": 200, "w": width}
        words = struct.pack(operation.layout, *(sizes.get(field.name, 0) for field in operation.fields))
        assert library.Bound(operation.address, words, {}, ())() == code


@pytest.mark.parametrize("width", [*range(6, 15), 20])
def test_a_pulley_without_all_its_numbers_answers_nan(width):
    """The rest of these numbers follows the row in memory."""
    whole = np.zeros((1, 20))
    whole[0, :6], whole[0, 7:14] = (1.0, 2.0, 3.0, 0.1, 0.0, 0.0), PULLEY.numbers()
    memory = whole.ravel().copy()
    for kind in (0, 1):
        memory[6] = kind
        table = memory[:width].reshape(1, width)
        state = np.eye(13)[3]
        matrix, length, rate = cable_geometry(table, state)
        wrapped = exits(table, np.zeros((1, 3)), np.ones((1, 3)))
        known = kind == 0 or width == 6 or width >= 14
        answers = [matrix, length, rate, *wrapped, wrench_matrix_rate(table, state)]
        answers.append(cable_wrench(table, state[:7], np.ones(1)))
        assert [bool(np.isfinite(answer).all()) for answer in answers] == [known] * len(answers)


def with_pulleys(robot):
    cables = tuple(replace(cable, exit=PULLEY if i % 2 else None) for i, cable in enumerate(robot.cables))
    return replace(robot, cables=cables)


@pytest.mark.parametrize("change", [lambda robot: robot, with_pulleys])
def test_functions_agree_with_each_other_and_with_differences(offset_robot, change):
    table = line_table(robot := change(offset_robot))
    rng, step = np.random.default_rng(2), 1e-6
    q = rng.normal(size=4)
    state = np.concatenate([[0.1, 0.2, 1.0], q / np.linalg.norm(q), rng.normal(size=6)])
    matrix, length, rate = cable_geometry(table, state)
    expected = np.empty((6, robot.m)), np.empty(robot.m), np.empty(robot.m)
    geometry.cable_geometry(lines(robot), state, *expected)
    for found, wanted in zip((matrix, length, rate), expected, strict=True):
        assert_same_bits(found, wanted)
    tension = rng.uniform(1.0, 9.0, robot.m)
    np.testing.assert_allclose(cable_wrench(table, state[:7], tension), matrix @ tension, atol=1e-12)
    ahead = state.copy()
    ahead[:3] += step * state[7:10]
    w, x, y, z = state[3:7]
    ahead[3:7] += 0.5 * step * np.array([[-x, -y, -z], [w, z, -y], [-z, w, x], [y, -x, w]]) @ state[10:]
    ahead[3:7] /= np.linalg.norm(ahead[3:7])
    further = cable_geometry(table, ahead)
    np.testing.assert_allclose((further[1] - length) / step, rate, atol=1e-4)
    np.testing.assert_allclose((further[0] - matrix) / step, wrench_matrix_rate(table, state), atol=1e-4)
    points, moving, wrapped_length = exits(table, rng.uniform(-0.1, 0.1, (robot.m, 3)))
    assert np.isfinite(points).all()
    assert (moving == 0.0).all()
    assert (wrapped_length > 0.0).any() == (table.shape[1] > 6)
    with pytest.raises(ValueError, match=r"geometry: state: expected shape \(13,\)"):
        cable_geometry(table, state[:7])
