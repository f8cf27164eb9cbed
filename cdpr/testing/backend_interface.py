"""Checks of a backend's interface: arrays, repeatability, instances, snapshots, output, leaks."""

from __future__ import annotations

import contextlib
import gc
import os
import tempfile
from pathlib import Path

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.model.robot import Array
from cdpr.plugins import Backend
from cdpr.tension.operations import Operation, perform
from cdpr.testing import samples
from cdpr.testing.check import Check, expect, expect_close, expect_same_bits, needs
from cdpr.testing.columns import expect_written
from cdpr.testing.process import OutputCapture, descriptors, resident_bytes, threads
from cdpr.testing.subjects import BackendSubject

CLOCK = 1e-6  # share by which an engine's summed time may differ from the number of steps times the step


def _ride(subject: BackendSubject, steps: int = 200) -> Array:
    """Create a plant, simulate it with constant commands and wrench, and return the final state."""
    backend = subject.make(samples.state(np.random.default_rng(1), tilt=0.3))
    backend.command[:] = np.linspace(50.0, 120.0, 8)
    backend.external[:] = [5.0, -3.0, 400.0, 2.0, 1.0, -1.0]
    backend.step(steps)
    end = backend.state.copy()
    subject.close(backend)
    return end


def arrays_are_kept(subject: BackendSubject) -> None:
    """The attributes `command`, `external` and `state` remain the same arrays of float64.

    The plant writes only into `state`.
    """
    backend = subject.make(samples.state(np.random.default_rng(0)))
    arrays = {"command": backend.command, "external": backend.external, "state": backend.state}
    for (name, array), size in zip(arrays.items(), (8, 6, 13), strict=True):
        expect(array.shape == (size,) and array.dtype == np.float64, f"{name} is {array.dtype}{array.shape}")
    backend.command[:], backend.external[:] = 70.0, 3.0
    for _ in range(3):
        backend.step(2)
    backend.reset(samples.state(np.random.default_rng(1)))
    for name, array in arrays.items():
        expect(getattr(backend, name) is array, f"{name} was replaced by another array")
    expect((backend.command == 70.0).all() and (backend.external == 3.0).all(), "it wrote to command or external")


def made_and_closed_twice(subject: BackendSubject) -> None:
    """If a plant is closed and a second one is created in the same process, both have identical states."""
    expect_same_bits(_ride(subject), _ride(subject), "state of a second plant after 200 steps")


def reset_forgets(subject: BackendSubject) -> None:
    """After `reset`, the states are identical to those of a new plant."""
    rng = np.random.default_rng(2)
    start, other = samples.state(rng, tilt=0.3), samples.state(rng, speed=5.0)
    fresh, used = subject.make(start), subject.make(other)
    used.command[:], used.external[:] = 500.0, 900.0
    used.step(37)
    used.reset(start)
    for backend in (fresh, used):
        backend.command[:], backend.external[:] = 60.0, 0.0
        backend.step(200)
    expect_same_bits(used.state, fresh.state, "state after a reset and 200 steps")


def platform_is_renewed(subject: BackendSubject) -> None:
    """After `renew(robot)` and `reset`, the states are identical to those of a new plant for this robot.

    Skipped if `renew` returns False.
    """
    start, robot = samples.state(np.random.default_rng(2), tilt=0.3), samples.laden(samples.free())
    fresh, used = subject.make(start, robot), subject.make(start)
    used.step(37)
    needs(used.renew(robot), "it does not support renew")
    used.reset(start)
    for backend in (fresh, used):
        backend.command[:] = 60.0
        backend.step(200)
    expect_same_bits(used.state, fresh.state, "state after 200 steps with the other platform")


def steps_add_up(subject: BackendSubject) -> None:
    """The call `step(10)` gives the same state as ten calls of `step(1)`.

    Command and external wrench are constant. The call `step(0)` changes nothing.
    """
    start = samples.state(np.random.default_rng(3), tilt=0.3)
    whole, parts = subject.make(start), subject.make(start)
    for backend in (whole, parts):
        backend.command[:], backend.external[:] = 80.0, [50.0, 20.0, -30.0, 5.0, 4.0, 3.0]
    parts.step(0)
    expect_close(parts.state, start, 1e-11, "state after step(0)")
    whole.step(10)
    for _ in range(10):
        parts.step(1)
    expect_close(parts.state, whole.state, 1e-12, "ten steps of one against one of ten")


def operations_make_a_step(subject: BackendSubject) -> None:
    """The compiled functions of a step give the same states as the method `step`.

    The methods `operations` and `phases` return these functions. Skipped for backends without such functions.
    """
    start, steps = samples.state(np.random.default_rng(10), tilt=0.3), 20

    def loaded() -> Backend:
        backend = subject.make(start)
        backend.command[:], backend.external[:] = np.linspace(50.0, 120.0, 8), [50.0, 20.0, -30.0, 5.0, 4.0, 3.0]
        return backend

    whole, parted, phased = loaded(), loaded(), loaded()
    operations, phases = parted.operations(steps), phased.phases()
    needs(operations or phases, "it provides no operations")
    whole.step(steps)
    if operations:
        perform([Operation("", do, parted.refuse) for do in operations])
        expect_same_bits(parted.state, whole.state, "state after the operations of 20 steps")
    if phases:
        perform([Operation("", do, phased.refuse) for do in phases.several(steps)])
        expect_same_bits(phased.state, whole.state, "state after the phases of 20 steps")


