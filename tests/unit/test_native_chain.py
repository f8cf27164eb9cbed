"""Winches and spans of the kernel library against their equations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from kernel_cases import numbers, run

from cdpr.cables import MODELS
from cdpr.cables.tables import SPANS, WINCHES, chain_slopes, chain_start, chain_table, chain_tensions
from cdpr.model import Winch

EACH = 960
COLUMNS = ("command", "length", "rate", "length_acceleration", "unwound", "speed", "tension")


def chains(rng):
    """Rows of every pair of a winch and a span, and what the operations take of them."""
    pairs = [(winch, span) for winch in range(len(WINCHES)) for span in range(len(SPANS))]
    kinds = np.resize(np.array(pairs, dtype=float), (EACH, 2))
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
def test_chains_keep_their_equations(name):
    table, given = chains(np.random.default_rng(1))
    takes, expect = OPERATIONS[name]
    with np.errstate(all="ignore"):
        wanted = expect(table, given)
    one = {"chains": table[None], **{key: given[key][None] for key in takes}}
    found = run(name, one, dict.fromkeys(wanted, (EACH,)))[0]
    for key, answer in wanted.items():
        np.testing.assert_allclose(found[key][0][::3], answer[::3], rtol=1e-9, atol=1e-9)  # usual numbers


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
