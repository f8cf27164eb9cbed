"""Check of drums that become empty along the motion."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.cables.drums import first_emptied
from cdpr.cables.transmission import GROWTH
from cdpr.mechanics.kinematics import lengths
from cdpr.scenario.plausible.setup import Finding, Setup

SHARES = np.linspace(0.0, 1.0, 33)  # of each segment
MOST = 4000  # samples


def empty_drums(setup: Setup) -> Iterator[Finding]:
    """Yield drums whose radius shrinks to nothing along the desired motion."""
    robot = setup.robot
    if setup.run is None or setup.desired is None or not any(GROWTH.of(each, 0.0) > 0.0 for each in robot.cables):
        return
    try:
        motion = setup.desired()
    except CdprError:
        return  # reported by the run's own checks
    end = setup.run.simulation.duration
    times = np.clip(motion.segments[:, :1] + motion.segments[:, 1:2] * SHARES, 0.0, end)
    times = np.unique(np.append(times, [0.0, end]))
    times = times[:: -(-len(times) // MOST)]
    found = first_emptied(robot, np.array([lengths(robot, motion.sample(time)[:13]) for time in times.tolist()]))
    if found is None:
        return
    k, i, text = found
    own = setup.section.cables[i].winch
    place = ("cables", i) if own is not None and GROWTH.key in own.model_fields_set else ()
    yield (*setup.root, *place, "winch", GROWTH.key), f"at {times[k]:.4g} s of the motion, {text}"
