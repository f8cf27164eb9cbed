"""`cdpr run`."""

from __future__ import annotations

import json
import os
import sys
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, closing, contextmanager, nullcontext
from functools import partial
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from cdpr.base.defaults import ESTIMATOR
from cdpr.base.errors import CdprError, Interrupted, OutputError, ScenarioError
from cdpr.base.redirect_output import redirect_output
from cdpr.simulation.clock import SPEEDS
from cdpr.ui.cli import DEBUG
from cdpr.ui.cli.load import print_lines, strict_option
from cdpr.ui.cli.names import OutPath, change_keys, plugin_files, plugin_option
from cdpr.ui.cli.numbers import Real, Whole
from cdpr.ui.live import RATES

if TYPE_CHECKING:
    from cdpr.log.run import Run
    from cdpr.scenario import Scenario
    from cdpr.ui.cli.progress import Signals
    from cdpr.ui.live.sender import Sender

# Live links: class (of host, port, message callback and settable parameters) and default port.
LINKS = {"foxglove": ("cdpr.ui.live.foxglove:Foxglove", 8765), "ros2": ("cdpr.ui.live.ros2:Ros2", 7447)}
TOKENS = "foxglove"  # link whose clients need a token
FIRST = "caroca"  # default example
INTERVALS = 3  # printed intervals of a kind, such as with slack cables


@click.command("run")
@click.argument("scenario", required=False, type=click.Path())
@plugin_option("--backend", "backend", metavar="NAME", help="Physics backend, instead of the scenario's.")
@plugin_option("--solver", "solver", metavar="NAME", help="Tension solver, instead of the scenario's.")
@plugin_option("--controller", "controller", metavar="NAME", help="Controller, instead of the scenario's.")
@plugin_option("--estimator", "estimator", metavar="NAME", help="Estimator of the state, instead of the scenario's.")
@change_keys("Change a key of the scenario; repeatable.")
@plugin_files
@click.option("--trust-fmu", is_flag=True, help="Allow the native code of any FMU in the scenario.")
@click.option("--out", type=OutPath(), help="Folder for the results (default: a new one in runs/).")
@click.option("--real-time", is_flag=True, help="Limit the speed to real time.")
@click.option("--report/--no-report", default=True, help="Write report.html (to print it, install the extra 'plot').")
@click.option(
    "--statics", is_flag=True, help="Report the smallest capacity margin and stiffness along the motion, too."
)
@click.option(
    "--live", "tool", type=click.Choice(list(LINKS)), help="Show the run in this tool while it is in progress."
)
@click.option("--live-host", "host", help="Address of the server for Foxglove, or of ROS 2's Zenoh router. [127.0.0.1]")
@click.option(
    "--live-port", "port", type=Whole(0, 65535), help="Its port; 0 selects a free one. [8765; for a router 7447]"
)
@click.option("--live-rate", "rate", type=Real(*RATES), help="Messages of each topic, Hz. [60]")
@click.option("--live-speed", "speed", type=Real(*SPEEDS), help="Largest real-time factor. [1]")
@click.option("--live-no-token", is_flag=True, help="Accept programs, but not web pages, without the token.")
@strict_option
@click.option("--json", "as_json", is_flag=True, help="Print the summary as JSON.")
def command(
    scenario: str | None,
    backend: str | None,
    solver: str | None,
    controller: str | None,
    estimator: str | None,
    changes: tuple[str, ...],
    trust_fmu: bool,
    out: str | None,
    real_time: bool,
    report: bool,
    statics: bool,
    tool: str | None,
    host: str | None,
    port: int | None,
    rate: float | None,
    speed: float | None,
    live_no_token: bool,
    strict: bool,
    as_json: bool,
) -> None:
    """Simulate SCENARIO, a file or the name of an example, and write log, summary and report.

    The default is the example caroca.
    """
    from cdpr.ui.cli.progress import terminating

    if tool is not None and real_time:
        raise click.UsageError(
            "--real-time cannot be combined with --live, which runs in real time: use --live-speed to change the speed"
        )
    with terminating() as signals:
        from cdpr.config.problems import judged
        from cdpr.scenario import load_scenario
        from cdpr.scenario.choices import typed

        if scenario is None:
            scenario = FIRST
            click.echo(f"no scenario is given: this runs the example {FIRST} (cdpr examples lists all)", err=True)
        chosen = {"backend": backend, "solver": solver, "controller": controller, "estimator": estimator}
        loaded = load_scenario(scenario, overrides=typed(chosen, changes))
        print_lines([*loaded.notes, *judged(loaded.warnings, strict=strict)])
        # imported only after the scenario is valid, because it is slow
        from cdpr.log.run_json import loop, to_json

        stop: CdprError | None = None
        try:
            with _trusting(trust_fmu), redirect_output():
                given = {"host": host, "port": port, "rate": rate, "speed": speed, "no-token": live_no_token or None}
                with _linked(tool, given, loaded) as live:
                    run = _simulate(loaded, out, signals, real_time=real_time, live=live)
        except CdprError as error:
            if error.run is None or not len(error.run.rows):
                if not isinstance(error, Interrupted):
                    raise
                click.echo(f"stopped: {error}", err=True)
                raise click.exceptions.Exit(signals.exit_code) from None
            stop, run = error, error.run
            # a second interrupt, or one after the last sample, which skips images
            report = report and signals.received < 2 and run.status != "finished"
        if signals.pending and stop is None:  # after the last check: the run is complete, only the report is skipped
            stop, report = Interrupted("interrupted after the last sample"), False
        signals.wait = False
        least = _least(loaded, run) if statics else {}
        from cdpr.log.interference import cables_in_contact
        from cdpr.ui.report.text.reservations import fallback, lost, reservations

        touch = cables_in_contact(loaded.robot, run, loaded.obstacles)
        if report:
            failure = _write_report(run, least, touch)
            stop = stop or failure
        if strict and stop is None and (far := list(lost(run))):
            stop = ScenarioError(far)
        if as_json:
            notes = {
                "reservations": [*reservations(run), *fallback(run), *lost(run), *([touch] if touch else [])],
                "loop": loop(run),
                "message": run.message,
                "folder": run.folder,
            }
            figures = {**run.summary(), **notes, **({"least": least} if statics else {})}
            click.echo(json.dumps(to_json(figures), indent=2, allow_nan=False))
        else:
            _print(run, least, touch)
    if stop is not None:
        if os.environ.get(DEBUG):
            raise stop
        click.echo(f"stopped: {stop}", err=True)
        raise click.exceptions.Exit(signals.exit_code if isinstance(stop, Interrupted) else stop.exit_code)


