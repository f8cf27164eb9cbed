"""`cdpr equilibrium`."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Any

import click

from cdpr.base.defaults import MOST_STARTS, SOLVER
from cdpr.base.errors import ExitCode
from cdpr.ui.cli.names import OutPath, change_keys, force_option, plugin_files, plugin_option, require_new_in
from cdpr.ui.cli.numbers import Real, Whole, number

if TYPE_CHECKING:
    from cdpr.model import Robot
    from cdpr.model.robot import Array
    from cdpr.scenario import Scenario

NONE = "-"  # in lists of values: a cable with a value in another list
FIGURES, TABLE = "equilibrium.json", "lengths.csv"


@click.command("equilibrium")
@click.argument("file", metavar="ROBOT|SCENARIO", type=click.Path())
@click.option(
    "--lengths", metavar="L1,L2,...", help="Unwound length of each cable (m); `-` for a cable of another list."
)
@click.option("--tensions", metavar="T1,T2,...", help="Constant tension of each cable (N).")
@click.option(
    "--drum-angles",
    metavar="A1,A2,...",
    help="Drum angle of each cable (rad), positive when winding in, 0 for the length of its path at home.",
)
@click.option(
    "--pose",
    metavar="X,Y,Z[,R,P,Y]",
    help="Start of the search, or the pose of --compensate: position (m) and roll, pitch, yaw (rad, or as 30deg).",
)
@click.option("--all", "every", is_flag=True, help="Search from many random poses, for unstable equilibria, too.")
@click.option(
    "--starts", type=Whole(0, MOST_STARTS), help=f"Number of random poses of --all, at most {MOST_STARTS}. [100]"
)
@click.option(
    "--compensate",
    is_flag=True,
    help="Compute the lengths with which the platform rests at --pose, or along the motion of a scenario.",
)
@click.option(
    "--step", type=Real(0.0, min_open=True), metavar="S", help="Time between samples of the motion (s). [control step]"
)
@plugin_option("--solver", "solver", metavar="NAME", help=f"Tension solver of --compensate. [{SOLVER}]")
@change_keys("Change any key of the file.")
@click.option("--out", type=OutPath(), help=f"Folder for the figures ({FIGURES}) or the table ({TABLE}).")
@force_option
@plugin_files
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(
    file: str,
    lengths: str | None,
    tensions: str | None,
    drum_angles: str | None,
    pose: str | None,
    every: bool,
    starts: int | None,
    compensate: bool,
    step: float | None,
    solver: str | None,
    changes: tuple[str, ...],
    out: str | None,
    force: bool,
    as_json: bool,
) -> None:
    """Compute the pose at which the platform comes to rest, or the lengths for a pose (flex compensation).

    Each cable has an unwound length, a drum angle or a constant tension. Cables may be elastic or not, and become
    slack. The start of the search is the robot's home, or the scenario's initial pose. The exit code is 4 if no
    equilibrium is found.
    """
    held = {"--lengths": lengths, "--tensions": tensions, "--drum-angles": drum_angles}
    _check_options(held, every, starts, compensate, step, solver, pose)
    from cdpr.ui.cli.load import load_with_warnings

    if out is not None:
        require_new_in(out, (FIGURES, TABLE), force)
    loaded = load_with_warnings(file, changes)
    # imported only after the file is valid, because it is slow
    from cdpr.scenario import Scenario
    from cdpr.ui.cli.pose_option import pose_and_gravity

    if compensate and pose is None and isinstance(loaded, Scenario):
        _along(loaded, step, solver or SOLVER, out, force, as_json)
        return
    if step is not None:
        raise click.UsageError("--step requires a scenario without --pose")
    robot, _, at, source = pose_and_gravity(loaded, pose)
    if compensate:
        _at_pose(loaded, robot, at, solver or SOLVER, (out, force, as_json))
        return
    from cdpr.analysis.equilibrium import equilibria, equilibrium
    from cdpr.analysis.equilibrium.at_rest import STARTS
    from cdpr.analysis.equilibrium.figures import describe_equilibria
    from cdpr.ui.report.text.equilibrium import lines

    values: dict[str, Any] = {
        name[2:].replace("-", "_"): _values(name, text, robot) for name, text in held.items() if text is not None
    }
    if every:
        found = equilibria(loaded, **values, start=at, starts=STARTS if starts is None else starts)
    else:
        found = [equilibrium(loaded, **values, start=at)]
    figures = describe_equilibria(robot, source, found)
    _show(figures, lines, out, force, as_json)
    _end(bool(found) and all(one.converged for one in found))


def _end(good: bool) -> None:
    if not good:
        raise click.exceptions.Exit(ExitCode.INFEASIBLE)


def _check_options(
    held: dict[str, str | None],
    every: bool,
    starts: int | None,
    compensate: bool,
    step: float | None,
    solver: str | None,
    pose: str | None,
) -> None:
    given = [name for name, text in held.items() if text is not None]
    if compensate and (given or every):
        raise click.UsageError(f"--compensate computes lengths: omit {', '.join(given) or '--all'}")
    if not compensate and not given:
        raise click.UsageError(f"expected {', '.join(held)} or --compensate")
    if starts is not None and not every:
        raise click.UsageError("--starts requires --all")
    for name, value in {"--step": step, "--solver": solver}.items():
        if value is not None and not compensate:
            raise click.UsageError(f"{name} requires --compensate")
    if step is not None and pose is not None:
        raise click.UsageError("--step: applies to the motion of a scenario, so omit --pose")


def _finite(text: str, name: str) -> float:
    value = number(text)
    if not math.isfinite(value):
        message = f"expected finite numbers, or `{NONE}` for a cable of another list, got {text[:80]!r}"
        raise click.BadParameter(message, param_hint=name)
    return value


def _values(name: str, text: str, robot: Robot) -> list[float]:
    """Return the values of a list, NaN for `-`."""
    parts = [part.strip() for part in text.split(",")]
    try:
        values = [float("nan") if part == NONE else _finite(part, name) for part in parts]
    except ValueError:
        raise click.BadParameter(f"expected numbers with commas, got {text[:80]!r}", param_hint=name) from None
    if len(values) != robot.m:
        raise click.BadParameter(f"expected {robot.m} values, one for each cable, got {len(values)}", param_hint=name)
    return values


def _at_pose(
    loaded: Scenario | Robot, robot: Robot, pose: Array, solver: str, output: tuple[str | None, bool, bool]
) -> None:
    from cdpr.analysis.equilibrium import compensated_lengths, equilibrium
    from cdpr.analysis.equilibrium.figures import describe_compensation
    from cdpr.mechanics.kinematics import lengths, make_state
    from cdpr.mechanics.properties import check_lengths
    from cdpr.ui.report.text.equilibrium import compensation_lines

    check_lengths(robot, pose)
    found = compensated_lengths(loaded, pose, solver=solver)
    held = equilibrium(loaded, lengths=lengths(robot, make_state(pose[:3], pose[3:])), start=pose)
    _show(describe_compensation(robot, pose, found, held), compensation_lines, *output)
    _end(bool(found.feasible))


def _along(scenario: Scenario, step: float | None, solver: str, out: str | None, force: bool, as_json: bool) -> None:
    from pathlib import Path

    import numpy as np

    from cdpr.analysis.equilibrium.path import compensated_path
    from cdpr.log.files import replace_all

    path = compensated_path(scenario, step, solver)
    names = [cable.name for cable in scenario.robot.cables]
    infeasible = int(np.count_nonzero(~path.found.feasible.astype(bool)))
    if as_json:
        rows = {"lengths_m": path.found.lengths, "tension_N": path.found.tension}
        data: dict[str, Any] = {"robot": scenario.robot.name, "cables": names, "t": path.time.tolist()}
        click.echo(json.dumps(data | {key: value.tolist() for key, value in rows.items()} | {"infeasible": infeasible}))
    elif out is None:
        click.echo(path.csv(names).decode(), nl=False)
    if out is not None:
        replace_all(Path(out), {TABLE: path.csv(names)}, force)
        if not as_json:
            click.echo(Path(out) / TABLE)
    if infeasible:
        click.echo(
            f"{infeasible} of {len(path.time)} samples: no tensions within the limits balance the weight", err=True
        )
    _end(not infeasible)


def _show(figures: dict[str, Any], lines: Any, out: str | None, force: bool, as_json: bool) -> None:
    from pathlib import Path

    from cdpr.log.files import replace_all
    from cdpr.log.run_json import to_json

    plain = to_json(figures)
    if as_json:
        click.echo(json.dumps(plain, indent=2, allow_nan=False))
    else:
        for line in lines(plain):
            click.echo(line)
    if out is not None:
        replace_all(Path(out), {FIGURES: json.dumps(plain, indent=2, allow_nan=False) + "\n"}, force)
        if not as_json:
            click.echo(Path(out) / FIGURES)
