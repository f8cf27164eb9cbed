"""A winch with four states, added to a copy of the program: on all backends, in snapshots, rollouts and FMUs."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from added_parts import HEADER
from additions import copy_of_program
from conftest import ROOT
from fmu.driver import Driver
from lagged_winch import (
    CHANGES,
    CODE,
    FIRST,
    HOLD,
    IN_THE_HEADER,
    IN_THE_TABLE,
    MODELS,
    PART,
    ROLLOUT,
    RUN,
    SECOND,
    SMOOTH,
    TIME,
    WIDTHS,
    lagged,
    steps_of_lags,
)
from native_compiler import build_library
from plants import installed
from scipy.integrate import solve_ivp
from winch_oracle import Oracle

from cdpr.scenario import load_scenario

WINCH = ROOT / "scenarios" / "winch.yaml"
RUNGE_KUTTA, EULER = ({"backend_options.reference.scheme": scheme} for scheme in ("rk4", "semi_implicit_euler"))


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    """The program with this winch: a folder, and lines in the two tables."""
    folder, add, run = copy_of_program(tmp_path_factory.mktemp("tree"))
    part = folder / "cdpr" / "cables" / "lagged"
    part.mkdir()
    (part / "__init__.py").write_text(PART)
    (part / "lagged.hpp").write_text(HEADER.format(code=CODE))
    add(None, "", "cdpr/cables/__init__.py", **IN_THE_TABLE)
    add(None, "", "cdpr/cables/parts.hpp", **IN_THE_HEADER)
    build_library(folder)
    return folder, run


class Lagged(Oracle):
    """The same robot with drums whose commands follow both lags."""

    def slope(self, time, y):
        self.command[self.late] = lagged(time)[1]
        return super().slope(time, y)


def lagged_truth(time):
    """State, tensions, unwound lengths and speeds of drums at some time after the second command, by scipy."""
    plain = {"lagged": "elastic", "lagged_rigid": "rigid"}
    models = {f"robot.cables[{i}].model": plain.get(model, model) for i, model in enumerate(MODELS)}
    scenario = load_scenario(WINCH, overrides={**SMOOTH, **models})
    late = np.array([model in plain for model in MODELS])
    cables = [
        replace(cable, winch=replace(cable.winch, viscous_friction=0.0, coulomb_friction=0.0)) if own else cable
        for cable, own in zip(scenario.robot.cables, late, strict=True)
    ]
    robot = replace(scenario.robot, cables=tuple(cables))
    truth = Lagged(robot, np.full(8, FIRST), gravity=scenario.gravity)
    truth.late = np.zeros(8, dtype=bool)
    y = truth.exact(scenario.initial.state(), HOLD)
    truth.command[:], truth.late = SECOND, late
    y = solve_ivp(truth.slope, (0.0, time), y, method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    return y[:13], truth.tension(y), y[13:21], y[21:]


def with_lags(tree, *cases):
    """Motions of the robot whose winches have different numbers of states; each case a backend, options and a step."""
    given = {"file": str(WINCH), "first": FIRST, "second": SECOND, "hold": HOLD, "time": TIME}
    cases = [
        {**given, "backend": backend, "changes": {**CHANGES, **options}, "step": step}
        for backend, options, step in cases
    ]
    done = tree[1]("-c", RUN, json.dumps(cases))
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    for each in found:
        assert each["rows"][0] == each["rows"][1]  # after a restored snapshot, to the bit
        assert np.diff(each["places"]).tolist() == list(WIDTHS)
    return [np.array(each["rows"][0]) for each in found]


def outputs_of_lags(row):
    """Outputs of filter and motor of the five winches with lags, (2, 5)."""
    ends = [22 + sum(WIDTHS[: i + 1]) for i, model in enumerate(MODELS) if "lagged" in model]
    return np.array([row[end - 2 : end] for end in ends]).T


@pytest.mark.slow
def test_a_winch_with_states_of_its_own(tree):
    """A robot with winches of 0, 2 and 4 states follows the closed form of the lags, and with it Newton and Euler."""
    steps = (1e-3, 5e-4)
    rows = with_lags(tree, *(("reference", scheme, h) for scheme in (RUNGE_KUTTA, EULER) for h in steps))
    for row, order, h in zip(rows, (4, 4, 1, 1), steps * 2, strict=True):
        expected = steps_of_lags(h, round(TIME / h), order)
        np.testing.assert_allclose(outputs_of_lags(row), np.tile(expected[:, None], 5), rtol=1e-13)
    np.testing.assert_allclose(outputs_of_lags(rows[1])[:, 0], lagged(TIME), rtol=1e-7)
    state, tension, unwound, speed = lagged_truth(TIME)
    elastic = np.isin(MODELS, ["elastic", "lagged"])
    first = (np.cumsum(WIDTHS) - WIDTHS)[elastic]
    apart = []
    for row in rows:
        drums = np.abs([row[22 + first] - unwound[elastic], row[23 + first] - speed[elastic]])
        apart.append([np.abs(row[:13] - state).max(), np.abs(row[13:21] - tension).max(), *drums.max(axis=1)])
    coarse, fine, euler, finer_euler = np.array(apart)
    assert ((coarse / fine > 12.0) & (coarse / fine < 30.0)).all(), coarse / fine  # order four
    assert ((euler / finer_euler > 1.7) & (euler / finer_euler < 2.4)).all(), euler / finer_euler
    assert fine[0] < 1e-7 < 1e-4 < np.abs(state[:3] - load_scenario(WINCH).initial.state()[:3]).max()


@pytest.mark.slow
@pytest.mark.parametrize("engine", installed("mujoco", "bullet", "dart"))
def test_engines_with_states_of_winches(tree, engine):
    """They agree with the reference in their scheme to round-off."""
    expected, found = with_lags(tree, ("reference", EULER, 1e-3), (engine, {}, 1e-3))
    np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-9)


@pytest.mark.slow
def test_rollouts_and_fmus_with_states_of_winches(tree):
    """Cases side by side, and an FMU, have the bits of a run alone."""
    folder, run = tree
    done = run("-c", ROLLOUT, json.dumps({"file": str(WINCH), "changes": CHANGES}))
    assert done.returncode == 0, done.stderr
    steps, different, alike = json.loads(done.stdout)
    assert steps == 30
    assert different == 8
    assert all(alike)

    (expected,) = with_lags(tree, ("reference", RUNGE_KUTTA, 1e-3))
    options = [f"--set={key}={value}" for key, value in CHANGES.items()]
    done = run("fmu", "export", WINCH, "-o", folder / "lagged.fmu", "--force", "--with-winch", "--json", *options)
    assert done.returncode == 0, done.stderr
    with Driver(folder / "lagged.fmu") as driver:
        driver.set("command", np.full(8, FIRST))
        for k in range(10):
            driver.step(1e-3 * k, 1e-3)
        driver.set("command", np.full(8, SECOND))
        for k in range(10, 40):
            driver.step(1e-3 * k, 1e-3)
        assert driver.state().tobytes() == expected[:13].tobytes()
        np.testing.assert_array_equal(driver.get("cable_tension"), expected[13:21])
