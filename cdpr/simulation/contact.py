"""Ends a run at the first sample at which cables are nearer to something than its scenario allows."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

import numpy as np

from cdpr.errors import Touched
from cdpr.mechanics.clearance import Clearance, Watch, clearance, too_near
from cdpr.mechanics.contacts import passing
from cdpr.model.robot import Array
from cdpr.scenario.events import ScenarioEvent, broken
from cdpr.scenario.events.event import Guard
from cdpr.simulation.parts import Parts
from cdpr.tension.acts import Act


def keeping_distance(parts: Parts, events: Sequence[ScenarioEvent], guards: Sequence[Guard], state: Array) -> list[Act]:
    """Return what looks at each sample; raises Touched.

    Args:
        parts: of the loop.
        events: what happens in it; cables that break touch nothing any more.
        guards: that stop it.
        state: (13,) of the present sample, live.
    """
    among = clearance(parts.robot, parts.obstacles)
    gone = np.full(parts.robot.m, math.inf)
    for cable, time in broken(events, [cable.name for cable in parts.robot.cables], parts.control_step):
        gone[cable] = min(gone[cable], time)
    return [_keeping(among, guard, gone, state[:7]) for guard in guards]


def _keeping(among: Clearance, guard: Guard, gone: Array, pose: Array) -> Act:
    bodies = among.bodies._replace(radius=among.bodies.radius.copy())
    watch = Watch(among.bodies.radius, gone, np.array([guard.clearance, guard.after]), np.zeros((len(gone), 6)))

    def stop(_: int) -> None:
        here = among.without(np.flatnonzero(np.isinf(bodies.radius)))
        least, which = here.at(pose[None], plain=True)
        allowed = f"at {guard.clearance:g} m" if guard.clearance else "where they touch"
        names, gap = among.name(int(which[0])), float(least[0])
        text = passing(names, gap) or f"the least clearance is {gap:.4g} m, of {names}"
        raise Touched(f"{text}; the scenario says to stop {allowed}")

    return Act("cables", partial(too_near, bodies, watch, pose), stop, timed=True)
