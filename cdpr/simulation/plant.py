"""Operations that advance plants by a control step, and check their clocks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial

import numpy as np

from cdpr.base.errors import Diverged, PluginError
from cdpr.native.bind import bind
from cdpr.plugins import Backend
from cdpr.plugins.backend import Operations, Phases, check_operations, checked_phases
from cdpr.plugins.compiled import speaks_for
from cdpr.tension.operations import Operation

MOST_SUBSTEPS = 100  # each with its own operations


def moving(backends: Sequence[Backend], substeps: int) -> list[Operation]:
    """Return the operations of the physics steps of these plants in one control step.

    Platforms in one engine world all load it before each of its steps, and all read it afterwards.

    Args:
        backends: backends of the platforms.
        substeps: number of physics steps.

    Raises:
        PluginError: if a backend shares its world and does not separate its platform from it.
    """
    worlds: dict[int, list[Backend]] = {}
    for backend in backends:
        world = getattr(backend, "shared_world", None)
        worlds.setdefault(id(backend if world is None else world), []).append(backend)
    moved: list[Operation] = []
    for group in worlds.values():
        moved += _alone(group[0], substeps) if len(group) == 1 else _together(group, substeps)
    return moved


def _alone(backend: Backend, substeps: int) -> list[Operation]:
    """Return the operations of a platform in a world of its own."""
    known = substeps <= MOST_SUBSTEPS and isinstance(backend, Backend) and speaks_for(backend.operations, backend.step)
    operations = backend.operations(substeps) if known else None
    if operations is not None:
        check_operations(operations, f"{type(backend).__name__}.operations")
    if not operations:
        return [Operation("backend", partial(backend.step, substeps))]
    return list(_named(backend, operations))


def _together(backends: Sequence[Backend], substeps: int) -> list[Operation]:
    """Return the operations of platforms in one world, whose steps are those of the first backend."""
    parts = [(backend, _phases_of(backend)) for backend in backends]
    step = [
        *(each for backend, phases in parts for each in _named(backend, phases.load)),
        *_named(backends[0], parts[0][1].step),
        *(each for backend, phases in parts for each in _named(backend, phases.read)),
    ]
    return step * substeps + [each for backend, phases in parts for each in _named(backend, phases.publish)]


def _phases_of(backend: Backend) -> Phases:
    known = isinstance(backend, Backend) and speaks_for(backend.phases, backend.step)
    phases = backend.phases() if known else None
    if phases is None:
        raise PluginError(
            f"{type(backend).__name__} shares its engine's world, and does not separate its platform from it: "
            "implement `phases`"
        )
    return checked_phases(phases, f"{type(backend).__name__}.phases")


def _named(backend: Backend, operations: Operations) -> Iterable[Operation]:
    return (Operation("backend", do, backend.refuse) for do in operations)


def clock_operations(backend: Backend) -> tuple[list[Operation], list[Operation]]:
    """Return the operations that read an engine's clock and compare it with the time; none without a clock."""
    if backend.engine_time() is None:
        return [], []
    clock = np.zeros(1)  # s

    def refuse(_: int) -> None:
        raise Diverged(f"the engine's clock reads {clock[0]:.6g} s: it reset itself")

    known = isinstance(backend, Backend) and speaks_for(backend.clock_act, backend.engine_time)
    reader = backend.clock_act if known else partial(Backend.clock_act, backend)
    checking = Operation("clock", bind("clock_differs", clock=clock), refuse, timed=True)
    return [Operation("backend", reader(clock))], [checking]
