"""State that the controller sees, beside the true one, written by parts that only this file knows."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT

import cdpr
from cdpr.mechanics.kinematics import wrench_matrix
from cdpr.native.bind import bind
from cdpr.simulation import loop_parts
from cdpr.simulation.loop_part import LoopPart
from cdpr.tension.operations import Operation

CARRIAGE = str(ROOT / "scenarios" / "carriage.yaml")
PLANAR = str(ROOT / "scenarios" / "planar.yaml")
OFFSET, DELAY = 0.02, 5  # m, control steps
SPEED, STEP = 0.5, 0.001  # m/s, s
DOF = [0, 2, 4]  # of the planar robot
RIDE = {
    "simulation.duration": 2.5,
    "initial": {"position": [-0.6, 0, 0.5], "velocity": [SPEED, 0, 0]},
    "trajectory": {
        "type": "waypoints",
        "points": [
            {"time": t, "position": [-0.6 + SPEED * t, 0, 0.5], "velocity": [SPEED, 0, 0], "acceleration": [0, 0, 0]}
            for t in (0.0, 2.6)
        ],
    },
}
SHORT = {"simulation.duration": 0.06}


class Late(LoopPart):
    """State of some control steps ago, with an offset along x."""

    name = "late"
    writes = frozenset({"seen"})

    def __init__(self, offset=OFFSET, delay=DELAY):
        self.offset, self.delay = offset, delay

    def connect(self, surroundings):
        self.now, self.memory = surroundings, np.zeros((self.delay + 1, 13))
        self.arrays = (self.memory,)

    def observed(self, period):
        return [Operation(self.name, lambda: self.shift(first=period == 0.0))]

    def shift(self, first):
        self.memory[:-1] = self.now.state if first else self.memory[1:]
        self.memory[-1] = self.now.state
        self.now.seen[:] = self.memory[0]
        self.now.seen[0] += self.offset


class Compiled(LoopPart):
    """State of the previous control step, by operations of the kernel library."""

    name = "compiled"
    writes = frozenset({"seen"})

    def connect(self, surroundings):
        self.now, self.memory = surroundings, np.zeros(13)
        self.arrays = (self.memory,)

    def observed(self, period):
        keep = Operation(self.name, bind("copy", source=self.now.state, target=self.memory))
        show = Operation(self.name, bind("copy", source=self.memory, target=self.now.seen))
        return [show, keep] if period else [keep, show]


class Nothing(LoopPart):
    """Part that declares to write, and does not."""

    name = "nothing"
    writes = frozenset({"seen", "seen_cables"})


def use(monkeypatch, *makers):
    monkeypatch.setattr(loop_parts, "LOOP_PARTS", [lambda scenario, make=make: make() for make in makers])


def state_of(run, k):
    return np.concatenate([run.position[k], run.orientation[k], run.velocity[k], run.angular_velocity[k]])


def test_the_platform_is_ahead_by_the_delay_and_behind_by_the_offset(monkeypatch):
    use(monkeypatch, Late)
    run = cdpr.simulate(CARRIAGE, overrides=RIDE)
    error = run.position[:, 0] - run.desired_position[:, 0]
    assert error[0] == pytest.approx(0.0, abs=1e-12)
    assert error[-200:] == pytest.approx(SPEED * DELAY * STEP - OFFSET, abs=1e-7)


def test_columns_of_the_truth_belong_to_the_true_state(monkeypatch):
    use(monkeypatch, Late)
    run = cdpr.simulate(PLANAR, overrides=SHORT)
    robot = cdpr.load_scenario(PLANAR).robot
    for k in (0, 20, 60):
        true = wrench_matrix(robot, state_of(run, k))
        assert true @ run.tension[k] == pytest.approx(run.true_wrench[k], abs=1e-9)
        seen = state_of(run, max(k - DELAY, 0))
        seen[0] += OFFSET
        exerted = wrench_matrix(robot, seen) @ run.tension[k]
        assert exerted[DOF] == pytest.approx(run.wrench[k][DOF], abs=1e-6)
    assert np.abs(run.true_wrench - run.wrench)[:, DOF].max() > 1.0
    low, high = robot.tension_min, robot.tension_max
    assert np.array_equal(run.true_margin, np.minimum(run.tension - low, high - run.tension))


def test_a_seen_state_without_error_changes_no_bit(monkeypatch):
    plain = cdpr.simulate(PLANAR, overrides=SHORT)
    use(monkeypatch, Nothing)
    run = cdpr.simulate(PLANAR, overrides=SHORT)
    assert np.ascontiguousarray(run.rows[:, : plain.rows.shape[1]]).tobytes() == plain.rows.tobytes()
    assert "true_wrench" in run.header.layout.fields
    assert "true_wrench" not in plain.header.layout.fields


def test_a_loop_without_such_parts_has_one_state():
    with cdpr.Simulation(PLANAR, overrides=SHORT) as simulation:
        present = simulation._loop.present
        assert present.seen is present.state
        assert present.true_W is present.live.W
        assert present.perceived == ()


@pytest.mark.parametrize("make", [Late, Compiled])
def test_snapshot_restore_reset_and_rollout_have_the_same_bits(monkeypatch, make):
    use(monkeypatch, make)
    whole = cdpr.simulate(PLANAR, overrides=SHORT)
    with cdpr.Simulation(PLANAR, overrides=SHORT) as simulation:
        simulation.step(20)
        snapshot = simulation.snapshot()
        simulation.step(15)
        simulation.restore(snapshot)
        simulation.step(40)
        assert simulation.so_far().rows.tobytes() == whole.rows.tobytes()
        simulation.reset()
        simulation.step(60)
        assert simulation.so_far().rows.tobytes() == whole.rows.tobytes()
    masses = [8.0, 10.0, 12.0]
    columns = ["position", "tension", "true_wrench"]
    batch = cdpr.rollout(PLANAR, 3, vary={"robot.platform.mass": masses}, overrides=SHORT, columns=columns)
    for i, mass in enumerate(masses):
        run = cdpr.simulate(PLANAR, overrides={**SHORT, "robot.platform.mass": mass})
        for name in columns:
            assert np.array_equal(batch[name][i], run[name])


def test_compiled_parts_keep_the_pipeline_compiled(monkeypatch):
    use(monkeypatch, Compiled)
    plain = cdpr.simulate(PLANAR, overrides={**SHORT, "simulation.backend": "reference"})
    assert plain.interpreted == ()


def test_parts_can_write_what_they_declare_only(monkeypatch):
    class Undeclared(Late):
        writes = frozenset()

    use(monkeypatch, Undeclared)
    with pytest.raises(cdpr.PluginError, match="read-only"):
        cdpr.simulate(PLANAR, overrides=SHORT)


def test_the_controller_senses_the_written_lengths(monkeypatch):
    class Encoders(LoopPart):
        name = "encoders"
        writes = frozenset({"seen_cables"})

        def connect(self, surroundings):
            self.now = surroundings

        def observed(self, period):
            return [Operation(self.name, self.shift)]

        def shift(self):
            self.now.seen_cables[0] += 0.01

    use(monkeypatch, Encoders)
    with cdpr.Simulation(PLANAR, overrides=SHORT) as simulation:
        simulation.step(5)
        loop = simulation._loop
        length, rate = loop.present.seen_cables
        assert np.array_equal(length, loop.present.view("length") + 0.01)
        assert np.array_equal(rate, loop.present.view("rate"))
        assert loop.present.seen is loop.present.state
        assert "true_wrench" not in loop.layout.fields


def test_a_seen_state_that_is_not_finite_ends_the_run(monkeypatch):
    use(monkeypatch, lambda: Late(offset=np.nan))
    with pytest.raises(cdpr.Diverged, match="the state that the controller sees is not finite; written by 'late'"):
        cdpr.simulate(PLANAR, overrides=SHORT)
