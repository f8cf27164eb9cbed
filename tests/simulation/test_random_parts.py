"""A part of the loop with random numbers: its stream is part of snapshots, resets and rollouts."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import pytest
from conftest import ROOT
from restarts import assert_restarts_give

import cdpr
from cdpr.base.column import Column
from cdpr.native.bind import bind
from cdpr.native.random_numbers import Stream, normal_numbers
from cdpr.simulation import loop_parts
from cdpr.simulation.loop_part import LoopPart
from cdpr.tension.operations import Operation

CAROCA = str(ROOT / "scenarios" / "caroca.yaml")
SHORT = {"simulation.duration": 0.05}


class Noise(LoopPart):
    """Draws three normal numbers in each sample, compiled or from Python."""

    name = "noise"
    columns = (Column("noise", 3, "", "Normal numbers"),)

    def __init__(self, seed, compiled):
        self.stream, self.compiled = Stream(seed, self.name), compiled
        self.streams = (self.stream,)

    def connect(self, surroundings):
        self.column = surroundings.columns["noise"]

    def observed(self, period):
        if self.compiled:
            return [Operation(self.name, bind("normal_numbers", state=self.stream.state, numbers=self.column))]
        return [Operation(self.name, self.draw)]

    def draw(self):
        self.column[:] = normal_numbers(self.stream.state, 3)


@pytest.fixture(params=["compiled", "python"])
def noise(request, monkeypatch):
    def part(scenario):
        return Noise(scenario.simulation.seed, request.param == "compiled")

    monkeypatch.setattr(loop_parts, "LOOP_PARTS", [part])
    return cdpr.simulate(CAROCA, overrides=SHORT)


def expected(seed, samples):
    return normal_numbers(Stream(seed, "noise").state, 3 * samples).reshape(-1, 3)


def test_a_run_draws_the_stream_from_its_beginning(noise):
    assert noise["noise"].tobytes() == expected(0, len(noise.time)).tobytes()  # no trace of the warm-up


def test_a_snapshot_and_a_reset_contain_the_stream(noise):
    assert_restarts_give(noise.rows.tobytes(), CAROCA, SHORT)
    with cdpr.Simulation(CAROCA, overrides=SHORT) as simulation:
        simulation.step(20)
        simulation.reset(seed=7)
        simulation.step(50)
        assert simulation.run()["noise"].tobytes() == expected(7, 51).tobytes() != noise["noise"].tobytes()


def test_rollouts_have_the_bits_of_single_runs(noise):
    seeds = list(range(10))  # more than lanes
    batch = cdpr.rollout(CAROCA, 10, vary={"simulation.seed": seeds}, overrides=SHORT, columns=["noise", "position"])
    for i, seed in enumerate(seeds):
        assert batch["noise"][i].tobytes() == expected(seed, 51).tobytes()
        assert batch["position"][i].tobytes() == noise.position.tobytes()


def test_rollouts_of_other_masses_draw_the_same_numbers(noise):
    vary = {"robot.platform.mass": [150.0, 160.0, 170.0]}
    batch = cdpr.rollout(CAROCA, 3, vary=vary, overrides=SHORT, columns=["noise"])
    assert all(each.tobytes() == noise["noise"].tobytes() for each in batch["noise"])


def test_threads_do_not_share_a_stream(noise):
    with ThreadPoolExecutor(2) as threads:
        runs = list(threads.map(lambda _: cdpr.simulate(CAROCA, overrides=SHORT), range(2)))
    assert all(run.rows.tobytes() == noise.rows.tobytes() for run in runs)