def _trusting(fmus: bool) -> AbstractContextManager[None]:
    """Return a context that trusts every FMU, or no additional one."""
    if not fmus:
        return nullcontext()
    from cdpr.fmu.read.trust import any_fmu

    return any_fmu()


class Live(NamedTuple):
    """Live link of a run, its sample rate, Hz, and its speed as a multiple of the wall clock."""

    link: Sender
    rate: float
    speed: float


@contextmanager
def _linked(tool: str | None, given: Mapping[str, Any], scenario: Scenario) -> Iterator[Live | None]:
    """Open the live link before anything is written, until the end of the run."""
    options = {name: value for name, value in given.items() if value is not None}
    if tool is None:
        if options:
            raise click.UsageError(f"--live-{next(iter(options))} requires --live")
        yield None
        return

    def echo(text: str) -> None:
        click.echo(f"live: {text}", err=True)

    factory, port = LINKS[tool]
    where: dict[str, Any] = {"host": "127.0.0.1", "port": port, "rate": 60.0, "speed": 1.0} | options
    if options.get("no-token") and tool != TOKENS:
        raise click.UsageError(f"--live-no-token requires --live {TOKENS}")
    more = {"programs": True} if options.get("no-token") else {}
    link: type[Sender] = resolve_name(factory)
    with closing(link(where["host"], where["port"], echo, scenario.options().numbers(), **more)) as shown:
        echo(shown.where)
        yield Live(shown, where["rate"], where["speed"])


