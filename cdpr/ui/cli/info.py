"""`cdpr info`."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import click

from cdpr.ui.cli.load import load_with_warnings, strict_option
from cdpr.ui.cli.names import OutPath, change_keys, force_option, plugin_files, require_new_in

if TYPE_CHECKING:
    from cdpr.scene import Pictures


@click.command("info")
@click.argument("file", metavar="ROBOT|SCENARIO", type=click.Path())
@click.option(
    "--pose", metavar="X,Y,Z[,R,P,Y]", help="Evaluated pose: position (m) and roll, pitch, yaw (rad, or as 30deg)."
)
@change_keys("Change any key of the file.")
@click.option("--out", type=OutPath(), help="Folder for a drawing (robot.svg) and the figures (info.json).")
@force_option
@plugin_files
@strict_option
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(
    file: str, pose: str | None, changes: tuple[str, ...], out: str | None, force: bool, strict: bool, as_json: bool
) -> None:
    """Analyse a robot at a pose, and the motion and the closed loop of a scenario.

    The default of --pose is the robot's home, or the scenario's initial pose. A motion is evaluated by inverse
    kinematics and dynamics, without simulation. Tensions are those of the solver qp, of minimum 2-norm. The closed loop
    (controller, solver, winches and cables) is linearised at rest at the pose: poles, damping and bandwidth.
    """
    if out is not None:
        require_new_in(out, ("info.json", "robot.svg"), force)
    loaded = load_with_warnings(file, changes, strict=strict)
    # imported only after the file is valid, because it is slow
    from cdpr.scenario import Scenario
    from cdpr.ui.cli.pose_option import pose_and_gravity
    from cdpr.ui.report.text.description import lines
    from cdpr.ui.report.view import analysed

    gravity, at, source = pose_and_gravity(loaded, pose)[1:]
    figures, scene, _ = analysed(loaded, gravity, at, source)
    if isinstance(loaded, Scenario):
        from cdpr.log.run_json import to_json
        from cdpr.simulation.poles import closed_loop

        figures["closed_loop"] = to_json(closed_loop(loaded, at))
    if as_json:
        click.echo(json.dumps(figures, indent=2, allow_nan=False))
    else:
        for line in lines(figures):
            click.echo(line)
    if out is not None:
        _write(figures, scene, out, force, quiet=as_json)


def _write(figures: dict[str, Any], scene: Pictures, out: str, force: bool, *, quiet: bool) -> None:
    """Write the drawing and the figures into a folder, which is created if necessary."""
    from pathlib import Path

    from cdpr.log.files import markup, replace_all
    from cdpr.ui.report.figures.sketch import draw

    folder = Path(out)
    drawing = draw(scene).markup(f"Robot {figures['robot']['name']}", both=False)
    replace_all(
        folder,
        {"info.json": json.dumps(figures, indent=2, allow_nan=False) + "\n", "robot.svg": markup(drawing)},
        force,
    )
    if not quiet:
        click.echo(folder / "robot.svg")
