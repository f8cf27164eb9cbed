"""What a robot is at a pose, and what a scenario's motion asks of it: in figures and in pictures."""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr import defaults
from cdpr.cli.look import look
from cdpr.cli.progress import tell_of_compilation
from cdpr.distribution.portrait import describe_motion, describe_pose, describe_robot
from cdpr.distribution.survey import Survey, survey
from cdpr.log.run_json import plain
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins.registry import registry
from cdpr.report.plots.survey import survey_pictures
from cdpr.scenario import Scenario
from cdpr.simulation.loads import Loads
from cdpr.simulation.schedule import Schedule, redirected
from cdpr.tension.stage import TensionStage
from cdpr.trajectory import Trajectory
from cdpr.view import Pictures, Subject, pictures

MOST_SAMPLES = 2000  # of a motion: its peaks are then met to a millionth


def portray(loaded: Scenario | Robot, pose: str | None) -> tuple[dict[str, Any], Pictures, Survey | None]:
    """Return figures as plain data, pictures, and of a scenario its motion followed without simulating it.

    Raises click.BadParameter where `pose`, the text of --pose, is none that the robot can have.
    """
    tell_of_compilation()
    robot, gravity, at, source = look(loaded, pose)
    entry = registry().get("solver", defaults.SOLVER)
    solver, options = entry.load(), entry.info.options()
    figures: dict[str, Any] = {
        "robot": describe_robot(robot),
        "pose": {"source": source, **describe_pose(robot, at, gravity, solver(robot, options).solve)},
    }
    subject = Subject.of_robot(robot)
    if not isinstance(loaded, Scenario):
        return plain(figures), pictures(subject, np.zeros(1), at[None, :3], at[None, 3:7]), None
    asked = loaded.controlled
    trajectory = redirected(loaded.trajectory.make(), loaded.events, loaded.simulation.control_step)
    motion = _follow(loaded, trajectory, gravity, solver(asked, options).solve)
    told = [f"{event.type} at {event.time:g} s" for event in sorted(loaded.events, key=lambda event: event.time)]
    if loaded.belief:
        figures["robot"]["believed"] = loaded.belief
    figures["motion"] = {
        "type": loaded.trajectory.type,
        "end_s": trajectory.end,
        **describe_motion(asked, motion),
        "events": told,
    }
    return plain(figures), survey_pictures(motion, subject), motion


def _follow(scenario: Scenario, trajectory: Trajectory, gravity: Array, solve: Any) -> Survey:
    simulation, events, period = scenario.simulation, scenario.events, scenario.simulation.control_step
    steps = np.unique(np.linspace(0, simulation.steps, min(simulation.steps, MOST_SAMPLES) + 1).round())

    def happens(stage: TensionStage, external: Array) -> Schedule:
        return Schedule(events, period, scenario.robot, stage, Loads(external, np.zeros(6)))

    time = steps * period
    desired = np.array([trajectory.sample(t) for t in time])
    return survey(scenario.controlled, time, desired, gravity, solve, happens=happens, samples=steps)
