"""Bodies that are attached to the platform of an exported FMU for some time, and their variables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cdpr.fmu.export.variables import Variable, parameter
from cdpr.mechanics.attachments import Attachment

NEVER = 1e30  # s, the end of a body that stays


@dataclass(frozen=True, eq=False)
class Load:
    """Body that is attached from `start` up to `end`, s."""

    start: float
    end: float
    body: Attachment


def load_variables(loads: Sequence[Load]) -> list[Variable]:
    """Return the parameters of attached bodies; none without bodies."""
    if not loads:
        return []
    n, bodies = len(loads), [load.body for load in loads]
    start, end = [load.start for load in loads], [min(load.end, NEVER) for load in loads]
    mass, center = [body.mass for body in bodies], np.array([body.center for body in bodies])
    inertia, known = np.array([body.inertia for body in bodies]), tuple(float(body.known) for body in bodies)
    about = "inertia of each attached body about its centre of mass, platform axes"
    return [
        parameter("load_start", (n,), "s", start, "time from which each body is attached to the platform"),
        parameter("load_end", (n,), "s", end, "time at which each body is removed"),
        parameter("load_mass", (n,), "kg", mass, "mass of each attached body", least=0.0),
        parameter("load_center", (n, 3), "m", center, "centre of mass of each from the origin, platform axes"),
        parameter("load_inertia", (n, 3, 3), "kg.m2", inertia, about),
        Variable("load_known", "constant", (n,), "", known, "1 if the controller takes the body into account"),
    ]
