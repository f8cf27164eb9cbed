"""Operations that advance the plant of a loop by a control step, and check its clock."""

from __future__ import annotations

from functools import partial

import numpy as np

from cdpr.base.errors import Diverged
from cdpr.native.bind import bind
from cdpr.plugins import Backend
from cdpr.plugins.compiled import speaks_for
from cdpr.tension.operations import Operation

MOST_SUBSTEPS = 100  # each with its own operations


def moving(backend: Backend, substeps: int) -> list[Operation]:
    """Return the operations of the backend's physics steps in one control step."""
    known = substeps <= MOST_SUBSTEPS and isinstance(backend, Backend) and speaks_for(backend.operations, backend.step)
    operations = backend.operations(substeps) if known else None
    if not operations:
        return [Operation("backend", partial(backend.step, substeps))]
    return [Operation("backend", do, backend.refuse) for do in operations]


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
