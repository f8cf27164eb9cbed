"""Platforms in one engine world: all load it, it makes one step, and all read it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from conftest import GRAVITY, ROOT
from plants import installed, plant

from cdpr.base.errors import PluginError
from cdpr.native.bind import bind
from cdpr.plugins import Backend
from cdpr.plugins.backend import Phases
from cdpr.scenario import load_scenario
from cdpr.simulation.build import build
from cdpr.simulation.loop import Loop
from cdpr.simulation.pipeline import COMPLETE, Pipeline
from cdpr.simulation.plant import moving
from cdpr.tension.operations import Operation, perform
from cdpr.testing import samples

STEPS = 50
mujoco = pytest.mark.skipif(not installed("mujoco"), reason="mujoco is not installed")


class Two:
    """Loops of two scenarios with their platforms in one world, in one pipeline with one row."""

    def __init__(self, scenarios):
        from shared_world import SharedWorld

        robots, gravity = [each.robot for each in scenarios], np.array(scenarios[0].world.gravity)
        step, substeps = scenarios[0].simulation.physics_step, scenarios[0].simulation.substeps
        self.plants = SharedWorld(robots, gravity, step).backends(robots, gravity, step)
        loops = [Loop(replace(build(s), backend=b)) for s, b in zip(scenarios, self.plants, strict=True)]
        for scenario, loop in zip(scenarios, loops, strict=True):
            loop.parts.backend.reset(scenario.initial.state())
            loop.begin(np.zeros((1, len(loop.row))), STEPS)
        stops = np.cumsum([len(loop.row) for loop in loops])
        row = np.zeros(stops[-1])
        parts = np.split(row, stops[:-1])
        self.rows = np.zeros((STEPS + 1, len(row)))
        decide, command, look = [], [], []
        for loop, part in zip(loops, parts, strict=True):
            operations = loop.pipeline.operations
            decide += [
                *operations[: operations.index(COMPLETE)],
                Operation("", bind("copy", source=loop.row, target=part)),
            ]
            command += loop.advancing[:1]
            look += loop.advancing[1 + len(moving([loop.parts.backend], substeps)) :]
        advance = [*command, *moving(self.plants, substeps), *look]
        self.pipeline = Pipeline(decide, advance, row, scenarios[0].simulation.control_step)
        self.pipeline.rows, self.pipeline.due = self.rows, STEPS + 1
        self.loops, self._stops = loops, stops

    def run(self):
        """Return the rows of each loop."""
        self.pipeline.run_until(STEPS)
        self.pipeline.decide()
        return np.split(self.rows, self._stops[:-1], axis=1)


def scenario(name, **overrides):
    return load_scenario(ROOT / "scenarios" / f"{name}.yaml", backend="mujoco", overrides=overrides)


def alone(scenario):
    """Rows of a run on cdpr's own backend."""
    loop = Loop(build(scenario))
    rows = np.zeros((STEPS + 1, len(loop.row)))
    loop.run(rows, lambda count: None)
    return rows


@mujoco
@pytest.mark.parametrize("substeps", [1, 4])
def test_two_robots_in_one_world_move_as_each_alone(substeps):
    step = {"simulation.physics_step": 1e-3 / substeps}
    scenarios = [scenario("winch", **step), scenario("off_centre_mass", **step)]
    two = Two(scenarios)
    assert two.pipeline.interpreted == ()
    for rows, each in zip(two.run(), scenarios, strict=True):
        assert np.ptp(rows[:, 1:4], axis=0).any(), "it moves"
        np.testing.assert_array_equal(rows, alone(each))


def two_points(separation):
    """Two spheres without gravity that approach each other at 2 m/s, and the operations of 100 steps."""
    from shared_world import SharedWorld

    robots = [samples.ball()] * 2
    plants = SharedWorld(robots, samples.NO_GRAVITY, 1e-3).backends(robots, samples.NO_GRAVITY, 1e-3)
    for side, backend in zip((-1.0, 1.0), plants, strict=True):
        state = np.zeros(13)
        state[0], state[3], state[7] = side * separation / 2, 1.0, -side
        backend.reset(state)
    return plants, moving(plants, 100)


@mujoco
def test_platforms_in_one_world_touch():
    (left, right), operations = two_points(0.5)
    perform(operations)
    assert 0.35 < right.state[0] - left.state[0] < 0.5
    assert left.state[7] == pytest.approx(-right.state[7])
    (left, right), operations = two_points(3.0)
    perform(operations)
    assert right.state[0] - left.state[0] == pytest.approx(3.0 - 0.2)


@mujoco
def test_the_world_makes_each_step_once():
    plants, operations = two_points(3.0)
    perform(operations)
    assert plants[0].shared_world.data.time == pytest.approx(0.1)


@pytest.mark.parametrize("backend", installed("mujoco", "bullet", "dart"))
@pytest.mark.parametrize(("robot", "start"), [("planar", "planar_state"), ("spherical", "spherical_state")])
def test_phases_of_guided_platforms_make_a_step(backend, robot, start):
    """The kit checks free ones."""
    state, ends = getattr(samples, start)(np.random.default_rng(3)), []
    for phased in (True, False):
        one = plant(backend, getattr(samples, robot)())
        one.reset(state)
        one.command[:], one.external[:] = 80.0, [5.0, 4.0, 3.0, 0.3, 0.2, 0.1]
        if phased:
            perform([Operation("", do, one.refuse) for do in one.phases().several(20)])
        else:
            one.step(20)
        ends.append(one.state.copy())
        one.close()
    assert not np.array_equal(ends[0], state)
    np.testing.assert_array_equal(*ends)


class Still(Backend):
    shared_world = "one"

    def reset(self, state):
        self.state[:] = state

    def step(self, n):
        pass


def test_backend_that_shares_its_world_needs_phases():
    plants = [Still(samples.free(), GRAVITY, 1e-3, None) for _ in range(2)]
    with pytest.raises(PluginError, match=r"Still shares its engine's world, .*: implement `phases`"):
        moving(plants, 1)
    assert len(moving(plants[:1], 1)) == 1


class Noted(Still):
    """Backend that notes its operations."""

    def __init__(self, name, world, notes):
        super().__init__(samples.free(), GRAVITY, 1e-3, None)
        self.shared_world, self.name, self.notes = world, name, notes

    def step(self, n):
        self.notes.append(f"steps {self.name}")

    def phases(self):
        return Phases(*([lambda what=what: self.notes.append(f"{what} {self.name}")] for what in Phases._fields))


def test_order_of_operations():
    notes = []
    perform(moving([Noted("a", 1, notes), Noted("b", 2, notes), Noted("c", 1, notes)], 2))
    once = ["load a", "load c", "step a", "read a", "read c"]
    assert notes == [*once, *once, "publish a", "publish c", "steps b"]


@pytest.mark.parametrize("found", [[], ("load", "step", "read"), 5])
def test_phases_of_another_type_are_rejected(found):
    class Wrong(Still):
        def phases(self):
            return found

        def step(self, n):
            pass

    plants = [Wrong(samples.free(), GRAVITY, 1e-3, None) for _ in range(2)]
    with pytest.raises(PluginError, match=r"Wrong\.phases: expected Phases, got "):
        moving(plants, 1)