def instances_are_apart(subject: BackendSubject) -> None:
    """Two plants in one process do not affect each other."""
    rng = np.random.default_rng(4)
    start, other = samples.state(rng, tilt=0.3), samples.state(rng)
    alone = subject.make(start)
    alone.command[:] = 90.0
    for _ in range(50):
        alone.step(2)
    expected = alone.state.copy()
    subject.close(alone)
    first = subject.make(start)
    second = subject.make(other, samples.ball(), samples.NO_GRAVITY, 2e-3)
    first.command[:], second.command[:] = 90.0, 5.0
    for _ in range(50):
        first.step(2)
        second.step(1)
    expect_same_bits(first.state, expected, "state with another plant beside it")


def snapshot_restores(subject: BackendSubject) -> None:
    """After `restore`, the plant repeats the states and times that followed the snapshot.

    Skipped if the backend does not declare `snapshot`.
    """
    needs(subject.properties.get("snapshot"), "it does not declare snapshot")
    backend = subject.make(samples.state(np.random.default_rng(5), tilt=0.3))
    backend.command[:], backend.external[:] = np.linspace(40.0, 130.0, 8), [1.0, 2.0, 3.0, 0.4, 0.5, 0.6]
    backend.step(50)
    here, snapshot, time = backend.state.copy(), backend.snapshot(), backend.engine_time()
    backend.step(200)
    there, end = backend.state.copy(), backend.engine_time()
    for _ in range(2):
        backend.step(13)
        backend.restore(snapshot)
        expect_same_bits(backend.state, here, "restored state")
        expect(backend.engine_time() == time, f"engine_time is {backend.engine_time()}, expected {time}")
        backend.step(200)
        expect_same_bits(backend.state, there, "state 200 steps after the snapshot")
        expect(backend.engine_time() == end, f"engine_time is {backend.engine_time()}, expected {end}")


def columns_are_written(subject: BackendSubject) -> str:
    """In each sample, the plant writes finite numbers into all columns of the log that the backend declares.

    It writes nothing outside these columns. Skipped if it declares no columns.
    """
    start = samples.state(np.random.default_rng(9), tilt=0.3)
    backend = subject.make(start)

    def work(k: int) -> None:
        if k:  # the first sample is the state after reset
            backend.command[:] = 40.0 + k
            backend.step(2)

    return expect_written(subject.columns, backend.robot, backend, lambda: backend.reset(start), work)


def clock_counts_steps(subject: BackendSubject) -> None:
    """The method `engine_time` returns the number of steps since `reset`, multiplied by the step size.

    Skipped if it returns None.
    """
    backend = subject.make(samples.state(np.random.default_rng(6)), step=2e-3)
    needs(backend.engine_time() is not None, "it has no engine_time")
    for _ in range(2):
        expect_close(backend.engine_time() or 0.0, 0.0, 0.0, "clock after a reset, s")
        for k in range(1, 41):
            backend.step(5)
            expect_close(backend.engine_time() or 0.0, 5 * k * 2e-3, CLOCK * 5 * k * 2e-3, "clock, s")
        backend.reset(samples.state(np.random.default_rng(6)))


def keeps_quiet(subject: BackendSubject) -> None:
    """The plant prints nothing and leaves no file in the working folder, even if an input is NaN."""
    with tempfile.TemporaryDirectory() as folder, OutputCapture(Path(folder)) as silence:
        backend = subject.make(samples.state(np.random.default_rng(7)))
        backend.step(10)
        backend.external[0] = np.nan
        with contextlib.suppress(CdprError):  # it may reject the input
            backend.step(3)
        backend.reset(samples.state(np.random.default_rng(8)))
        subject.close(backend)
        gc.collect()
    expect(not silence.output, f"printed {silence.output[:200]!r}")
    expect(not silence.left, f"left {', '.join(silence.left)} in the working folder")


def nothing_leaks(subject: BackendSubject) -> None:
    """Closed plants leave no open files, threads or memory.

    The kit creates and closes 40 plants. The process may then have at most one more open file, one more thread and 4 MB
    more memory.
    """
    needs(os.path.isdir("/proc/self/fd"), "only Linux reports the resources of a process")

    def cycle(count: int) -> tuple[int, int, int]:
        for seed in range(count):
            backend = subject.make(samples.state(np.random.default_rng(seed)))
            backend.step(5)
            subject.close(backend)
            del backend
        gc.collect()
        return descriptors(), threads(), resident_bytes()

    before, after = cycle(20), cycle(40)
    expect(after[0] - before[0] <= 1, f"{after[0] - before[0]} more open files after 40 plants")
    expect(after[1] - before[1] <= 1, f"{after[1] - before[1]} more threads after 40 plants")
    expect(after[2] - before[2] <= 4_000_000, f"{(after[2] - before[2]) / 1e6:.1f} MB more after 40 plants")


CHECKS = [
    Check(function)
    for function in (
        arrays_are_kept,
        made_and_closed_twice,
        reset_forgets,
        platform_is_renewed,
        steps_add_up,
        operations_make_a_step,
        instances_are_apart,
        snapshot_restores,
        columns_are_written,
        clock_counts_steps,
        keeps_quiet,
        nothing_leaks,
    )
]
