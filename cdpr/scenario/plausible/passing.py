"""Check of motions through positions at which the direction of a cable jumps."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.scenario.plausible.passages import passages
from cdpr.scenario.plausible.setup import Finding, Setup
from cdpr.trajectory import Stopping


def through_singular_places(setup: Setup) -> Iterator[Finding]:
    """Yield motions in which a cable passes its anchor, or the swivel axis of its pulley.

    Passages after a stop are not searched, because the motion after it depends on the run.
    """
    if setup.run is None or setup.desired is None:
        return
    try:
        motion = setup.desired()
    except CdprError:
        return  # reported by the run's own checks
    robot, end = setup.robot, setup.run.simulation.duration
    if isinstance(motion, Stopping):
        end = min(end, motion.begin)
    swivels = [cable.exit.swivel() if cable.exit else None for cable in robot.cables]
    axes = np.array([swivel or (0.0, 0.0, 0.0) for swivel in swivels])
    found = passages(motion.segments, robot.anchors, axes, end)
    if not found:
        return
    first, more = found[0], len(found) - 1
    name = robot.cables[first.cable].name
    where, what = ("swivel axis", "pulley turns over") if first.axis else ("anchor", "direction turns round")
    text = f"cable '{name}' passes its {where} at {first.time:.4g} s, where its {what} within a step"
    text += f" (and {more} more passage{'s' * (more > 1)})" if more else ""
    yield ("trajectory",), f"{text}: results are not reliable from there on; move the path or the anchor"
