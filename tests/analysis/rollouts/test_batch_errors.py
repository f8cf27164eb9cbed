"""Batches: invalid calls, concurrent calls and closed batches."""

from __future__ import annotations

import threading

import numpy as np
import pytest
from batch_cases import BRIEF, GAINS, WINCH, alone, assert_same, make

import cdpr
from cdpr.analysis.rollouts import case as case_module

WRONG = {
    "lanes": (lambda batch: make(n=0), "Batch: lanes: expected a whole number of cases"),
    "every value": (lambda batch: make(n=2, vary={"robot.platform.mass": [-1.0, -2.0]}), "robot.platform.mass"),
    "steps": (lambda batch: batch.step(0), "step: expected a whole number of steps"),
    "kind of steps": (lambda batch: batch.step(True), "step: expected a whole number of steps"),
    "mask": (lambda batch: batch.step(mask=[True]), r"mask: expected \(2,\) of bool"),
    "numbers as mask": (lambda batch: batch.step(mask=[1, 0]), r"mask: expected \(2,\) of bool"),
    "lane": (lambda batch: batch.reset(2), "expected the number of a lane, 0 to 1, got 2"),
    "negative lane": (lambda batch: batch.load(-1, None), "expected the number of a lane, 0 to 1, got -1"),
    "snapshot": (lambda batch: batch.load(0, "start"), "load: expected a snapshot"),
    "another robot": (lambda batch: batch.load(0, alone(0, WINCH).snapshot()), "load: the snapshot is of another"),
    "another step": (
        lambda batch: batch.load(0, alone(3, **{"simulation.control_step": 0.002}).snapshot()),
        "load: the snapshot is of another control step than that of the lane, 0.001 s",
    ),
    "ragged mask": (lambda batch: batch.step(mask=[[True], [True, False]]), "step: mask: .*inhomogeneous"),
    "masked mask": (lambda batch: batch.step(mask=np.ma.masked_equal([True, False], True)), "step: mask: .*masked"),
    "masked lanes": (lambda batch: batch.reset(np.ma.masked_equal([0, 1], 1)), "reset: .*masked"),
    "ragged lanes": (lambda batch: batch.reset([[0], [1, 1]]), "reset: .*inhomogeneous"),
    "array as column": (lambda batch: batch.column(np.zeros(2)), "unknown column"),
    "column": (lambda batch: batch.column("positon"), "unknown column 'positon'.*position"),
}


@pytest.mark.parametrize("name", WRONG)
def test_mistakes(name):
    do, text = WRONG[name]
    batch = make(n=2)
    before = batch.rows.copy()
    with pytest.raises(cdpr.CdprError, match=text):
        do(batch)
    assert np.array_equal(batch.rows, before)
    batch.step(2)
    assert (batch.samples == 2).all()


def test_a_state_after_the_end_is_refused():
    batch = make(n=2, vary=None, overrides={**BRIEF, "simulation.duration": 0.01})
    with pytest.raises(cdpr.CdprError, match="after the end of the lane"):
        batch.load(0, alone(20).snapshot())


def test_two_threads_do_not_step_one_batch():
    batch = make()
    failed = []

    def step():
        for _ in range(20):
            try:
                batch.step(1)
            except cdpr.CdprError as error:
                failed.append(str(error))

    threads = [threading.Thread(target=step) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    done = 40 - len(failed)
    assert (batch.samples == done).all()
    assert_same(batch, 4, alone(done, **{"controller.kp": GAINS[4]}))


def test_a_closed_batch_has_no_lanes():
    with make(n=2) as batch:
        batch.step()
    assert not batch.active.any()
    batch.close()
    for call in (batch.step, batch.reset, lambda: batch.snapshot(0)):
        with pytest.raises(cdpr.CdprError, match="the batch is closed"):
            call()


def test_a_batch_cannot_be_closed_while_a_step_runs(monkeypatch):
    begun, going, go = threading.Event(), threading.Event(), case_module.Case.go

    def wait(*given):
        begun.set()
        assert going.wait(10.0)
        go(*given)

    monkeypatch.setattr(case_module.Case, "go", wait)
    batch = make(n=2)
    thread = threading.Thread(target=batch.step, args=(5,))
    thread.start()
    try:
        assert begun.wait(10.0)
        with pytest.raises(cdpr.CdprError, match=r"close: .* executing a step"):
            batch.close()
    finally:
        going.set()
        thread.join()
    assert (batch.samples.tolist(), batch.active.tolist()) == ([5, 5], [True, True])
    assert_same(batch, 1, alone(5, **{"controller.kp": GAINS[1]}))
    batch.close()
    assert not batch.active.any()


def test_large_integers_are_not_rounded():
    """numpy makes real numbers of lists with integers from 2^63 on: then the first case would be blamed."""
    seeds = [0, 1, 2, 2**63]
    short = {"simulation.duration": 0.01, "sensors": [{"type": "pose"}, {"type": "twist"}]}
    found = cdpr.rollout("caroca", 4, vary={"simulation.seed": seeds}, overrides=short)
    assert [bool(each) for each in found.messages] == [False, False, False, True]
    assert "simulation.seed" in found.messages[3]