def _simulate(
    scenario: Scenario, out: str | None, signals: Signals, *, real_time: bool, live: Live | None = None
) -> Run:
    """Create the folder and run. Signals end the run at once before the first sample, later between two samples."""
    from pathlib import Path

    import numpy as np

    from cdpr.link.waiting import report_waits
    from cdpr.log.run import Run
    from cdpr.log.run_folder import RUNS, RunFolder
    from cdpr.simulation import simulate
    from cdpr.simulation.disk_space import check_room
    from cdpr.simulation.header import make_header
    from cdpr.ui.cli.progress import Progress

    def advance(done: int, total: int) -> None:
        if signals.pending:  # no write is in progress here
            raise Interrupted("interrupted")
        signals.wait = True
        progress(done, total)

    header = make_header(scenario)
    check_room(scenario, header, Path(out or RUNS))
    signals.wait = True
    folder = RunFolder(Path(out) if out else None, header, sys.argv, scenario=scenario.yaml_in)
    try:
        signals.wait = False
        if signals.pending:
            raise KeyboardInterrupt
        with Progress() as progress, report_waits(partial(click.echo, err=True)):
            if live is not None:
                from cdpr.ui.live.drive import drive

                return drive(scenario, live.link, out=folder, speed=live.speed, rate=live.rate, progress=advance)
            return simulate(scenario, out=folder, real_time=real_time, progress=advance)
    except KeyboardInterrupt as error:
        run = getattr(error, "run", None)
        if not isinstance(run, Run):
            run = Run(header, np.empty((0, header.layout.width)), "interrupted", "interrupted")
            folder.finish(run)
        stopped = Interrupted("interrupted" if len(run.rows) else "interrupted before the first sample")
        stopped.run = run
        raise stopped from None


def _least(scenario: Scenario, run: Run) -> dict[str, dict[str, Any]]:
    """Return the figures of the motion that need kernels which a run does not load."""
    from cdpr.analysis.workspace.path import flown

    return flown(scenario.controlled_robot, run)


def _write_report(run: Run, least: Mapping[str, Mapping[str, Any]], touch: str | None) -> OutputError | None:
    """Write report.html; return the error if it cannot be written."""
    from pathlib import Path

    from cdpr.ui.report.pages.run import write_report

    assert run.folder is not None
    try:
        write_report(run, Path(run.folder) / "report.html", least, touch)
    except OutputError as error:
        return error
    return None


def _print(run: Run, least: Mapping[str, Mapping[str, Any]], touch: str | None) -> None:
    """Print the summary, with the folder last."""
    header = run.header
    plugins = [
        header.backend,
        header.controller,
        header.solver,
        *([header.estimator] if header.estimator not in ("", ESTIMATOR) else []),
    ]
    click.echo(
        f"{header.scenario}: {len(header.cables)} cables, {', '.join(plugins)}; "
        f"control {_ms(header.control_step)}, physics {_ms(header.physics_step)}"
    )
    for line in _lines(run, least):
        click.echo(f"  {line}")
    if touch:
        click.echo(f"  {'WARNING':<20}{touch}")
    for line in _events(run):
        click.echo(f"  {line}")
    if run.unused:
        click.echo(f"  not used by this run: {', '.join(run.unused)}")
    click.echo(run.folder)


