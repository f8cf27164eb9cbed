"""`cdpr validate`."""

from __future__ import annotations

import json
import os
import re
from typing import TYPE_CHECKING, Any

import click

from cdpr.base.errors import CdprError, ExitCode, PluginError, ScenarioError
from cdpr.ui.cli.load import print_lines, strict_option
from cdpr.ui.cli.names import change_keys, plugin_files

if TYPE_CHECKING:
    from cdpr.scenario import Scenario


@click.command("validate")
@click.argument("files", nargs=-1, required=True, type=click.Path())
@change_keys("Change any key before checking.")
@plugin_files
@strict_option
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(files: tuple[str, ...], changes: tuple[str, ...], strict: bool, as_json: bool) -> None:
    """Check scenario and robot files.

    The command shows all problems of all FILES with their positions, and warnings about suspicious values, such as
    sizes that seem to be in millimetres, unstable control loops and too long control steps. It does not simulate.
    """
    rows: list[dict[str, Any]] = []
    codes: set[ExitCode] = set()
    reported: set[str] = set()
    for file in files:
        name = click.format_filename(file)
        try:
            row, warned = _facts(file, changes, strict=strict)
        except CdprError as error:
            codes.add(error.exit_code)
            places = [problem.as_dict() for problem in error.rows]
            rows.append({"file": name, "ok": False, "problems": str(error).splitlines(), "rows": places})
            _print_new_errors(name, str(error).splitlines(), reported)
        else:
            rows.append({"file": name, "ok": True, **row})
            if not as_json:
                click.echo(f"{name}: ok ({_brief(row)})")
                if row.get("unused"):
                    click.echo(f"  not used by a run: {', '.join(row['unused'])}")
            print_lines([*row["notes"], *warned])
    if as_json:
        click.echo(json.dumps(rows, indent=2))
    if codes:
        # A missing plugin is no error of the files unless they have others.
        raise click.exceptions.Exit(ExitCode.PLUGIN if codes == {ExitCode.PLUGIN} else ExitCode.BAD_INPUT)


def _facts(file: str, changes: tuple[str, ...], *, strict: bool) -> tuple[dict[str, Any], list[str]]:
    """Return the facts of one file without duplicates, and its warnings as lines."""
    from cdpr.base.problems import Problem
    from cdpr.cables import rubs
    from cdpr.config.problems import judged
    from cdpr.mechanics.restraint import few_cables
    from cdpr.scenario import Scenario, load_any

    notes: list[str] = []
    warnings: list[Problem] = []
    loaded = load_any(file, overrides=changes, notes=notes, warnings=warnings)
    robot = loaded.robot if isinstance(loaded, Scenario) else loaded
    if few := few_cables(robot):
        notes.append(f"{click.format_filename(file)}: note: {few}")
    if rubs(robot):
        notes.append(f"{click.format_filename(file)}: note: friction on pulleys acts in runs only; statics ignore it")
    loop: dict[str, Any] = {}
    if isinstance(loaded, Scenario):
        judged(warnings, strict=strict)
        _require_buildable(loaded)
        from cdpr.simulation.far_start import PATH, start_problems
        from cdpr.simulation.linearised_scenario import unknown_part
        from cdpr.simulation.loop_problems import NOT_COMPUTED, loop_problems

        loop["closed_loop"], found = loop_problems(loaded)
        reason = loop["closed_loop"].removeprefix(NOT_COMPUTED)
        reported = any(reason.endswith(text) for _, text in found)
        if reason != loop["closed_loop"] and not reported and not unknown_part(loaded):
            notes.append(f"{click.format_filename(file)}: note: poles of the closed loop {loop['closed_loop']}")
        try:
            found += start_problems(loaded)
        except CdprError as error:  # of the search for the pose of rest
            raise ScenarioError([f"{loaded.place(*PATH)}: {error}"]) from None
        warnings += [Problem(loaded.mark(*path), path, text) for path, text in found]
    warned = judged(warnings, strict=strict)
    rows = [warning.as_dict() for warning in warnings]
    facts = {"notes": notes, "warnings": rows}
    keys = {warning["key"] for warning in rows}
    if not isinstance(loaded, Scenario):
        return {"kind": "robot", "name": robot.name, "cables": robot.m, **facts}, warned
    row = {
        "kind": "scenario",
        "name": loaded.name,
        "cables": loaded.robot.m,
        "duration": loaded.simulation.duration,
        **({"believed": loaded.nominal_differences} if loaded.nominal_differences else {}),
        "unused": [key for key in loaded.unused if key not in keys],
        **loop,
        **facts,
    }
    return row, warned


def _require_buildable(scenario: Scenario) -> None:
    """Raise an error with everything that prevents a run; PluginError if only plugins are at fault."""
    from cdpr.simulation.build import faults

    found = list(faults(scenario))
    lines = [
        text if (text := str(fault.error)).startswith(place := f"{scenario.place(*fault.path)}: ") else f"{place}{text}"
        for fault in found
    ]
    if lines and all(isinstance(fault.error, PluginError) for fault in found):
        raise PluginError("\n".join(lines))
    if lines:
        raise ScenarioError(lines)


def _print_new_errors(name: str, lines: list[str], reported: set[str]) -> None:
    """Print each error once: errors of a robot file also occur in all scenarios that use it."""
    plain = {line: _without_source(line) for line in lines}
    fresh = [line for line in lines if plain[line] not in reported]
    reported.update(plain.values())
    for line in fresh:
        click.echo(line, err=True)
    if len(fresh) < len(lines):
        known = len(lines) - len(fresh)
        click.echo(f"{name}: {known} {'more ' * bool(fresh)}problem{'s' * (known > 1)}, reported above", err=True)


def _without_source(line: str) -> str:
    """Return the same text for the same error, whichever file refers to it."""
    source, colon, text = line.partition(":")
    return os.path.normpath(source) + colon + re.sub(r"\brobot\.", "", text)


def _brief(row: dict[str, Any]) -> str:
    cables = f"{row['cables']} cable{'' if row['cables'] == 1 else 's'}"
    duration = f", {row['duration']:g} s" if "duration" in row else ""
    return f"{row['kind']}, {cables}{duration}"
