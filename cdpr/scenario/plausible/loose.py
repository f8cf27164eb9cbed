"""Check of tension limits that heavy cables cannot reach."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.cables import bends
from cdpr.model.robot import Array
from cdpr.scenario.plausible.setup import Finding, Setup

SAMPLES = 25  # poses along the motion


def too_heavy(setup: Setup) -> Iterator[Finding]:
    """Yield the lower tension limit if a sagging cable needs more to carry its weight, at some pose of the motion."""
    robot = setup.robot
    if not bends(robot):
        return
    from cdpr.mechanics.sag import least_tensions  # few robots need this import

    position, orientation = _poses(setup)
    if not len(position):
        return
    least = least_tensions(robot, position, orientation, setup.gravity).max(axis=0)
    short = least - robot.tension_min
    i = int(np.argmax(short))
    if not short[i] > 0.0:
        return
    more = int((short > 0.0).sum()) - 1
    others = f" (and {more} more cable{'s' * (more > 1)})" if more else ""
    yield (
        (*setup.root, "tension", "min"),
        f"{robot.tension_min[i]:.4g} N is too low for the weight of cable '{robot.cables[i].name}'{others}, which "
        f"needs {least[i]:.4g} N at its winch: with less it sags without equilibrium; raise tension.min",
    )


def _poses(setup: Setup) -> tuple[Array, Array]:
    """Return positions (k, 3), m, and quaternions (k, 4) of home, start and motion."""
    poses = [[*position, *attitude] for _, position, attitude in setup.starts()]
    if setup.run is not None and setup.desired is not None:
        try:
            motion = setup.desired()
            times = np.linspace(0.0, setup.run.simulation.duration, SAMPLES)
            poses += [motion.sample(float(time))[:7].tolist() for time in times]
        except CdprError:
            pass  # reported by the run's own checks
    table = np.array(poses, dtype=np.float64).reshape(-1, 7)
    return table[:, :3], table[:, 3:]