def _lines(run: Run, least: Mapping[str, Mapping[str, Any]]) -> Iterator[str]:
    from cdpr.log.run import CLEARANCE
    from cdpr.log.summary import not_judged
    from cdpr.mechanics.contacts import passing
    from cdpr.ui.report.text.aligned import unit_for
    from cdpr.ui.report.text.estimate import estimate_lines
    from cdpr.ui.report.text.least import least_of
    from cdpr.ui.report.text.reservations import fallback, lost, overstrained, reservations

    figures = run.summary()
    if run.header.believed:
        yield f"{'believed':<20}{run.header.believed}"
    texts = list(reservations(run)) if figures["status"] == "finished" else []
    but = f", but {'; '.join(texts)}" if texts else ""
    ended = figures["status"].replace("_", " ")
    yield f"{'simulated':<20}{figures['simulated_s']:.6g} s, {figures['samples']} samples, {ended}{but}"
    for name, key, base in (
        ("position error", "position_error_m", "m"),
        ("orientation error", "orientation_error_rad", "rad"),
    ):
        if key in figures:
            scale, unit = unit_for(figures[key].values(), base)
            values = "   ".join(f"{part} {scale * value:.4g} {unit}" for part, value in figures[key].items())
            yield f"{name:<20}{values}"
    if "tension_N" in figures:
        tension = figures["tension_N"]
        name = "nominal tension" if run.header.takes_lengths else "tension"
        yield (
            f"{name:<20}min {tension['min']:.5g} N   max {tension['max']:.5g} N   "
            f"largest step {tension['largest_step']:.4g} N"
        )
    if "cable_tension_N" in figures:
        felt = figures["cable_tension_N"]
        yield f"{'in the cables':<20}min {felt['min']:.5g} N   max {felt['max']:.5g} N"
    if bad := figures.get("slack_samples"):
        cables = {one["cable"] for one in figures["slack_intervals"]}
        yield f"{'slack':<20}{bad} of {figures['samples']} samples, {_cables(len(cables))}"
    if "motor_current_A" in figures:
        current, used = figures["motor_current_A"], figures["electrical_energy_J"]
        yield (
            f"{'motors':<20}max {current['max']:.4g} A   rms {current['rms']:.4g} A   "
            f"max {figures['motor_voltage_V']['max']:.4g} V   energy used {used['used']:.4g} J, fed back "
            f"{used['regenerated']:.4g} J"
        )
    yield from estimate_lines(figures)
    if "energy_J" in figures:
        energy = figures["energy_J"]
        work = f"work of the cables {energy['cable_work']:.4g} J"
        if energy["external_work"]:
            work += f", of external wrenches {energy['external_work']:.4g} J"
        for source, column in run.header.further_works.items():
            work += f", of {source} {energy[column]:.4g} J"
        much = "TOO MUCH: smaller physics steps, or a backend that makes or loses energy"
        much = f"not judged: {why}" if (why := not_judged(figures)) else much
        but = "" if energy["balanced"] else f", {much}"
        yield (
            f"{'energy':<20}{work}; unexplained {energy['residual_max']:.3g} J "
            f"of {energy['turned_over']:.4g} J turned over{but}"
        )
    if "clearance_min_m" in figures:
        gap, at, by = (figures[key] for key in CLEARANCE)
        through = passing(by, gap)
        where = f"none: {through} at {at:.6g} s" if through else f"{gap:.4g} m at {at:.6g} s, {by}"
        yield f"{'least clearance':<20}{where}"
    for title, text in least_of(least):
        yield f"{title:<20}{text}"
    for name, key in (("infeasible steps", "infeasible_steps"), ("unanswered steps", "unanswered_steps")):
        if figures[key] or key == "infeasible_steps":
            yield f"{name:<20}{figures[key]} of {figures['samples']}"
    for warning in (*overstrained(run), *fallback(run), *lost(run)):
        yield f"{'WARNING':<20}{warning}"
    if "real_time_factor" in figures:
        yield f"{'real-time factor':<20}{figures['real_time_factor']:.4g}"


def _events(run: Run) -> Iterator[str]:
    """Yield the events; of many intervals of one kind, such as with slack cables, the first ones and their number."""
    lasting = {event.kind for event in run.events if event.until is not None}
    kinds: Counter[str] = Counter()
    for event in run.events:
        if event.kind in lasting:
            kinds[event.kind] += 1
        if kinds[event.kind] <= INTERVALS:
            yield f"at {event.when} s: {event.text}"
    for kind, count in kinds.items():
        if more := max(0, count - INTERVALS):
            intervals = f"interval{'s' * (more != 1)} of the kind {kind.replace('_', ' ')}"
            yield f"and {more} more {intervals}: see run.json"


def _cables(count: int) -> str:
    return f"{count} cable{'s' * (count != 1)}"


def _ms(seconds: float) -> str:
    return f"{1e3 * seconds:.6g} ms"
