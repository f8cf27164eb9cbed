"""Check of cables that touch each other, their platform or an obstacle at the start."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cdpr.base import tolerances
from cdpr.cables import bends
from cdpr.mechanics.assumed_diameters import assumption, least_clearance
from cdpr.mechanics.contacts import passing
from cdpr.model.rotations import matrix
from cdpr.scenario.plausible.setup import Finding, Setup
from cdpr.scenario.plausible.sizes import THICKEST


def touching(setup: Setup) -> Iterator[Finding]:
    """Yield start poses at which a cable touches something.

    Excluded are rigid legs, whose shape is unknown, and cables that are too thick, which `cable_sizes` reports.
    """
    robot = setup.robot
    if not robot.unilateral or any((cable.diameter or 0.0) > THICKEST for cable in robot.cables):
        return
    for path, position, attitude in setup.starts():
        chords = robot.anchors[:, :3] - position - robot.anchors[:, 3:] @ matrix(attitude).T
        if np.linalg.norm(chords, axis=1).min() < tolerances.LENGTH:
            continue
        least = least_clearance(robot, np.concatenate([position, attitude]), setup.obstacles)
        if least is not None and least[0] < 0.0:
            gap, names = least
            text = passing(names, gap) or f"{names} touch here: their clearance is {1e3 * gap:.4g} mm"
            straight = ", along the chords of sagging cables" if bends(robot) else ""
            yield path, f"{text}{assumption(robot)}{straight}"
