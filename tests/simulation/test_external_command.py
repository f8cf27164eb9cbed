"""Commands from outside: any array that holds them is taken, and all are recorded."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT

import cdpr
from cdpr.simulation.build import build
from cdpr.simulation.loop import Loop
from cdpr.simulation.record import BLOCK

CAROCA = str(ROOT / "scenarios" / "caroca.yaml")
LONG = {"simulation.duration": 5.0}
COUNT = BLOCK + 100


def wrenches(count):
    """More than one block, none like the one before."""
    return np.array([0.0, 0.0, 700.0, 0.0, 0.0, 0.0]) + np.random.default_rng(3).normal(0.0, 1.0, (count, 6))


def test_a_session_of_many_commands_and_branches_repeats_itself(tmp_path):
    given, saved = wrenches(COUNT), tmp_path / "saved.yaml"
    with cdpr.Simulation(CAROCA, overrides=LONG) as sim:
        for k, wrench in enumerate(given):
            if k % 100 == 50:
                sim.step(2, tension=np.full(8, 400.0 + k))
            if k in (7, 70):
                here = sim.snapshot()
                sim.step(3, wrench=-wrench)
                sim.step(tension=np.full(8, 50.0))
                sim.restore(here)
            sim.step(wrench=wrench)
        sim.step(5)
        sim.save(saved)
        run = sim.run()
    assert run.rows.tobytes() == cdpr.simulate(saved).rows[: len(run.rows)].tobytes()
    assert len(saved.with_name("saved_outside.csv").read_text().splitlines()) == 1 + COUNT + COUNT // 100


KINDS = {
    "list": list,
    "read-only": lambda values: np.frombuffer(values.tobytes()),
    "strided": lambda values: np.repeat(values, 2)[::2],
    "float32": lambda values: values.astype(np.float32),
    "big-endian": lambda values: values.astype(">f8"),
    "integers": lambda values: values.astype(int),
    "memoryview": memoryview,
}


@pytest.mark.parametrize("kind", KINDS)
def test_any_array_that_holds_them_is_taken(kind):
    wrench, tension = np.array([8.0, 0, 700, 0, 0, 1]), np.arange(400.0, 408.0)
    rows = []
    for convert in (lambda values: values, KINDS[kind]):
        with cdpr.Simulation(CAROCA, overrides={"simulation.duration": 0.05}) as sim:
            sim.step(2, wrench=convert(wrench))
            sim.step(3, tension=convert(tension))
            sim.step(wrench=convert(wrench))
            sim.step(100, tension=convert(tension))
            rows.append(sim.run().rows)
    assert rows[0].tobytes() == rows[1].tobytes()


def test_a_changed_array_changes_no_command_before():
    wrench = np.array([8.0, 0, 700, 0, 0, 1])
    with cdpr.Simulation(CAROCA, overrides=LONG) as sim:
        sim.step(wrench=wrench)
        wrench[:] = 0.0
        sim.step(3, wrench=[8.0, 0, 700, 0, 0, 1])
        run = sim.run()
    np.testing.assert_array_equal(run.wrench, np.tile([8.0, 0, 700, 0, 0, 1], (4, 1)))


def test_the_step_of_a_loop_apart_stays_so_where_events_change_it():
    """Other threads of a batch wait otherwise."""
    loop = Loop(build(cdpr.load_scenario(CAROCA)))
    loop.pipeline.release_gil()
    loop.revise((), loop.parts.trajectory)
    for pipeline in (loop.pipeline, loop.outside.command("wrench").pipeline):
        assert pipeline._run_compiled == pipeline.whole.unlocked
