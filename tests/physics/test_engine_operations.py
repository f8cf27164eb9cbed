"""Engines as the loop steps them: operations in compiled code and in Python, to the same bits."""

from __future__ import annotations

import dataclasses
import gc
import subprocess
import sys
import weakref
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import ROOT
from plants import installed, plant
from spread import spread

from cdpr.base.errors import Diverged, PluginError
from cdpr.plugins import Backend
from cdpr.scenario import load_scenario
from cdpr.simulation import pipeline
from cdpr.simulation.build import build
from cdpr.simulation.loop import Loop

STEPS = 120
ENGINES = installed("mujoco", "bullet", "dart")
CASES = {
    "free": ("caroca", {}),
    "off_centre": ("off_centre_mass", {}),
    "guided": ("planar", {}),
    "carriage": ("carriage", {}),
    "spherical": ("spherical", {}),
    "winches": ("winch", {}),
    "pulleys": ("cogiro_pulleys", {}),
    "wrench": ("external_wrench", {}),
    "substeps": ("caroca", {"simulation.physics_step": 2.5e-4}),
}

mujoco = pytest.mark.skipif("mujoco" not in ENGINES, reason="mujoco is not installed")


class Running:
    """A loop and where its rows go."""

    def __init__(self, backend: str, name: str = "caroca", **overrides: object) -> None:
        self.scenario = load_scenario(ROOT / "scenarios" / f"{name}.yaml", backend=backend, overrides=overrides)
        self.loop = Loop(build(self.scenario))
        self.loop.warm_up(self.scenario.initial.state())
        self.rows = np.zeros((STEPS + 1, len(self.loop.row)))

    def run(self) -> np.ndarray:
        self.loop.run(self.rows, lambda count: None)
        return self.rows.copy()

    def again(self) -> np.ndarray:
        for part in (self.loop.parts.controller, self.loop.parts.solver, self.loop.stage):
            (part.forget if part is self.loop.stage else part.reset)()
        self.loop.parts.backend.reset(self.scenario.initial.state())
        return self.run()


def interpreted(monkeypatch, *args, **overrides):
    """The rows where Python calls everything."""
    with monkeypatch.context() as patch:
        patch.setattr(pipeline, "bound", lambda *given: None)
        return Running(*args, **overrides).run()


@spread("backend, case", ENGINES, list(CASES))
@pytest.mark.usual("mujoco-*", "bullet-winches", "dart-spherical")
def test_same_bits_whoever_calls(monkeypatch, backend, case):
    name, overrides = CASES[case]
    running = Running(backend, name, **overrides)
    rows = running.run()
    assert np.isfinite(rows[:, 1:14]).all()
    assert np.ptp(rows[:, 1:14], axis=0).any(), "it moves"
    np.testing.assert_array_equal(rows, interpreted(monkeypatch, backend, name, **overrides))
    np.testing.assert_array_equal(running.again(), rows)


@pytest.mark.parametrize("backend", ENGINES)
def test_python_is_called_at_most_once_per_step(backend):
    own = Running(backend).loop.pipeline.interpreted
    assert own == (() if backend == "mujoco" else ("backend",))


@pytest.mark.parametrize("backend", ENGINES)
def test_snapshots_restore_to_the_bit(backend):
    running = Running(backend)
    loop, rows = running.loop, running.rows
    whole = running.run()
    running.again()
    loop.parts.backend.reset(running.scenario.initial.state())
    loop.begin(rows, STEPS)
    loop.pipeline.run_until(40)
    moment = loop.snapshot()
    for _ in range(2):
        rows[40:] = np.nan
        loop.pipeline.run_until(STEPS)
        loop.decide()
        np.testing.assert_array_equal(rows, whole)
        loop.restore(moment)


@pytest.mark.parametrize("backend", ENGINES)
@pytest.mark.usual("mujoco", "bullet")
def test_two_in_one_process(backend):
    alone = Running(backend).run()
    pair = Running(backend), Running(backend, "planar")
    for running in pair:
        running.loop.begin(running.rows, STEPS)
    for k in range(7, STEPS + 7, 7):
        for running in pair:
            running.loop.pipeline.run_until(min(k, STEPS))
    for running in pair:
        running.loop.decide()
    np.testing.assert_array_equal(pair[0].rows, alone)
    np.testing.assert_array_equal(pair[1].rows, Running(backend, "planar").run())


@pytest.mark.parametrize("backend", ENGINES)
def test_threads(backend):
    several = [Running(backend) for _ in range(4)]
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(Running.run, several))
    for rows in found:
        np.testing.assert_array_equal(rows, found[0])
    np.testing.assert_array_equal(found[0], Running(backend).run())


