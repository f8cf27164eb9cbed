"""`cdpr plugins`."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import click

from cdpr.ui.cli.names import plugin_files

NAME = 21  # width of the column of names


@click.command("plugins")
@plugin_files
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(as_json: bool) -> None:
    """List backends, controllers, solvers and estimators, and their problems."""
    from cdpr.plugins.registry import ROLES, registry

    found = registry()
    rows: dict[str, list[dict[str, Any]]] = {
        role: [
            {
                "name": name,
                "summary": entry.info.summary,
                "properties": dict(entry.info.properties),
                "options": sorted(entry.info.options.model_fields),
                "changeable": list(entry.info.changeable),
                "columns": [column.name for column in entry.info.columns],
                "distribution": entry.distribution,
                "version": entry.version,
                "missing": entry.missing,
                "remedy": entry.remedy if entry.missing else "",
            }
            for name, entry in sorted(found.plugins[role].items())
        ]
        for role in ROLES
    }
    if as_json:
        click.echo(json.dumps({**{f"{role}s": rows[role] for role in ROLES}, "problems": found.problems}, indent=2))
    else:
        for role in ROLES:
            click.echo(f"{role}s")
            for row in rows[role]:
                for line in _description(row):
                    click.echo(line)
        for problem in found.problems:
            click.echo(f"problem: {problem}", err=True)


def _description(row: dict[str, Any]) -> Iterator[str]:
    """Yield the lines of a plugin: name and summary, then its declarations."""
    from cdpr.ui.report.text.aligned import wrapped

    yield from wrapped(f"  {row['name']:<{NAME}} {row['summary']}", NAME + 3)
    facts = [_fact(key, value) for key, value in row["properties"].items()]
    facts += [_fact(key, row[key]) for key in ("options", "changeable", "columns")]
    if row["distribution"] != "cdpr":
        facts.append(f"from {row['distribution']} {row['version']}")
    if row["missing"]:
        facts.insert(0, f"NOT INSTALLED: {row['remedy']}")
    if text := "; ".join(filter(None, facts)):
        yield from wrapped(" " * (NAME + 3) + text, NAME + 3)


def _fact(key: str, value: object) -> str:
    """Return a declaration as text; "" if it declares nothing."""
    if isinstance(value, bool):
        return key.replace("_", " ") if value else f"no {key.replace('_', ' ')}"
    parts = [str(part) for part in value] if isinstance(value, (list, tuple)) else [str(value)]
    return f"{key.replace('_', ' ')}: {', '.join(parts)}" if "".join(parts) else ""
