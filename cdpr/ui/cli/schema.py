"""`cdpr schema`."""

from __future__ import annotations

import json

import click

from cdpr.ui.cli.names import plugin_files


class SectionsCommand(click.Command):
    """Command whose help lists the sections of scenario files, as their classes describe them."""

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the sections."""
        from cdpr.config.describe import json_schema
        from cdpr.scenario import schema
        from cdpr.scenario.sections import sections_of

        with formatter.section("Sections of scenario files"):
            formatter.write_dl([(each.key, each.text) for each in sections_of(json_schema(schema.ScenarioSection))])


@click.command("schema", cls=SectionsCommand)
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
