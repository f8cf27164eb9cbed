"""Winches, exits and spans of the kernel library: the bits of the numba kernels, and those of one lane in eight."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module

import numba
import numpy as np
import pytest
from kernel_cases import COUNT, assert_same_bits, numbers, run, run_lanes

from cdpr.cables import EXITS, MODELS, Pulley
from cdpr.cables.lines import NUMBERS
from cdpr.cables.tables import SPANS, WINCHES, chain_slopes, chain_start, chain_table, chain_tensions
from cdpr.model import Winch

compiled = pytest.mark.skipif(
    numba.config.DISABLE_JIT, reason="interpreted kernels raise where compiled ones divide by 0"
)

GROUP = 8  # cables of one kind: a lane each, in one group
COLUMNS = ("command", "length", "rate", "length_acceleration", "unwound", "speed", "tension")


def chains(rng):
    """Rows of every pair of a winch and a span, in groups of eight, and what the operations take of them."""
    pairs = [(winch, span) for winch in range(len(WINCHES)) for span in range(len(SPANS))]
    kinds = np.repeat(np.resize(np.array(pairs, dtype=float), (COUNT // GROUP, 2)), GROUP, axis=0)
    legs = np.where(rng.random(COUNT) < 0.3, -np.inf, 0.0)
    table = np.column_stack([kinds, legs, numbers(rng, COUNT, 16)])
    table[::3, 3:] = np.abs(table[::3, 3:])  # usual ones
    given = dict(zip(COLUMNS, numbers(rng, COUNT, len(COLUMNS)).T.copy(), strict=True))
    given["unwound"][::5] = given["length"][::5]
    return table, given


def expected_tension(row, x):
    winch, span = (import_module(part.kernels) if part.kernels else None for part in parts(row))
    if span is None:
        return winch.held(row[3:11], x["command"], x["rate"], x["length_acceleration"])
    stretching = x["rate"] + row[3] * x["speed"]
    return span.pull(row[11:], x["length"], x["unwound"], stretching, row[2]), 0.0


def expected_slopes(row, x):
    winch, span = parts(row)
    if not span.kernels:
        return 0.0, 0.0
    turn = import_module(winch.kernels).turn(row[3:11], x["command"], x["tension"], x["speed"])
    return -row[3] * x["speed"], turn


def expected_start(row, x):
    span = parts(row)[1]
    if not span.kernels:
        return 0.0, 0.0
    return import_module(span.kernels).rest(row[11:], x["length"], x["command"]), np.divide(-x["rate"], row[3])


def parts(row):
    return WINCHES[int(row[0])], SPANS[int(row[1])]


OPERATIONS = {
    "chain_tensions": (COLUMNS[:-1], ("tension", "mass"), expected_tension),
    "chain_slopes": (("command", "tension", "speed"), ("unwinding", "acceleration"), expected_slopes),
    "chain_start": (("command", "length", "rate"), ("unwound", "speed"), expected_start),
}


@compiled
@pytest.mark.parametrize("name", OPERATIONS)
def test_chains_have_the_bits_of_numba_and_of_each_lane(name):
    table, given = chains(np.random.default_rng(1))
    takes, gives, expect = OPERATIONS[name]
    with np.errstate(all="ignore"):
        wanted = np.array([expect(table[k], {key: given[key][k] for key in COLUMNS}) for k in range(COUNT)]).T
    one = {"chains": table[None], **{key: given[key][None] for key in takes}}
    found = run(name, one, dict.fromkeys(gives, (COUNT,)))[0]
    eights = {key: value[0].reshape(COUNT // GROUP, GROUP, -1).swapaxes(0, 1) for key, value in one.items()}
    eights |= {key: eights[key][..., 0] for key in takes}
    lanes = run_lanes(name, eights, dict.fromkeys(gives, (COUNT // GROUP,)))[0]
    for key, answer in zip(gives, wanted, strict=True):
        assert_same_bits(found[key][0], answer)
        assert_same_bits(lanes[key].T.reshape(-1), answer)


@compiled
@pytest.mark.parametrize("kind", range(len(EXITS)))
def test_exits_have_the_bits_of_numba_and_of_each_lane(kind):
    rng, module = np.random.default_rng(2), EXITS[kind].kernels
    table, tip, velocity = numbers(rng, COUNT, 14), numbers(rng, COUNT, 3), numbers(rng, COUNT, 3)
    table[:, 6] = kind
    table[::3, 7:] = Pulley(type="pulley", radius=0.1, axis=(0.3, -0.2, 0.9)).numbers()
    table[::4, 7] = 0.0  # no radius: a point
    tip[::5] = table[::5, :3]  # a tip at the anchor
    with np.errstate(all="ignore"):
        tip[1::5] = table[1::5, :3] + table[1::5, 8:11]  # and on the axis, where no plane is determined
    theirs = np.concatenate([table[:, :6], np.zeros((COUNT, NUMBERS - 6)), table[:, 7:]], axis=1)
    point, wound, moving = table[:, :3].copy(), np.zeros(COUNT), np.zeros((COUNT, 3))
    if module:
        kernels = import_module(module)
        for k, (row, P, V) in enumerate(zip(theirs, map(tuple, tip), map(tuple, velocity), strict=True)):
            *point[k], wound[k] = kernels.lead(row, P)
            moving[k] = kernels.carry(row, P, V)
    one = {"lines": table[None], "tip": tip[None], "velocity": velocity[None]}
    shapes = {"point": (COUNT, 3), "moving": (COUNT, 3), "wrapped_length": (COUNT,)}
    found = run("exits", one, shapes)[0]
    eights = {key: value[0].reshape(8, COUNT // 8, -1) for key, value in one.items()}
    lanes = run_lanes("exits", eights, {key: (COUNT // 8, *shape[1:]) for key, shape in shapes.items()})[0]
    for key, wanted in (("point", point), ("moving", moving), ("wrapped_length", wound)):
        assert_same_bits(found[key][0], wanted)
        assert_same_bits(lanes[key].reshape(wanted.shape), wanted)


def test_an_unknown_kind_answers_nan():
    table = np.zeros((3, 19))
    table[:, 0], table[:, 1], table[:, 3:] = (9.0, np.nan, 0.0), (0.0, 0.0, -1.0), 1.0
    tension, _ = chain_tensions(table, *np.ones((6, 3)))
    assert np.isnan(tension).all()


def test_functions_take_the_tables_of_a_robot(offset_robot):
    winch = Winch(drum_radius=0.05, inertia=0.002, viscous_friction=0.1)
    cables = tuple(
        replace(cable, model=model, winch=winch, axial_stiffness=5e4, damping=10.0)
        for cable, model in zip(offset_robot.cables, np.resize(list(MODELS), offset_robot.m).tolist(), strict=True)
    )
    robot = replace(offset_robot, cables=cables)
    table, m = chain_table(robot), robot.m
    command, length, rate = np.linspace(10.0, 50.0, m), np.linspace(1.0, 3.0, m), np.linspace(-0.1, 0.1, m)
    unwound, speed = chain_start(table, command, length, rate)
    tension, mass = chain_tensions(table, command, length, rate, np.zeros(m), unwound, speed)
    stretches = table[:, 1] == 1.0
    np.testing.assert_allclose(tension[stretches], command[stretches])
    assert (unwound[stretches] < length[stretches]).all()
    assert (mass[table[:, 0] * (1.0 - table[:, 1]) == 1.0] == 0.002 / 0.05**2).all()
    unwinding, acceleration = chain_slopes(table, command, tension, speed)
    np.testing.assert_allclose(unwinding[stretches], rate[stretches])
    np.testing.assert_allclose(acceleration[stretches], (-0.1 * speed / 0.002)[stretches], atol=1e-6)
