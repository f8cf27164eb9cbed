"""Winches, exits and spans of the kernel library: against their equations, and the bits of one lane in eight."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from kernel_cases import assert_same_bits, numbers, run, run_lanes

from cdpr.cables import EXITS, MODELS, Pulley
from cdpr.cables.tables import SPANS, WINCHES, chain_slopes, chain_start, chain_table, chain_tensions
from cdpr.model import Winch

EACH = 960
GROUP = 8  # cables of one kind: a lane each, in one group
COLUMNS = ("command", "length", "rate", "length_acceleration", "unwound", "speed", "tension")


def chains(rng):
    """Rows of every pair of a winch and a span, in groups of eight, and what the operations take of them."""
    pairs = [(winch, span) for winch in range(len(WINCHES)) for span in range(len(SPANS))]
    kinds = np.repeat(np.resize(np.array(pairs, dtype=float), (EACH // GROUP, 2)), GROUP, axis=0)
    legs = np.where(rng.random(EACH) < 0.3, -np.inf, 0.0)
    table = np.column_stack([kinds, legs, numbers(rng, EACH, 16)])
    table[::3, 3:] = np.abs(table[::3, 3:])  # usual ones
    given = dict(zip(COLUMNS, numbers(rng, EACH, len(COLUMNS)).T.copy(), strict=True))
    given["unwound"][::5] = given["length"][::5]
    return table, given


def friction(drum, speed):
    """Torque, N m, viscous and Coulomb's; of rows radius, inertia, viscous, Coulomb, its speed."""
    return drum[2] * speed + drum[3] * np.tanh(speed / drum[4])


def expected_tensions(table, x):
    """By the equations of `cdpr.cables.drum` (thesis 2.20 to 2.24) and `cdpr.cables.elastic`."""
    drum, span = table[:, 3:8].T, table[:, 11:13].T
    mass = drum[1] / drum[0] ** 2
    rigid = x["command"] - friction(drum, -x["rate"] / drum[0]) / drum[0] + mass * x["length_acceleration"]
    stretch, stretching = x["length"] - x["unwound"], x["rate"] + drum[0] * x["speed"]
    pulled = span[0] * stretch / x["unwound"] + span[1] * stretching
    elastic = np.where((stretch <= 0.0) & (table[:, 2] == 0.0), 0.0, np.maximum(pulled, table[:, 2]))
    has_drum, stretches = table[:, 0] == 1.0, table[:, 1] == 1.0
    tension = np.where(stretches, elastic, np.where(has_drum, rigid, x["command"]))
    return {"tension": tension, "mass": np.where(has_drum & ~stretches, mass, 0.0)}


def expected_slopes(table, x):
    drum = table[:, 3:8].T
    turn = (drum[0] * (x["command"] - x["tension"]) - friction(drum, x["speed"])) / drum[1]
    has_drum, stretches = table[:, 0] == 1.0, table[:, 1] == 1.0
    unwinding = np.where(stretches, -drum[0] * x["speed"], 0.0)
    return {"unwinding": unwinding, "acceleration": np.where(has_drum & stretches, turn, 0.0)}


def expected_start(table, x):
    stretches = table[:, 1] == 1.0
    unwound = x["length"] / (1.0 + x["command"] / table[:, 11])
    return {
        "unwound": np.where(stretches, unwound, 0.0),
        "speed": np.where(stretches, -x["rate"] / table[:, 3], 0.0),
    }


OPERATIONS = {
    "chain_tensions": (COLUMNS[:-1], expected_tensions),
    "chain_slopes": (("command", "tension", "speed"), expected_slopes),
    "chain_start": (("command", "length", "rate"), expected_start),
}


@pytest.mark.parametrize("name", OPERATIONS)
def test_chains_keep_their_equations_and_have_the_bits_of_each_lane(name):
    table, given = chains(np.random.default_rng(1))
    takes, expect = OPERATIONS[name]
    with np.errstate(all="ignore"):
        wanted = expect(table, given)
    one = {"chains": table[None], **{key: given[key][None] for key in takes}}
    found = run(name, one, dict.fromkeys(wanted, (EACH,)))[0]
    eights = {key: value[0].reshape(EACH // GROUP, GROUP, -1).swapaxes(0, 1) for key, value in one.items()}
    eights |= {key: eights[key][..., 0] for key in takes}
    lanes = run_lanes(name, eights, dict.fromkeys(wanted, (EACH // GROUP,)))[0]
    for key, answer in wanted.items():
        np.testing.assert_allclose(found[key][0][::3], answer[::3], rtol=1e-9, atol=1e-9)  # usual numbers
        assert_same_bits(lanes[key].T.reshape(-1), found[key][0])


@pytest.mark.parametrize("kind", range(len(EXITS)))
def test_exits_have_the_bits_of_each_lane(kind):
    """Their geometry: `test_exits` and `test_pulley`."""
    rng = np.random.default_rng(2)
    table, tip, velocity = numbers(rng, EACH, 14), numbers(rng, EACH, 3), numbers(rng, EACH, 3)
    table[:, 6] = kind
    table[::3, 7:] = Pulley(type="pulley", radius=0.1, axis=(0.3, -0.2, 0.9)).numbers()
    table[::4, 7] = 0.0  # no radius: a point
    tip[::5] = table[::5, :3]  # a tip at the anchor
    with np.errstate(all="ignore"):
        tip[1::5] = table[1::5, :3] + table[1::5, 8:11]  # and on the axis, where no plane is determined
    one = {"lines": table[None], "tip": tip[None], "velocity": velocity[None]}
    shapes = {"point": (EACH, 3), "moving": (EACH, 3), "wrapped_length": (EACH,)}
    found = run("exits", one, shapes)[0]
    eights = {key: value[0].reshape(8, EACH // 8, -1) for key, value in one.items()}
    lanes = run_lanes("exits", eights, {key: (EACH // 8, *shape[1:]) for key, shape in shapes.items()})[0]
    for key, answer in found.items():
        assert_same_bits(lanes[key].reshape(answer[0].shape), answer[0])


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
