"""Page of a robot at a pose, or of a motion evaluated without simulation."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import Any

import numpy as np

from cdpr.analysis.distribution.survey import Survey
from cdpr.mechanics.sag import STRAIGHT
from cdpr.scene import Pictures
from cdpr.ui.report.pages.page import banner, figure, page, panels, section, theatre
from cdpr.ui.report.pages.still import still_panels, still_scene
from cdpr.ui.report.player.arrays import Arrays
from cdpr.ui.report.player.assets import viewer
from cdpr.ui.report.player.data import page_data
from cdpr.ui.report.player.scenes import scene
from cdpr.ui.report.plots.survey import survey_panels, unheld
from cdpr.ui.report.text.description import lines

ROBOT = "Frame anchors, cables and platform at the pose, without simulation."
MOTION = "The desired motion by inverse kinematics and dynamics; tensions of minimum 2-norm. There is no simulation."


def render_view(title: str, figures: Mapping[str, Any], shown: Pictures, survey: Survey | None) -> str:
    """Return the page as HTML.

    Args:
        title: title of the page.
        figures: result of `cdpr info`.
        shown: one frame, or the frames of the survey.
        survey: survey of the motion, if there is one.
    """
    arrays = Arrays()
    found = {} if survey is None else survey_panels(survey, shown.subject.cables)
    scenes = [scene(shown, arrays)]
    span = (float(shown.time[0]), float(shown.time[-1]))
    drawn = {key: drawn for key, (_, drawn) in found.items()}
    shades = [] if survey is None else unheld(survey)
    data = page_data(None, scenes, drawn, arrays, span, shades)
    about = ROBOT if survey is None else MOTION
    if shown.subject.spans:
        about += f" {STRAIGHT}"
    gallery = [
        figure(key, name, still_panels(which, span, shades, name), about, live=panels(key))
        for key, (name, which) in found.items()
    ]
    parts = [theatre(figure("robot", "Robot", still_scene(shown, title), about, live=viewer(data)), gallery)]
    text = escape("\n".join(lines(dict(figures))))
    parts.append(section("figures", f"<h2>Capacity</h2>\n<pre>{text}</pre>"))
    links = {"robot": "Robot", **{key: name for key, (name, _) in found.items()}, "figures": "Figures"}
    return page(title, about, "" if survey is None else _banner(survey), links, parts, data)


def _banner(survey: Survey) -> str:
    """Return a warning banner if the robot cannot follow the motion."""
    if survey.feasible.all():
        return ""
    share, first = 100 * (1 - survey.feasible.mean()), survey.time[np.argmin(survey.feasible)]
    rest = (
        f": no admissible tensions at {share:.4g} % of the samples, first at {first:.4g} s; "
        "the tensions shown there are the nearest ones"
    )
    return banner("warn", "Not feasible", rest)