@mujoco
@pytest.mark.parametrize("lacking", ["library", "function", "address"])
def test_a_wheel_that_lacks_it_is_stepped_by_its_binding(monkeypatch, lacking):
    from cdpr_backends.mujoco import direct, world

    whole = Running("mujoco").run()
    direct.find_library.cache_clear()
    if lacking == "library":
        monkeypatch.setitem(sys.modules, world.mujoco.MjModel.__module__, SimpleNamespace(__file__="no such library"))
    elif lacking == "function":
        monkeypatch.setattr(direct, "NAMES", (*direct.NAMES, "mj_of_another_day"))
    else:
        monkeypatch.setattr(world, "direct", lambda model, data: direct.direct(SimpleNamespace(), data))
    try:
        running = Running("mujoco")
        assert running.loop.pipeline.interpreted == ("backend",)
        np.testing.assert_array_equal(running.run(), whole)
    finally:
        direct.find_library.cache_clear()


GIVES_UP = """
import numpy as np, sys
sys.path[:0] = {path!r}
import test_engine_operations as here
running = here.Running("mujoco")
whole, loop = running.run(), running.loop
model = loop.parts.backend._world.model
for _ in range(2):
    loop.parts.backend.reset(running.scenario.initial.state())
    loop.begin(running.rows, here.STEPS)
    loop.pipeline.run_until(40)
    model.opt.integrator = 77
    try:
        loop.pipeline.run_until(80)
    except Exception as error:
        print(type(error).__name__, error, loop.count)
    model.opt.integrator = 0
print(np.array_equal(running.again(), whole))
"""


@mujoco
@pytest.mark.slow
def test_an_error_of_mujoco_ends_the_run_not_the_process(tmp_path):
    """If MuJoCo fails, it ends a C program that has no handler, and leaves a file behind."""
    path = [str(ROOT / "tests" / name) for name in (".", "support", "physics")]
    program = GIVES_UP.format(path=path)
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=tmp_path, check=False)
    told = "FatalError mj_step: invalid integrator 41\n"
    assert (done.returncode, done.stdout, done.stderr) == (0, 2 * told + "True\n", "")
    assert not list(tmp_path.iterdir())


@mujoco
def test_operations_keep_their_world_alive(offset_robot):
    states = []
    for keep in (True, False):
        backend = plant("mujoco", offset_robot)
        backend.reset(np.concatenate([[0, 0, 2], [1, 0, 0, 0], np.zeros(6)]))
        backend.command[:] = 80.0
        operations, state, model = backend.operations(1), backend.state, weakref.ref(backend._world.model)
        if not keep:
            del backend
        for _ in range(50):
            for operation in operations:
                operation()
            if not keep:
                gc.collect(0)
        states.append(state)
        gc.collect()
        assert model() is not None
        del operations, operation
        backend = None
        gc.collect()
        assert model() is None, "and who lets go of them lets go of the world"
    np.testing.assert_array_equal(*states)


@pytest.mark.parametrize("backend", ENGINES)
def test_non_finite_values_end_the_run_in_the_same_sample(monkeypatch, capfd, tmp_path, backend):
    monkeypatch.chdir(tmp_path)
    said = []
    for bound in (pipeline.bound, lambda *given: None):
        with monkeypatch.context() as patch:
            patch.setattr(pipeline, "bound", bound)
            running = Running(backend)
            running.loop.begin(running.rows, STEPS)
            running.loop.pipeline.run_until(40)
            running.loop.parts.backend.external[:] = np.nan
            with pytest.raises(Diverged) as caught:
                running.loop.pipeline.run_until(80)
            said.append((str(caught.value), running.loop.count))
    assert said[0] == said[1]
    assert not any(capfd.readouterr())
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("backend", ENGINES)
def test_an_engine_that_resets_itself_is_found(monkeypatch, backend):
    running = Running(backend)
    if running.loop.parts.backend.engine_time() is None:
        pytest.skip("it has no clock")
    running.loop.begin(running.rows, STEPS)
    running.loop.pipeline.run_until(40)
    state = running.loop.parts.backend.state.copy()
    running.loop.parts.backend.reset(state)
    with pytest.raises(Diverged, match=r"clock reads 0\.001 s: it reset itself"):
        running.loop.pipeline.run_until(41)


class Slipping(Backend):
    """A plant whose operation reports a failure."""

    def reset(self, state):
        """Put it there."""
        self.state[:] = state

    def step(self, n):
        """Stay."""

    def operations(self, n):
        """Fail."""
        return [lambda: 7]


def test_an_act_that_fails_is_refused():
    scenario = load_scenario(ROOT / "scenarios" / "caroca.yaml")
    parts = build(scenario)
    slipping = Slipping(parts.backend.robot, parts.backend.gravity, parts.backend.physics_step, None)
    loop = Loop(dataclasses.replace(parts, backend=slipping))
    loop.warm_up(scenario.initial.state())
    with pytest.raises(PluginError, match=r"t = 0.001 s: Slipping gave up a step with code 7"):
        loop.run(np.zeros((3, len(loop.row))), lambda count: None)
