"""`cdpr fmu export`."""

from __future__ import annotations

import json
from pathlib import Path

import click

from cdpr.ui.cli.names import OutPath, change_keys, force_option, plugin_files
from cdpr.ui.cli.numbers import AnyReal

DEFAULT_STEP = 0.001  # s, for robots without a scenario


@click.command("export")
@click.argument("file", metavar="ROBOT|SCENARIO", type=click.Path())
@click.option("--out", "-o", required=True, type=OutPath(path_type=Path), help="The FMU to write.")
@click.option("--fmi", type=click.Choice(["2", "3"]), default="3", show_default=True, help="Version of the standard.")
@click.option(
    "--with-winch",
    is_flag=True,
    help="With winches and cables: inputs are commands, not tensions. Default for winches that take lengths or rates.",
)
@click.option("--only-winch", is_flag=True, help="Winches and cables alone: commands and lengths in, tensions out.")
@click.option(
    "--controller", is_flag=True, help="Controller and solver alone: state and desired motion in, tensions out."
)
@click.option("--with-controller", is_flag=True, help="Controller and solver inside, with the plant.")
@click.option("--source-only", is_flag=True, help="Without a binary: compile it on the target. Only for FMI 3.")
@click.option(
    "--platform",
    "platforms",
    multiple=True,
    type=click.Choice(["native", "win64", "linux-x86_64", "linux-aarch64", "macos-x86_64", "macos-aarch64"]),
    help="Platform of a binary, repeatable; native is this platform. [native]",
)
@click.option(
    "--step",
    type=AnyReal(),
    help="Step of the integrator, s; default: the scenario's physics_step, or 0.001.",
)
@change_keys("Change any key of the file.")
@force_option
@plugin_files
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(
    file: str,
    out: Path,
    fmi: str,
    with_winch: bool,
    only_winch: bool,
    controller: bool,
    with_controller: bool,
    source_only: bool,
    platforms: tuple[str, ...],
    step: float | None,
    changes: tuple[str, ...],
    force: bool,
    as_json: bool,
) -> None:
    """Write a robot as an FMU for co-simulation: its platform on its cables, as simulated by the backend `reference`.

    Initial state, gravity, step and events that change the mass are those of the scenario; for a robot, its home pose
    at rest, Earth's gravity and 1 ms. All are parameters of the FMU. FMUs of FMI 3 contain the C++ source. The binary
    for this platform is compiled from it by $CXX, c++ or zig; those for others by zig (pip install 'cdpr[cross]'), for
    Windows also by x86_64-w64-mingw32-g++. The FMU is added to the list of trusted ones (cdpr fmu trust).
    """
    from cdpr.scenario import Scenario, World
    from cdpr.ui.cli.load import load_with_warnings

    loaded = load_with_warnings(file, changes)
    import numpy as np

    from cdpr.base.errors import CdprError
    from cdpr.base.needs import of_brake, of_sensor
    from cdpr.cables import ACTUATED, chain_of, immediate, rubs, takes_lengths, with_model
    from cdpr.cables.brake import brake_of
    from cdpr.fmu.export import NATIVE, Actuator, Controller, Load, Model, Plant, write_fmu
    from cdpr.log.files import NAME_OR_FORCE
    from cdpr.mechanics.kinematics import make_state
    from cdpr.mechanics.properties import home_pose
    from cdpr.simulation.exported_start import exported_start
    from cdpr.simulation.needs import omitted, require, require_parts

    if with_winch and only_winch:
        raise click.UsageError("--with-winch and --only-winch exclude each other")
    if controller and (with_controller or with_winch or only_winch):
        raise click.UsageError("--controller exports only a controller: remove the other --with and --only options")
    if with_controller and only_winch:
        raise click.UsageError("--with-controller requires a plant, which --only-winch omits")
    if (controller or with_controller) and not isinstance(loaded, Scenario):
        raise click.UsageError("a controller is that of a scenario, and this file is a robot")
    if source_only and platforms:
        raise click.UsageError("--source-only and --platform cannot be combined: --source-only writes no binary")
    if step is not None and not 0.0 < step < np.inf:
        raise click.BadParameter(f"expected a finite number greater than 0 (s), got {step:g}", param_hint="--step")
    if isinstance(loaded, Scenario):
        use = "bare_controller_fmu" if controller else "controller_fmu" if with_controller else "plant_fmu"
        require(loaded, use)
        for line in omitted(loaded, use):
            click.echo(f"{file}: left out: {line}", err=True)
        robot, gravity, (state, unwound, _) = loaded.robot, loaded.gravity, exported_start(loaded)
        step = step or loaded.simulation.physics_step
        if only_winch and loaded.actuators is not None:
            robot = with_model(robot, ACTUATED)  # as the scenario itself exports them
    else:
        require_parts(loaded, "plant_fmu")
        if any(brake_of(cable) is not None for cable in loaded.cables):
            click.echo(f"{file}: left out: robot.winch.brake_torque: {of_brake().plant_fmu.why}", err=True)
        pose, _ = home_pose(loaded)
        robot, gravity, state, unwound = loaded, np.array(World().gravity), make_state(pose[:3], pose[3:]), None
    step = step or DEFAULT_STEP
    with_winch = with_winch or (takes_lengths(robot) and not (controller or only_winch))
    if not (controller or with_winch or only_winch or immediate(robot)):
        winches = not all(chain_of(robot, cable).immediate for cable in robot.cables)
        friction = "the friction of its pulleys" if rubs(robot) else ""
        lacking = " and ".join(filter(None, ("its winches" if winches else "", friction)))
        verb = "are" if winches else "is"
        text = f"{lacking} {verb} not exported without --with-winch: tensions at the platform act at once"
        click.echo(f"{file}: {text}", err=True)
    control = None
    if isinstance(loaded, Scenario) and (controller or with_controller):
        from cdpr.simulation.exported import control_of

        control = control_of(loaded, use)
        if control.unused:
            names = ", ".join(control.unused)
            click.echo(f"{file}: left out: sensors: {of_sensor().controller_fmu.why} ({names})", err=True)
    if not controller and (with_winch or only_winch):
        from cdpr.simulation.step_checks import Circumstances, check_step, empty_drum

        if text := empty_drum(robot, state):
            raise CdprError(text)
        about = Circumstances(robot, state, gravity, "the FMU", "--step")
        check_step(about.with_fixed_platform() if only_winch else about, step, fourth_order=True)
    model: Model
    if control and controller:
        model = Controller(control)
    elif only_winch:
        model = Actuator(robot, step)
    else:
        loads: tuple[Load, ...] = ()
        if isinstance(loaded, Scenario) and loaded.events:
            from cdpr.simulation.exported import loads_of

            loads = loads_of(loaded)
        model = Plant(robot, gravity, step, state, with_winch, control, loads, unwound)
    sha256 = write_fmu(model, int(fmi), out, source_only, force, platforms or (NATIVE,), NAME_OR_FORCE)
    if as_json:
        facts = {"file": str(out), "fmi": int(fmi), "sha256": sha256, "model": model.name}
        click.echo(json.dumps({**facts, "robot": robot.name, "step": step, "binary": not source_only}))
    else:
        size = out.stat().st_size / 1000
        click.echo(f"{out}: FMI {fmi}, {model.name}, {robot.m} cables, {size:.0f} kB, sha256 {sha256}")
