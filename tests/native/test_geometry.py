"""Cable geometry of the kernel library: against numpy, and the bits of one lane in eight."""

from __future__ import annotations

import struct
from dataclasses import replace

import numpy as np
import pytest
from kernel_cases import assert_same_bits, numbers, run, run_lanes

from cdpr.cables import Pulley
from cdpr.cables.tables import exits, line_table
from cdpr.mechanics.cable_geometry import cable_geometry, cable_wrench, wrench_matrix_rate
from cdpr.model import rotations
from cdpr.native import library
from cdpr.native.operations import operations
from cdpr.tension.status import Status

PULLEY = Pulley(type="pulley", radius=0.1, axis=(0.3, -0.2, 0.9))
OWN = len(PULLEY.numbers())


@pytest.mark.parametrize("width", [6, 7 + OWN])
def test_geometry_has_the_bits_of_each_lane(width):
    rng, count = np.random.default_rng(1), 24
    for m in range(1, 13):
        lines = numbers(rng, count, m, width)
        if width > 6:
            lines[:, :, 6] = rng.random(m) < 0.7
            lines[::3, :, 7:] = PULLEY.numbers()
        state = numbers(rng, count, 13)
        state[::3, 3:7] /= np.linalg.norm(state[::3, 3:7], axis=1)[:, None]
        state[::4, :3] = lines[::4, 0, :3]  # a cable without length, with the lever zero
        lines[::4, 0, 3:6] = 0.0
        inputs, shapes = {"lines": lines, "state": state}, {"matrix": (6, m), "length": (m,), "rate": (m,)}
        one, eight = run("geometry", inputs, shapes)[0], run_lanes("geometry", inputs, shapes)[0]
        for key, answer in one.items():
            assert_same_bits(eight[key], answer)


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
@pytest.mark.parametrize("name", ["geometry", "geometry_lanes", "matrix_rate", "cable_wrench", "exits"])
def test_a_compiled_pipeline_gets_bad_input_for_such_a_row(name, width):
    """Packed by hand: `bind` would reject it. Nothing is read or written, for all addresses are 0."""
    operation = operations()[name]
    sizes = {"m": 200, "w": width}
    words = struct.pack(operation.layout, *(sizes.get(field.name, 0) for field in operation.fields))
    code = 0xFF if name.endswith("_lanes") else Status.BAD_INPUT
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
    lever = table[:, 3:6] @ rotations.matrix(state[3:7]).T
    chord = exits(table, state[:3] + lever)[0] - state[:3] - lever
    u = chord / np.linalg.norm(chord, axis=1)[:, None]
    np.testing.assert_allclose(matrix, np.hstack([u, np.cross(lever, u)]).T, atol=1e-13)
    np.testing.assert_allclose(rate, -state[7:] @ matrix, atol=1e-13)
    if table.shape[1] == 6:
        np.testing.assert_allclose(length, np.linalg.norm(table[:, :3] - state[:3] - lever, axis=1), rtol=1e-14)
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
