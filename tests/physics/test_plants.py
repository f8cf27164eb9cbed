"""Every backend as a plant alone: its state, its forces, its traps."""

from __future__ import annotations

import dataclasses
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import GRAVITY, crossed_box, make_robot, random_state
from oracle import oracle
from plants import installed, plant

from cdpr.base.errors import PluginError
from cdpr.model import rotations

BACKENDS = installed("reference", "mujoco", "bullet", "dart")
ENGINES = [name for name in BACKENDS if name != "reference"]
KINDS = [(name, {}) for name in BACKENDS]
LEGS = [(name, {"cables": "ups"}) for name in ENGINES]
if "mujoco" in ENGINES:
    KINDS.append(("mujoco", {"cables": "native"}))
PATTERNS = [("x", "z", "ry"), ("x", "y", "z"), ("x", "z"), ("y",), ("rx",), ("x", "y", "z", "rz")]


def on_guide(robot, dof):
    return dataclasses.replace(robot, dof=dof)


def guided_state(robot, rng):
    """A state (13,) that the guide allows."""
    state = np.zeros(13)
    state[:3] = np.array([0.1, -0.2, 2.0]) + rng.uniform(-0.3, 0.3, 3)
    state[3] = 1.0
    for row in robot.rows:
        state[7 + row] = rng.normal()
        if row >= 3:
            state[3], state[1 + row] = np.cos(0.2), np.sin(0.2)
    return state


def same_attitude(state):
    """The state with the quaternion's sign fixed."""
    return np.concatenate([state[:3], state[3:7] * np.sign(state[3]), state[7:]])


def pushed(backend, start, other, command, push):
    """Effect of an external wrench for 0.1 s; none may remain after it ends, nor after a reset."""
    backend.reset(other)
    backend.external[:] = 1e3
    backend.step(5)
    backend.reset(start)
    backend.command[:] = command
    backend.external[:] = push
    backend.step(100)
    backend.external[:] = 0.0
    backend.step(100)
    return same_attitude(backend.state)


@pytest.mark.parametrize(("name", "options"), [kind for kind in KINDS if kind[0] != "reference"])
@pytest.mark.parametrize("dof", [None, *PATTERNS])
@pytest.mark.usual("None-*", "dof[13]-mujoco-options0")
def test_external_wrench_and_reset(offset_robot, name, options, dof):
    """The oracle's answer, free and on a guide, with the centre of mass off the origin."""
    rng = np.random.default_rng(2)
    robot = offset_robot if dof is None else on_guide(offset_robot, dof)
    draw = random_state if dof is None else lambda rng: guided_state(robot, rng)
    case = draw(rng), draw(rng), rng.uniform(20, 120, 8), rng.normal(size=6) * 50
    ours = pushed(plant(name, robot, **options), *case)
    np.testing.assert_allclose(ours, pushed(oracle(robot, GRAVITY, 1e-3), *case), atol=1e-10)


@pytest.mark.parametrize(("name", "options"), KINDS + LEGS)
@pytest.mark.usual("*-options[0-5]")
def test_state_survives_the_engine_in_any_attitude(offset_robot, name, options):
    rng = np.random.default_rng(4)
    backend = plant(name, offset_robot, **options)
    for _ in range(100):
        state = random_state(rng)
        state[3:7] = rotations.from_rpy(*rng.uniform(-3, 3, 3))
        backend.reset(state)
        np.testing.assert_allclose(backend.state, state, atol=1e-12)


@pytest.mark.parametrize(("name", "options"), KINDS)
def test_coasting_loses_nothing(name, options):
    """No damping, no sleep: 10 s without gravity, slowly and without turning."""
    robot = make_robot(crossed_box(np.random.default_rng(0), 8))
    backend = plant(name, robot, gravity=np.zeros(3), **options)
    start = np.concatenate([[0, 0, 2], [1, 0, 0, 0], [1e-3, 0, -2e-3], np.zeros(3)])
    backend.reset(start)
    backend.step(10000)
    np.testing.assert_allclose(backend.state[7:], start[7:], atol=1e-15)
    np.testing.assert_allclose(backend.state[:3], start[:3] + 10 * start[7:10], atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "options"), KINDS)
