"""Panels and frames of a motion evaluated without simulation."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cdpr.analysis.distribution.survey import Survey
from cdpr.model.robot import Array
from cdpr.scene import Pictures, Subject, colours, pictures
from cdpr.tension import Status
from cdpr.ui.report.plots.decimate import intervals
from cdpr.ui.report.plots.histories import points
from cdpr.ui.report.plots.overlay import Shade
from cdpr.ui.report.plots.panel import Curves, Panel
from cdpr.ui.report.style import AXES, CABLES, INK, SHADES, cable_looks, shorten


def survey_panels(survey: Survey, cables: Sequence[str]) -> dict[str, tuple[str, list[Panel]]]:
    """Return the title and panels of each figure, by id."""

    def by_cable(label: str, values: Array, least: float, height: float = 1.55) -> Panel:
        looks = cable_looks(cables)
        tones, dashes = [look["color"] for look in looks], [look["linestyle"] for look in looks]
        lines = Curves(points(survey.time, values), tones, dashes, names=cables, group="cable")
        legend = [(shorten(name), look) for name, look in zip(cables, looks, strict=True)]
        return Panel(label, (lines,), legend, least=least, height=height)

    def by_axis(label: str, values: Array, names: Sequence[str]) -> Panel:
        legend = [(name, {"color": colour}) for name, colour in zip(names, AXES, strict=True)]
        return Panel(label, (Curves(points(survey.time, values), AXES, names=names, group=label),), legend, least=1e-3)

    speed = np.linalg.norm(survey.desired[:, 7:10], axis=1, keepdims=True)
    margin = Curves(points(survey.time, survey.margin[:, None]), (INK,), names=("margin",))
    return {
        "tensions": (
            "Static and inertial tensions",
            [by_cable("cable tension (N)", survey.tension, 1.0, 3.0), Panel("margin (N)", (margin,), least=1.0)],
        ),
        "lengths": (
            "Cable lengths and rates",
            [by_cable("cable length (m)", survey.length, 1e-3), by_cable("length rate (m/s)", survey.rate, 1e-3)],
        ),
        "motion": (
            "Motion",
            [
                by_axis("position (m)", survey.desired[:, :3], "xyz"),
                Panel("speed (m/s)", (Curves(points(survey.time, speed), CABLES, names=("speed",)),), least=1e-3),
            ],
        ),
    }


def unheld(survey: Survey) -> list[Shade]:
    """Return the intervals without admissible tensions."""
    ends, last = np.append(survey.time, survey.time[-1]), len(survey.time)
    rows = intervals(survey.status != Status.OK)
    found = [(float(ends[first]), float(ends[min(stop, last)])) for first, stop in rows]
    return [Shade(SHADES[Status.INFEASIBLE], colours.SHADES[Status.INFEASIBLE], found)] if found else []


def survey_pictures(survey: Survey, subject: Subject) -> Pictures:
    """Return the frames of a motion."""
    pose = survey.desired
    return pictures(subject, survey.time, pose[:, :3], pose[:, 3:7], tension=survey.tension)


def pose_pictures(at: Array, subject: Subject) -> Pictures:
    """Return the single frame of a robot at a pose (7,)."""
    return pictures(subject, np.zeros(1), at[None, :3], at[None, 3:7])
