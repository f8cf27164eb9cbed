"""`cdpr solvers`."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import click

from cdpr.ui.cli.names import plugin_files

if TYPE_CHECKING:
    from cdpr.plugins.registry import Registered

# Columns of the table: heading, and declared property.
COLUMNS = {
    "objective": "objective",
    "exact": "exact",
    "max r": "max_redundancy",
    "coverage": "coverage",
    "continuity": "continuity",
    "keeps limits": "respects_bounds",
    "bounded time": "bounded_time",
    "warm start": "warm_start",
}

LEGEND = """\
  objective      minimised or maximised quantity: min_norm the 2-norm, mid_range the distance from the middle of the
                 limits, one_norm the sum, max_slack the smallest distance to a limit, ...
  exact          answers balance the wrench to round-off
  max r          largest m - n that is supported
  coverage       full: every wrench that can be balanced within the limits is
  continuity     of the tensions along a smooth motion: jump, C0, C1, Cinf
  keeps limits   an answer lies within the limits
  bounded time   the number of steps has a bound
  warm start     an answer may depend on earlier ones, within the accuracy
  -              not declared; `cdpr solvers NAME` shows details, `cdpr check solver NAME` checks declarations"""


@click.command("solvers")
@click.argument("name", required=False)
@click.option("--long", "as_long", is_flag=True, help="Show all properties of each.")
@plugin_files
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(name: str | None, as_long: bool, as_json: bool) -> None:
    """List the installed tension solvers with their objectives, guarantees and supported problems.

    All properties are declared by the plugins.
    """
    from cdpr.plugins.registry import registry
    from cdpr.ui.report.text.aligned import table

    found = registry()
    names = found.names("solver") if name is None else [name]
    solvers = [_describe(each, found.get("solver", each)) for each in names]
    if as_json:
        click.echo(json.dumps(solvers if name is None else solvers[0], indent=2))
    elif as_long or name is not None:
        for solver in solvers:
            for line in _long(solver):
                click.echo(line)
    else:
        rows = [[s["name"], *(_text(s["properties"].get(key)) for key in COLUMNS.values())] for s in solvers]
        for line in table([["solver", *COLUMNS], *rows], left=len(COLUMNS) + 1):
            click.echo(line)
        for solver in solvers:
            if solver["aliases"]:
                click.echo(f"  {solver['name']}: also {', '.join(solver['aliases'])}")
        for solver in solvers:
            if solver["missing"]:
                click.echo(f"  {solver['name']}: not installed: {solver['remedy']}")
        click.echo(LEGEND)
    for problem in found.problems:
        click.echo(f"problem: {problem}", err=True)


def _describe(name: str, entry: Registered) -> dict[str, Any]:
    return {
        "name": name,
        "summary": entry.info.summary,
        "aliases": {str(alias): str(source) for alias, source in entry.info.aliases.items()},
        "properties": {key: value if _is_scalar(value) else str(value) for key, value in entry.info.properties.items()},
        "options": [
            {
                "name": field.alias or key,
                "default": None if field.is_required() else _default(field.get_default(call_default_factory=True)),
                "required": field.is_required(),
                "meaning": field.description or "",
            }
            for key, field in entry.info.options.model_fields.items()
        ],
        "distribution": entry.distribution,
        "version": entry.version,
        "missing": entry.missing,
        "remedy": entry.remedy if entry.missing else "",
    }


def _is_scalar(value: object) -> bool:
    return value is None or isinstance(value, (str, int, float, bool))


def _default(value: object) -> object:
    return value if _is_scalar(value) else str(value)


def _long(solver: dict[str, Any]) -> Iterator[str]:
    """Yield all declarations of a plugin, first the formula and its source."""
    from cdpr.ui.report.text.aligned import wrapped

    properties = dict(solver["properties"])
    yield from wrapped(f"{solver['name']}: {solver['summary']}", 2)
    for key in ("formula", "source"):
        yield from _fact(key, _text(properties.pop(key, None)))
    for title, key in COLUMNS.items():
        yield from _fact(title, _text(properties.pop(key, None)))
    for key, value in properties.items():
        yield from _fact(key, _text(value))
    for alias, source in solver["aliases"].items():
        yield from _fact("also", f"{alias} ({source})")
    for option in solver["options"]:
        default = "not set" if option["default"] is None else f"default {_text(option['default'])}"
        default = "required" if option["required"] else default
        meaning = f": {option['meaning']}" if option["meaning"] else ""
        yield from _fact("option", f"{option['name']} ({default}){meaning}")
    yield from _fact("from", f"{solver['distribution']} {solver['version']}")
    if solver["missing"]:
        yield from _fact("not installed", solver["remedy"])


def _fact(name: str, value: str) -> list[str]:
    """Return one line, or several if the value is long."""
    from cdpr.ui.report.text.aligned import wrapped

    return wrapped(f"  {name:<14} {value}", 17)


def _text(value: object) -> str:
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return str(value)
