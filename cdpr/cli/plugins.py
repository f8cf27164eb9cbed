"""`cdpr plugins`."""

from __future__ import annotations

import json
from typing import Any

import click

from cdpr.cli.names import plugin_files


@click.command("plugins")
@plugin_files
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(as_json: bool) -> None:
    """List backends, controllers and solvers, and what is wrong with any."""
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
        from cdpr.report.text.aligned import table

        for role in ROLES:
            click.echo(f"{role}s")
            for line in table([(row["name"], _description(row)) for row in rows[role]], left=2):
                click.echo(line)
        for problem in found.problems:
            click.echo(f"problem: {problem}", err=True)


def _description(row: dict[str, Any]) -> str:
    facts = [f"{key}: {value}" for key, value in row["properties"].items()]
    if row["options"]:
        facts.append("options: " + ", ".join(row["options"]))
    if row["changeable"]:
        facts.append("changeable: " + ", ".join(row["changeable"]))
    if row["columns"]:
        facts.append("columns: " + ", ".join(row["columns"]))
    if row["distribution"] != "cdpr":
        facts.append(f"from {row['distribution']} {row['version']}")
    text = row["summary"] + (f"  [{'; '.join(facts)}]" if facts else "")
    return f"{text}  NOT INSTALLED: {row['remedy']}" if row["missing"] else text
