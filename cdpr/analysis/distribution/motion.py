"""Figures of a robot at a pose and of a scenario's motion, computed without a simulation."""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr.analysis.distribution.describe import describe_motion, describe_pose, describe_robot
from cdpr.analysis.distribution.sagging import STRAIGHT, resting_lengths
from cdpr.analysis.distribution.survey import Survey, survey
from cdpr.base import defaults
from cdpr.cables import commands_of
from cdpr.log.run_json import to_json
from cdpr.mechanics.assumed_diameters import assumption, least_clearance
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins.controller import OUTPUTS, stage_of_output
from cdpr.plugins.registry import registry
from cdpr.scenario import Scenario
from cdpr.simulation.attached import SurveyBodies
from cdpr.simulation.columns import chosen_plugins
from cdpr.simulation.loads import Loads
from cdpr.simulation.schedule import Schedule
from cdpr.tension.stage import Solve, TensionStage

MOST_SAMPLES = 2000  # samples of a motion: they find its peaks to a millionth
WITHIN = 100  # samples of an event with a duration


def describe_loaded(
    loaded: Scenario | Robot, gravity: Array, at: Array, source: str
) -> tuple[dict[str, Any], Survey | None]:
    """Return figures as plain data; for a scenario also those of its motion.

    `gravity` is (3,), m/s^2, world; the robot is evaluated in the pose `at` (7,), which comes from `source`.
    """
    robot = loaded.robot if isinstance(loaded, Scenario) else loaded
    entry = registry().get("solver", defaults.SOLVER)
    solver, options = entry.load(), entry.info.options()
    figures: dict[str, Any] = {
        "robot": describe_robot(robot),
        "pose": {"source": source, **describe_pose(robot, at, gravity, solver(robot, options).solve)},
    }
    if robot.unilateral:
        obstacles = loaded.obstacles if isinstance(loaded, Scenario) else ()
        unwound = resting_lengths(robot, at[None], gravity)
        least = least_clearance(robot, at, obstacles, unwound=unwound, gravity=gravity)
        gap, names = least or (None, None)
        remark = assumption(robot) + STRAIGHT * bool(unwound is not None and np.isnan(unwound).any())
        figures["pose"] |= {"clearance_m": gap, "clearance_by": names and f"{names}{remark}"}
    if not isinstance(loaded, Scenario):
        return to_json(figures), None
    controlled = loaded.controlled_robot
    motion = follow(loaded, solver(controlled, options).solve)
    events = [f"{event.type} at {event.time:g} s" for event in sorted(loaded.events, key=lambda event: event.time)]
    if loaded.nominal_differences:
        figures["robot"]["believed"] = loaded.nominal_differences
    figures["motion"] = {
        "type": loaded.trajectory.type,
        "end_s": loaded.desired.end,
        **describe_motion(controlled, motion),
        "events": events,
    }
    if note := assumed_tensions(loaded):
        figures["motion"]["tensions"] = note
    return to_json(figures), motion


def assumed_tensions(scenario: Scenario) -> str:
    """Return a note if a run has other tensions, because its controller commands winches without a solver; else ""."""
    entry = chosen_plugins(scenario)["controller"]
    output = entry.info.properties.get("output", "wrench")
    if output not in OUTPUTS or stage_of_output(output, commands_of(scenario.robot)) != "winch":
        return ""
    return (
        f"those of the solver {defaults.SOLVER}; controller '{entry.info.name}' commands the winches without a solver, "
        "so a run has other tensions"
    )


def _evaluated_samples(scenario: Scenario) -> Array:
    """Return the numbers of the evaluated samples: of the whole run, of its motion, and of its events."""
    steps, period = scenario.simulation.steps, scenario.simulation.control_step
    begin, end = (int(min(at / period, steps)) for at in (scenario.desired.start, scenario.desired.end))
    parts = [np.linspace(a, b, min(b - a, MOST_SAMPLES) + 1) for a, b in ((0, steps), (begin, min(end + 1, steps)))]
    for event in scenario.events:
        until = event.time + (getattr(event, "duration", None) or 0.0)
        parts += [np.array([at / period + k for at in (event.time, until) for k in (-1.0, 0.0, 1.0, 2.0)])]
        parts += [np.linspace(event.time, until, WITHIN) / period]
    return np.unique(np.clip(np.concatenate(parts).round(), 0, steps))


def follow(scenario: Scenario, solve: Solve) -> Survey:
    """Return the requirements of a scenario's desired motion on its cables; `solve` is as for `survey`."""
    events, period = scenario.events, scenario.simulation.control_step
    steps = _evaluated_samples(scenario)

    robot = scenario.controlled_robot

    def changes_of(stage: TensionStage, external: Array, inertial: Array) -> Schedule:
        loads, attached = Loads(external, np.zeros(6)), SurveyBodies(robot, inertial)
        return Schedule(events, period, scenario.robot, stage, loads, attached=attached)

    time = steps * period
    desired = np.array([scenario.desired.sample(t) for t in time])
    gravity = np.array(scenario.world.gravity)
    return survey(robot, time, desired, gravity, solve, changes_of=changes_of, samples=steps)
