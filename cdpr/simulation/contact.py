"""End of a run at the first sample with a clearance below the limit of its scenario."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from cdpr.base.errors import CollisionDetected
from cdpr.mechanics.clearance import Clearance, clearance
from cdpr.mechanics.contacts import passing
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.scenario.events import ScenarioEvent, broken
from cdpr.scenario.events.event import ClearanceMonitor
from cdpr.simulation.parts import Parts
from cdpr.tension.operations import Operation


def keeping_distance(
    parts: Parts,
    events: Sequence[ScenarioEvent],
    guards: Sequence[ClearanceMonitor],
    state: Array,
    unwound: Array | None = None,
) -> list[Operation]:
    """Return an observer of each sample, which raises CollisionDetected.

    Args:
        parts: parts of the loop.
        events: events of the loop; broken cables are ignored.
        guards: guards that stop the run.
        state: (13,) state of the present sample, live.
        unwound: (m,) unwound lengths of cables that sag [m], live; None if none sags.
    """
    among = clearance(parts.robot, parts.obstacles, gravity=parts.backend.gravity)
    gone = np.full(parts.robot.m, math.inf)
    for cable, time in broken(events, [cable.name for cable in parts.robot.cables], parts.control_step):
        gone[cable] = min(gone[cable], time)
    return [_keeping(among, guard, gone, state[:7], unwound) for guard in guards]


def _keeping(among: Clearance, guard: ClearanceMonitor, gone: Array, pose: Array, unwound: Array | None) -> Operation:
    present = among.bodies.radius.copy()
    curved = {} if unwound is None else {**among.sagging, "unwound": unwound}
    too_near = bind(
        "sagging_too_near" if curved else "too_near",
        **among.bodies._asdict(),
        **curved,
        pose=pose,
        gone=gone,
        present=present,
        clearance=guard.clearance,
        after=guard.after,
    )

    def stop(_: int) -> None:
        here = among.without(np.flatnonzero(np.isinf(present)))
        least, which = here.at(pose[None], unwound=None if unwound is None else unwound[None])
        allowed = f"at {guard.clearance:g} m" if guard.clearance else "where they touch"
        names, gap = among.name(int(which[0])), float(least[0])
        text = passing(names, gap) or f"the least clearance is {gap:.4g} m, of {names}"
        raise CollisionDetected(f"{text}; stopped by the scenario {allowed}")

    return Operation("cables", too_near, stop, timed=True)
