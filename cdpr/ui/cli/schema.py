"""`cdpr schema`."""

from __future__ import annotations

import json

import click

from cdpr.ui.cli.names import plugin_files


@click.command("schema")
@click.argument("kind", type=click.Choice(["scenario", "robot"]), default="scenario")
@plugin_files
def command(kind: str) -> None:
    """Print the JSON Schema of scenario or robot files.

    Editors complete keys and show units with it: save it as scenario.schema.json and begin a scenario with
    "# yaml-language-server: $schema=scenario.schema.json".
    """
    from cdpr.scenario.json_schema import robot_schema, scenario_schema

    schema = robot_schema() if kind == "robot" else scenario_schema()
    click.echo(json.dumps(schema, indent=2))