@pytest.mark.parametrize("dof", [None, ("z",), ("x", "z", "ry")])
@pytest.mark.usual("None-*", "*-mujoco-options1")
def test_speeds_beyond_100_are_not_clipped(name, options, dof):
    robot = make_robot(crossed_box(np.random.default_rng(0), 8), inertia=2.0 * np.eye(3))
    backend = plant(name, robot if dof is None else on_guide(robot, dof), **options)
    start = np.zeros(13)
    start[3] = 1.0
    spin = {None: 12, ("z",): 10, ("x", "z", "ry"): 11}[dof]
    if dof != ("z",):
        start[spin] = 150.0  # rad/s; of a sphere, for gyroscopic moments make this scheme unstable
    backend.reset(start)
    backend.step(15000)
    np.testing.assert_allclose(backend.state[9], -147.15, rtol=1e-12)
    np.testing.assert_allclose(backend.state[spin], start[spin], rtol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("value", [np.nan, np.inf, 1e30])
@pytest.mark.parametrize(("name", "options"), KINDS + LEGS)
def test_a_diverging_engine_shows_it_at_once_and_is_silent(
    offset_robot, name, options, value, tmp_path, monkeypatch, capfd
):
    """No word on the terminal, no file in the user's folder; the same step's state shows it; a reset heals it."""
    monkeypatch.chdir(tmp_path)
    backend = plant(name, offset_robot, **options)
    start = random_state(np.random.default_rng(0))
    backend.reset(start)
    backend.step(2)
    sound = backend.state.copy()
    for array in (backend.external, backend.command):
        backend.reset(start)
        array[0] = value
        backend.step(1)
        assert not (np.abs(backend.state) < 1e4).all()
        backend.step(3)
        assert not (np.abs(backend.state) < 1e4).all()
        array[0] = 0.0
        backend.reset(start)
        backend.step(2)
        np.testing.assert_array_equal(backend.state, sound)
    backend.close()
    assert list(tmp_path.iterdir()) == []
    assert capfd.readouterr() == ("", "")


@pytest.mark.slow
def test_importing_prints_nothing():
    script = "import sys\nfrom cdpr.plugins.registry import registry\nfor name in sys.argv[1:]:\n"
    script += "    registry().get('backend', name).load()\n    print(name)"
    done = subprocess.run([sys.executable, "-c", script, *ENGINES], capture_output=True, text=True, check=True)
    assert (done.stdout.split(), done.stderr) == (ENGINES, "")


@pytest.mark.parametrize(("name", "options"), KINDS + LEGS)
@pytest.mark.parametrize("dof", [None, ("x", "z", "ry")])
def test_the_future_after_a_snapshot_repeats(offset_robot, name, options, dof):
    rng = np.random.default_rng(1)
    if dof is not None and options.get("cables") == "ups":
        with pytest.raises(PluginError, match="free platform"):
            plant(name, on_guide(offset_robot, dof), **options)
        return
    robot = offset_robot if dof is None else on_guide(offset_robot, dof)
    start, other = (random_state(rng), random_state(rng)) if dof is None else [guided_state(robot, rng)] * 2
    backend = plant(name, robot, **options)
    backend.reset(start)
    backend.command[:] = rng.uniform(20, 120, 8)
    backend.external[:] = rng.normal(size=6) * 50
    backend.step(50)
    snapshot, here, time = backend.snapshot(), backend.state.copy(), backend.engine_time()
    backend.step(100)
    there = backend.state.copy()
    backend.command[:] = 0.0
    backend.reset(other)
    backend.step(7)
    for _ in range(2):
        backend.restore(snapshot)
        np.testing.assert_array_equal(backend.state, here)
        assert backend.engine_time() == time
        backend.step(100)
        np.testing.assert_array_equal(backend.state, there)


def resident():
    """Memory of this process, MB."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096 / 2**20


def grows(use, limit):
    """Return whether memory grows by `limit` MB or more in each of three calls: an allocator grows once, by a step."""
    for _ in range(3):
        before = resident()
        use()
        if resident() - before < limit:
            return False
    return True


@pytest.mark.parametrize("name", BACKENDS)
@pytest.mark.usual("reference", "mujoco")
def test_resets_leak_nothing(offset_robot, name):
    backend = plant(name, offset_robot)
    state = random_state(np.random.default_rng(0))

    def use(times):
        for _ in range(times):
            backend.reset(state)
            backend.step(3)
            backend.restore(backend.snapshot())

    use(100)
    assert not grows(lambda: use(1000), 5.0)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "options"), KINDS + [pytest.param(*legs, marks=pytest.mark.slow) for legs in LEGS])
@pytest.mark.usual("mujoco-options1")
def test_open_and_close_leak_nothing(offset_robot, name, options):
    state = random_state(np.random.default_rng(0))

    def use(times):
        for _ in range(times):
            backend = plant(name, offset_robot, **options)
            backend.reset(state)
            backend.step(3)
            backend.close()

    use(30)
    assert not grows(lambda: use(150), 2.5)


def test_a_leak_is_found():
    kept = []
    assert grows(lambda: kept.append(np.ones(2**23)), 2.5)  # more than the allocator has free


@pytest.mark.slow
@pytest.mark.parametrize("name", BACKENDS)
def test_a_million_steps_need_no_more_memory(name):
    """Hovering under the weight's own tensions would drift; a held carriage stays, and steps all the same."""
    robot = dataclasses.replace(make_robot(crossed_box(np.random.default_rng(0), 8)), dof=("x",))
    backend = plant(name, robot)
    start = np.concatenate([[0, 0, 2], [1, 0, 0, 0], np.zeros(6)])
    backend.reset(start)

    def use(times):
        for _ in range(times):
            backend.step(1)

    use(1000)
    before = resident()
    use(1_000_000)
    assert resident() - before < 5.0
    np.testing.assert_allclose(backend.state, start, atol=1e-12)
