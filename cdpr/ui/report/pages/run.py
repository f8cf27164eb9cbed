"""Report of a run: a self-contained HTML file without network access, with a player; it prints on two pages."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from html import escape
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import yaml

from cdpr.base.column import Column
from cdpr.config.yaml_nodes import PARSER
from cdpr.log import run_json
from cdpr.log.files import replace_markup
from cdpr.log.run import Run
from cdpr.mechanics.sag import STRAIGHT
from cdpr.model import DOF_NAMES
from cdpr.ui.report.pages import cameras, tables
from cdpr.ui.report.pages.page import figure, page, panels, section, theatre
from cdpr.ui.report.pages.still import still
from cdpr.ui.report.player.arrays import Arrays
from cdpr.ui.report.player.assets import viewer
from cdpr.ui.report.player.data import page_data
from cdpr.ui.report.player.scenes import scene_of_run
from cdpr.ui.report.plots import run as plots
from cdpr.ui.report.plots import sensors as sensing
from cdpr.ui.report.plots.histories import histories
from cdpr.ui.report.plots.panel import Panel
from cdpr.ui.report.text.sentence import sentence

SPACE = "Robot"  # name of the 3D figure

# Sections below the figures, in order: name, and function that returns the content as HTML.
SECTIONS: dict[str, Callable[[Run], str]] = {
    "Events": tables.events,
    "Cables": tables.cables,
    "Scenario": tables.scenario,
}


class Drawing(NamedTuple):
    """Figure of the report."""

    name: str  # in the navigation and, in lower case, the id on the page
    title: str
    panels: Callable[[Run], Sequence[Panel]] | None  # None for the 3D scene
    caption: str  # HTML: what the figure shows and how to read it
    minor: bool = False  # omitted in print

    def shown(self, run: Run) -> Sequence[Panel]:
        """Return its panels, without those of rotations if the platform cannot turn."""
        found = [] if self.panels is None else self.panels(run)
        return found if _turns(run.header.scenario_yaml) else plots.without_rotations(found)


@lru_cache(maxsize=4)
def _turns(scenario: str) -> bool:
    """Return True if the robot of a resolved scenario has a rotational degree of freedom, or if that is unknown."""
    try:
        content = yaml.load(scenario, PARSER)
    except yaml.YAMLError:  # of another program
        return True
    robot = content.get("robot") if isinstance(content, dict) else None
    dof = (robot.get("dof") if isinstance(robot, dict) else None) or DOF_NAMES
    return any(name.startswith("r") for name in dof)


def write_report(
    run: Run,
    path: str | Path,
    least: Mapping[str, Mapping[str, Any]] = MappingProxyType({}),
    touch: str | None = None,
) -> None:
    """Write the report of a run to a file.

    Equal runs give equal bytes, except for the row of wall-clock times.

    Args:
        run: finished run.
        path: output file; its folder must exist.
        least: result of `cdpr.analysis.workspace.path.flown`, added to the summary.
        touch: description of cables in contact, from `cdpr.log.interference.cables_in_contact`; likewise.

    Raises:
        OutputError: if the file cannot be written.
    """
    replace_markup(Path(path), render(run, least, touch))


def render(run: Run, least: Mapping[str, Mapping[str, Any]] = MappingProxyType({}), touch: str | None = None) -> str:
    """Return the report as HTML."""
    head = run.header
    with np.errstate(all="ignore"):  # a diverged run ends in inf and NaN
        chosen = drawings(run) if len(run.rows) else []
        data = player_data(run, chosen) if len(run.rows) else None
        figures = {drawing.name: _figure(run, drawing, data) for drawing in chosen}
        if data is not None and run.header.imaging:
            shown = cameras.shown_images(run)
            data["images"] = cameras.player_data(shown)
            figures = {SPACE: figures.pop(SPACE), cameras.NAME: cameras.images_figure(shown), **figures}
        parts = {name: section(name.lower(), content(run)) for name, content in SECTIONS.items()}
        top = (
            f'<div class="wide pair">\n<section id="summary">\n{tables.summary(run, least, touch)}\n</section>\n'
            f'<section id="run">\n{tables.provenance(run)}\n</section>\n</div>'
        )
        banner = tables.ending(run, sentence(run, histories(run).outline.position))
    subtitle = (
        f"Robot {head.robot} with {len(head.cables)} cables; backend {head.backend}, "
        f"controller {head.controller}, tension solver {head.solver}{_date(run)}"
    )
    links = {name.lower(): name for name in (*figures, "Summary", "Run", *parts)}
    gallery = [text for name, text in figures.items() if name != SPACE]
    body = [*([theatre(figures[SPACE], gallery)] if figures else []), top, *parts.values()]
    return page(f"{head.scenario}: report of a run", subtitle, banner, links, body, data)


def player_data(run: Run, chosen: Sequence[Drawing]) -> dict[str, Any]:
    """Return the player data of a run."""
    arrays = Arrays()
    figures = {drawing.name.lower(): drawing.shown(run) for drawing in chosen if drawing.panels is not None}
    return page_data(run, [scene_of_run(run, arrays)], figures, arrays)


def _figure(run: Run, drawing: Drawing, data: dict[str, Any] | None) -> str:
    key = drawing.name.lower()
    live = viewer(data) if drawing.panels is None and data is not None else panels(key)
    caption = drawing.caption.format(length=f"{run.header.characteristic_length:.4g}")
    if drawing.panels is None and run.header.layout.has("sagging") and not run.header.spans:
        caption += f" {STRAIGHT}"  # a log of an earlier version
    return figure(
        key,
        drawing.title,
        still(run, drawing.shown(run) if drawing.panels else None, drawing.title),
        caption,
        live=live,
        minor=drawing.minor,
    )


def _date(run: Run) -> str:
    """Return the start date of a run that is stored in a folder."""
    known = None if run.folder is None else run_json.read(Path(run.folder))
    started = str((known or {}).get("started", ""))
    return f"; {started[:10]}" if started else ""


def _texts(columns: Sequence[Column]) -> str:
    """Return names and texts of columns, for a format string of HTML."""
    text = "; ".join(f"{column.name}: {column.text}" for column in columns)
    return escape(text).replace("{", "{{").replace("}", "}}")


def drawings(run: Run) -> list[Drawing]:
    """Return the figures of the report, in order."""
    columns = run.header.columns
    shown = sensing.names_of(run)
    own = [each for each in columns if each.owner]
    others = [each for each in columns if not each.owner and each.name not in shown]
    plugins = Drawing(
        "Plugins", "Recorded by plugins", plots.plugins, f"Quantities of plugins. {_texts(own)}.", minor=True
    )
    further = Drawing("Further", "Further quantities", plots.further, f"{_texts(others)}.", minor=True)
    sensors = Drawing(
        "Sensors",
        "Sensors: measured, true, and error",
        sensing.sensors,
        "The measurement that is held at each sample, the true value at the time of this measurement, and their "
        "difference. The dashed lines are three standard deviations of the white noise: 99.7 % of the errors of a "
        "sensor with noise alone are within them. Bias, drift, gain, resolution and faults move errors outside. Of a "
        "sensor with more than 16 values, the plots show the mean, and the root of the mean square of the errors.",
        minor=True,
    )
    estimate = Drawing(
        "Estimate",
        "Estimated state",
        sensing.estimate,
        "State that the estimator provides, and the true one; errors are true minus estimated. The dashed lines around "
        "an error are three standard deviations that the estimator itself states: errors beyond them show that it "
        "trusts its model too much. NIS and NEES are the squares of innovation and error, normalised by the "
        "covariance; if the model is right, 95 % of them are between the dashed lines.",
        minor=True,
    )
    motors = Drawing(
        "Motors",
        "Motor currents and electrical power",
        plots.motors,
        "Current of each motor, and its electrical power: its mechanical power and the loss in its winding. The power "
        "is negative where the motor feeds back energy, which the supply must take up.",
        minor=True,
    )
    return [
        Drawing(
            SPACE,
            "Robot and path",
            None,
            "Frame anchors, cables and platform at the start (grey) and at the end (colour), and the path "
            "of the platform's origin; parallel projection, to scale. Look for cables that cross one "
            "another, the platform or the frame.",
        ),
        Drawing(
            "Tensions",
            "Cable tensions",
            plots.tensions,
            "The tension of each cable, held over a control period. On a dashed line a limit is active: at "
            "t_min the cable is about to go slack, at t_max its winch has no reserve. On a real robot, "
            "jumps from one sample to the next excite vibration. With cables on winches, the tensions are those in "
            "the cables, and what the commands are above them goes into friction and inertia of the drums.",
        ),
        Drawing(
            "Errors",
            "Tracking errors",
            plots.errors,
            "Desired minus actual, world axes. The orientation error is the rotation vector that turns the "
            "actual into the desired attitude. An error that remains at rest indicates an unknown load or "
            "mass; one that follows the acceleration indicates a wrong inertia.",
        ),
        Drawing(
            "Pose",
            "Position and attitude",
            plots.pose,
            "The platform's origin in world axes, and its attitude as roll, pitch, yaw about the fixed axes "
            "x, y, z: R = R<sub>z</sub>(yaw) R<sub>y</sub>(pitch) R<sub>x</sub>(roll). Near a pitch of ±90° "
            "roll and yaw are not unique; the orientation error is free of that.",
            minor=True,
        ),
        Drawing(
            "Velocity",
            "Velocity and angular velocity",
            plots.velocity,
            "Velocity of the platform's origin and angular velocity, world axes. Ripple that the desired "
            "motion does not have points to gains too high for the control step, or to tensions that jump.",
            minor=True,
        ),
        Drawing(
            "Acceleration",
            "Acceleration and angular acceleration",
            plots.acceleration,
            "World axes. The actual one is the mean over the control period after each sample, from the "
            "change of velocity; the last sample has none. A gap between the two is a wrench that the "
            "controller did not foresee, or that the cables did not deliver.",
            minor=True,
        ),
        Drawing(
            "Lengths",
            "Cable lengths and rates",
            plots.cables,
            "The distance between the two anchors of each cable, and its rate, positive where the cable "
            "pays out. The largest rate is the speed that the winch must reach.",
            minor=True,
        ),
        Drawing(
            "Distribution",
            "Tension distribution",
            plots.distribution,
            "Margin: the smallest distance of a tension from its limits, negative outside. Residual: the "
            "norm of W t − w, with wrench matrix W, tensions t and the required wrench w; "
            "moments are divided by the characteristic length, {length} m. Its axis is logarithmic, "
            "with zero drawn at 10<sup>−16</sup>. Near round-off the cables exert the required wrench; a larger "
            "residual means another wrench.",
            minor=True,
        ),
        *([motors] if run.header.layout.has("electrical") else []),
        Drawing(
            "Energy",
            "Energy and power",
            plots.energy,
            "Kinetic energy of the platform, change of its potential energy, works of the cables, of external "
            "wrenches and of other sources since the start, and their powers: what the drives must deliver, or take "
            "up where it is negative. External wrenches, where there are any, are those that the scenario lets act. "
            "Unexplained is the energy gained that no work accounts for: round-off under exact integration, "
            "proportional to the physics step in engines of first order. Where it grows without bound, the backend "
            "makes or loses energy. (The work of some sources, such as rigid legs, is unknown; the summary then does "
            "not judge the balance.)",
            minor=True,
        ),
        *([sensors] if run.header.sensors else []),
        *([estimate] if run.header.layout.has("estimated") else []),
        *([further] if others else []),
        *([plugins] if own else []),
    ]
