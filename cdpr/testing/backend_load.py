"""Checks of a backend that changes the mass of its platform during a run (property `load`)."""

from __future__ import annotations

import numpy as np

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import Backend
from cdpr.testing import samples
from cdpr.testing.check import Check, expect, expect_close, expect_same_bits, needs
from cdpr.testing.subjects import BackendSubject

STEPS = 100
ROUND_OFF = 1e-9  # in the state after some steps


def mass_changes_in_place(subject: BackendSubject) -> None:
    """The method `load` changes the mass, but neither state nor time.

    The plant then moves like a new plant with the new mass. Skipped if the backend does not declare `load`.
    """
    needs(subject.properties.get("load"), "it does not declare load")
    start = samples.state(np.random.default_rng(70), tilt=0.3)
    _moves_like_a_new_one(subject, samples.free(), start)


def guided_mass_changes_in_place(subject: BackendSubject) -> None:
    """The same as `mass_changes_in_place`, for a guided platform."""
    needs(subject.properties.get("load"), "it does not declare load")
    start = samples.planar_state(np.random.default_rng(71))
    subject.close(subject.guided(start))  # it may refuse guided platforms
    _moves_like_a_new_one(subject, samples.planar(), start)


def _moves_like_a_new_one(subject: BackendSubject, robot: Robot, start: Array) -> None:
    backend, other = subject.make(start, robot), samples.laden(robot)
    _push(backend)
    backend.step(STEPS)
    here, time = backend.state.copy(), backend.engine_time()
    backend.load(other)
    expect_same_bits(backend.state, here, "state after load")
    expect(backend.engine_time() == time, f"load changed engine_time from {time} to {backend.engine_time()}")
    backend.step(STEPS)
    fresh = subject.make(here, other)
    _push(fresh)
    fresh.step(STEPS)
    expect_close(samples.distance(backend.state, fresh.state), 0.0, ROUND_OFF, "state against a new plant")


def snapshot_restores_after_load(subject: BackendSubject) -> None:
    """The plant can restore a snapshot, even if `load` changed the mass after the snapshot.

    The kit takes a snapshot and changes the mass. Then it calls `load` with the mass at the time of the snapshot, and
    `restore`. The plant must then repeat the states that followed the snapshot. Skipped if the backend does not declare
    `load` and `snapshot`.
    """
    needs(subject.properties.get("load"), "it does not declare load")
    needs(subject.properties.get("snapshot"), "it does not declare snapshot")
    robot = samples.free()
    backend, other = subject.make(samples.state(np.random.default_rng(72), tilt=0.3)), samples.laden(robot)
    _push(backend)
    backend.step(STEPS)
    light = backend.snapshot()
    backend.step(STEPS)
    backend.load(other)
    heavy = backend.snapshot()
    backend.step(STEPS)
    end = backend.state.copy()
    for first, snapshot in ((other, heavy), (robot, light), (other, heavy)):
        backend.load(first)
        backend.restore(snapshot)
        if first is robot:
            backend.step(STEPS)
            backend.load(other)
        backend.step(STEPS)
        expect_same_bits(backend.state, end, "state after a snapshot was restored")


def _push(backend: Backend) -> None:
    backend.command[:] = np.linspace(40.0, 130.0, len(backend.command))
    backend.external[:] = [1.0, 2.0, 3.0, 0.4, 0.5, 0.6]


CHECKS = [
    Check(function) for function in (mass_changes_in_place, guided_mass_changes_in_place, snapshot_restores_after_load)
]
