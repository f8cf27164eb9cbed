"""`cdpr workspace`: kinds of workspaces, and commands for their files."""

from __future__ import annotations

import click

from cdpr.ui.cli import LazyGroup

TABLE = {
    "static": "Where the cables can hold the platform at rest.",
    "wrench-feasible": "Where they can exert all wrenches of a set besides.",
    "dynamic": "Where they can give the platform all accelerations of a set.",
    "closure": "Where they can pull against each other in all directions.",
    "payload": "How much more than the platform they can hold.",
    "stable": "Where it returns to its place once it was moved.",
    "ifcow": "Where no cable touches another, the platform or an obstacle.",
    "stiffness": "How stiffly the cables hold the platform.",
    "frequency": "How slowly the platform swings on its cables.",
    "dexterity": "How evenly the cables work in all directions.",
    "compare": "Verify the same poses by linear programs.",
    "combine": "Make one of two: and, or, minus.",
    "plot": "Draw it with its robot on a page.",
    "export": "Write a file for ParaView, viewers of meshes, or tables.",
}

# Commands for files; the others are kinds.
FILES = ("compare", "combine", "plot", "export")


class Kinds(LazyGroup):
    """Group whose kinds share one module, and whose commands for files have their own."""

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return the command of a kind, or for files."""
        if cmd_name in FILES or cmd_name not in self.table:
            return super().get_command(ctx, cmd_name)
        from cdpr.ui.cli.workspace_kind import command_of

        return command_of(cmd_name, self.table[cmd_name])


@click.group("workspace", cls=Kinds, table=TABLE, prefix="workspace_")
def command() -> None:
    """Find where a robot can hold its platform, exert wrenches, or accelerate, and keep it as a file."""
