"""Helpers of the tests of exported robots."""

from __future__ import annotations

from dataclasses import replace

from conftest import ROOT

import cdpr
from cdpr.formats.write.export_model import begin
from cdpr.model import rotations

ROBOTS = ROOT / "scenarios" / "robots"
NAMES = ["caroca", "off_centre", "planar", "spherical", "point_mass", "carriage", "twelve"]


def subject_of(name, **pose):
    subject = begin(cdpr.load_robot(ROBOTS / f"{name}.yaml"))
    state = subject.state.copy()
    if subject.robot.n == 6:
        state[3:7] = rotations.from_rpy(0.1, -0.2, 0.3)
    return replace(subject, state=state)
