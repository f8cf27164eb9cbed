"""`cdpr info`."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import click

from cdpr.cli.load import load_told, strict_option
from cdpr.cli.names import OutPath, change_keys, plugin_files

if TYPE_CHECKING:
    from cdpr.model.robot import Array
    from cdpr.report.figures.scene import Scene
    from cdpr.tension.stage import TensionStage

MOST_SAMPLES = 2000  # of a motion: its peaks are then met to a millionth


@click.command("info")
@click.argument("file", metavar="ROBOT|SCENARIO", type=click.Path())
@click.option(
    "--pose", metavar="X,Y,Z[,R,P,Y]", help="Look here: position (m) and roll, pitch, yaw (rad, or as 30deg)."
)
@change_keys("Change any key of the file.")
@click.option("--out", type=OutPath(), help="Folder for a drawing (robot.svg) and the figures (info.json).")
@plugin_files
@strict_option
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(
    file: str, pose: str | None, changes: tuple[str, ...], out: str | None, strict: bool, as_json: bool
) -> None:
    """Tell what a robot is and can hold at a pose, and what a scenario's motion asks of it.

    The pose is the robot's home, or the scenario's initial one, unless --pose is given. Nothing is simulated: a motion
    is followed by inverse kinematics and dynamics. Tensions are those of the solver qp, of minimum 2-norm.
    """
    from cdpr.scenario import Scenario

    loaded = load_told(file, changes, strict=strict)
    # Only a sound file is worth the time that these take to import.
    import numpy as np

    from cdpr import defaults
    from cdpr.cli.look import look
    from cdpr.cli.progress import tell_of_compilation
    from cdpr.distribution.portrait import describe_motion, describe_pose, describe_robot
    from cdpr.distribution.survey import survey
    from cdpr.log.run_json import plain
    from cdpr.plugins.registry import registry
    from cdpr.report.figures.scene import Scene
    from cdpr.report.text.portrait import lines

    tell_of_compilation()
    scenario = loaded if isinstance(loaded, Scenario) else None
    robot, gravity, at, source = look(loaded, pose)
    entry = registry().get("solver", defaults.SOLVER)
    solver, options = entry.load(), entry.info.options()
    figures: dict[str, Any] = {
        "robot": describe_robot(robot),
        "pose": {"source": source, **describe_pose(robot, at, gravity, solver(robot, options).solve)},
    }
    scene = Scene.of_robot(robot, np.zeros(1), at[None])
    if scenario is not None:
        from cdpr.simulation.loads import Loads
        from cdpr.simulation.schedule import Schedule, redirected

        simulation = scenario.simulation
        steps = np.unique(np.linspace(0, simulation.steps, min(simulation.steps, MOST_SAMPLES) + 1).round())
        events, period = scenario.events, simulation.control_step

        def happens(stage: TensionStage, external: Array) -> Schedule:
            return Schedule(events, period, robot, stage, Loads(external, np.zeros(6)))

        trajectory = redirected(scenario.trajectory.make(), events, period)
        time = steps * period
        asked, desired = scenario.controlled, np.array([trajectory.sample(t) for t in time])
        solve = solver(asked, options).solve
        motion = survey(asked, time, desired, gravity, solve, happens=happens, samples=steps)
        told = [f"{event.type} at {event.time:g} s" for event in sorted(events, key=lambda event: event.time)]
        if scenario.belief:
            figures["robot"]["believed"] = scenario.belief
        figures["motion"] = {"type": scenario.trajectory.type, **describe_motion(asked, motion), "events": told}
        scene = Scene.of_robot(robot, time, motion.desired[:, :7])
    figures = plain(figures)
    if as_json:
        click.echo(json.dumps(figures, indent=2, allow_nan=False))
    else:
        for line in lines(figures):
            click.echo(line)
    if out is not None:
        _write(figures, scene, out, quiet=as_json)


def _write(figures: dict[str, Any], scene: Scene, out: str, *, quiet: bool) -> None:
    """Write drawing and figures into the folder, made if need be."""
    from pathlib import Path

    from cdpr.log.files import make_folder, replace

    folder = Path(out)
    make_folder(folder)
    replace(folder / "info.json", json.dumps(figures, indent=2, allow_nan=False) + "\n")
    from cdpr.report.figures.sketch import write_svg  # needs matplotlib; the figures are written without it, too

    write_svg(scene, folder / "robot.svg", f"Robot {figures['robot']['name']}")
    if not quiet:
        click.echo(folder / "robot.svg")
