"""Notebook display of runs, robots, scenarios and simulations: a table of facts and an embedded player.

The player is an iframe with its own document (`srcdoc`) and the script of a report. Therefore outputs of several cells
cannot interfere, and no network access is needed. If a notebook blocks iframes, the table of facts is still shown.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.log.run import Run
from cdpr.mechanics.properties import home_pose
from cdpr.model import Robot
from cdpr.scenario import Scenario
from cdpr.scene import Pictures, Subject, pictures
from cdpr.ui.report.pages import tables
from cdpr.ui.report.pages.page import figure, hall, panels, style, table
from cdpr.ui.report.player import assets
from cdpr.ui.report.player.arrays import Arrays
from cdpr.ui.report.player.data import page_data
from cdpr.ui.report.player.scenes import scene, scene_of_run
from cdpr.ui.report.plots import run as plots
from cdpr.ui.report.plots.histories import histories, points
from cdpr.ui.report.plots.panel import Curves, Panel
from cdpr.ui.report.style import AXES
from cdpr.ui.report.text.aligned import number, unit_for, vector
from cdpr.ui.report.text.sentence import sentence

if TYPE_CHECKING:
    from cdpr.simulation import Simulation

OWN = Path(__file__).with_name("notebook.css")
MOST_SAMPLES = 400  # of a motion that is not simulated
TALL, LOW = "32rem", "24rem"  # height of a frame with and without plots

PLOTS = "plots"  # id of the panels


def of_run(run: Run) -> str:
    """Return a run as HTML: its end, its key figures, and the player with tensions and errors."""
    head = run.header
    with np.errstate(all="ignore"):  # a diverged run ends in inf and NaN
        ending = tables.ending(run, sentence(run, histories(run).outline.position))
        facts = [
            ("Scenario", head.scenario),
            ("Robot", f"{head.robot}, {len(head.cables)} cables"),
            ("Run on", f"{head.backend}, controller {head.controller}, tension solver {head.solver}"),
            *_errors(run),
        ]
        if not len(run.rows):
            return ending + _table(facts)
        arrays = Arrays()
        shown = [plots.tension_panel(run, height=1.9), plots.errors(run)[0]]
        data = page_data(run, [scene_of_run(run, arrays)], {PLOTS: shown}, arrays)
    return ending + _table(facts) + _frame(f"Run of {head.scenario}", data)


def of_robot(robot: Robot) -> str:
    """Return a robot as HTML: its properties, and a scene of its home pose."""
    pose, source = home_pose(robot)
    low, high = robot.tension_min, robot.tension_max
    facts = [
        ("Robot", robot.name),
        ("Cables", f"{robot.m}: {', '.join(cable.name for cable in robot.cables)}"),
        ("Degrees of freedom", f"{robot.n}: {', '.join(robot.dof)} ({robot.pattern})"),
        ("Platform", f"{robot.platform.mass:g} kg"),
        ("Tensions", f"{number(float(low.min()))} to {number(float(high.max()))} N"),
        ("Drawn at", f"{vector(pose[:3].tolist())} m ({source})"),
    ]
    shown = pictures(Subject.of_robot(robot), np.zeros(1), pose[None, :3], pose[None, 3:7])
    return _table(facts) + _still(f"Robot {robot.name}", shown)


def of_scenario(scenario: Scenario) -> str:
    """Return a scenario as HTML: its properties, and a player of the desired motion, without simulation."""
    simulation, robot = scenario.simulation, scenario.robot
    events = [f"{event.type} at {event.time:g} s" for event in scenario.events]
    facts = [
        ("Scenario", scenario.name),
        ("Robot", f"{robot.name}, {robot.m} cables"),
        ("To run on", f"{simulation.backend}, controller {scenario.controller.type}, solver {scenario.solver.type}"),
        ("Motion", f"{scenario.trajectory.type}, {simulation.duration:g} s in steps of {simulation.control_step:g} s"),
        *([("Nominal model", scenario.nominal_differences)] if scenario.nominal_differences else []),
        *([("Events", "; ".join(events))] if events else []),
    ]
    try:
        motion = scenario.desired
    except CdprError as error:  # a run would fail too; show the motion without events
        facts.append(("Cannot be run", str(error)))
        motion = scenario.planned
    steps = np.unique(np.linspace(0, simulation.steps, min(simulation.steps, MOST_SAMPLES) + 1).round())
    time = steps * simulation.control_step
    desired = np.array([motion.sample(t) for t in time])
    shown = pictures(Subject.of_robot(robot), time, desired[:, :3], desired[:, 3:7])
    lines = Curves(points(time, desired[:, :3]), AXES, names="xyz", group="axis")
    arrays = Arrays()
    panel = Panel("desired position (m)", (lines,), least=1e-3)
    span = (float(time[0]), float(time[-1]))
    data = page_data(None, [scene(shown, arrays)], {PLOTS: [panel]}, arrays, span)
    return _table(facts) + _frame(f"Motion of {scenario.name}", data)


def of_simulation(simulation: Simulation) -> str:
    """Return a simulation as HTML: its progress, and a scene of its current state."""
    scenario, state, desired = simulation.scenario, simulation.state, simulation.desired
    period = scenario.simulation.control_step
    scale, unit = unit_for([error := float(np.linalg.norm(desired[:3] - state[:3]))], "m")
    facts = [
        ("Simulation", scenario.name),
        ("Runs on", f"{scenario.simulation.backend}, controller {scenario.controller.type}, "
                    f"solver {scenario.solver.type}"),
        ("Time", f"{simulation.time:.6g} of {simulation.steps * period:.6g} s{', done' * simulation.done}"),
        ("Position error", f"{number(scale * error)} {unit}"),
    ]  # fmt: skip
    tension = simulation.tension[None] if simulation.time > 0.0 else None  # tensions are unknown before the first step
    if tension is not None:
        facts.append(("Tensions", f"{number(float(tension.min()))} to {number(float(tension.max()))} N"))
    shown = pictures(
        Subject.of_robot(scenario.robot),
        np.array([simulation.time]),
        state[None, :3],
        state[None, 3:7],
        tension=tension,
        desired=(desired[None, :3], desired[None, 3:7]),
    )
    return _table(facts) + _still(f"Simulation of {scenario.name}", shown)


def _errors(run: Run) -> list[tuple[str, str]]:
    figures = run.summary()
    if not figures["samples"]:
        return [("Samples", "none")]
    facts = []
    for name, base, key in (("Position", "m", "position_error_m"), ("Orientation", "rad", "orientation_error_rad")):
        scale, unit = unit_for(figures[key].values(), base)
        parts = ", ".join(f"{part} {number(scale * value)}" for part, value in figures[key].items())
        facts.append((f"{name} error ({unit})", parts))
    tension = figures.get("cable_tension_N", figures["tension_N"])
    facts.append(("Tension (N)", f"{number(tension['min'])} to {number(tension['max'])}"))
    return facts


def _table(facts: Sequence[tuple[str, str]]) -> str:
    return table([(escape(name), escape(text)) for name, text in facts])


def _still(title: str, shown: Pictures) -> str:
    """Return an iframe with a single scene frame."""
    arrays = Arrays()
    time = float(shown.time[0])
    return _frame(title, page_data(None, [scene(shown, arrays)], {}, arrays, (time, time)))


def _frame(title: str, data: Mapping[str, Any]) -> str:
    """Return an iframe with the player."""
    plotted = bool(data["figures"])
    parts = [hall([figure("robot", "", "", "", live=assets.viewer(data))], "hall")]
    if plotted:
        parts.append(hall([figure(PLOTS, "", "", "", live=panels(PLOTS))], "gallery"))
    css = style() + assets.style() + OWN.read_text(encoding="utf-8")
    page = (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
        f'<meta name="color-scheme" content="light dark"><style>{css}</style></head><body class="embedded">'
        f'<main class="theatre{" plotted" * plotted}">{"".join(parts)}</main>{assets.script(data)}</body></html>'
    )
    # Only scripts are allowed: the document has an opaque origin and cannot access the notebook.
    return (
        f'<iframe title="{escape(title)}" sandbox="allow-scripts" loading="lazy" '
        f'style="width: 100%; height: {TALL if plotted else LOW}; border: 0" srcdoc="{escape(page)}"></iframe>'
    )
