"""`cdpr workspace`: kinds of workspaces, and commands for their files."""

from __future__ import annotations

import click

from cdpr.ui.cli import LazyGroup

TABLE = {
    "static": "Poses at which the cables can balance the weight at rest.",
    "wrench-feasible": "Poses at which the cables can exert all additional wrenches of a set.",
    "dynamic": "Poses at which the cables can exert all accelerations of a set.",
    "closure": "Poses at which the cables can pull against each other in all directions.",
    "payload": "Largest additional mass that the cables can hold.",
    "stable": "Poses to which the platform returns after a displacement.",
    "ifcow": "Poses at which no cable touches another, the platform or an obstacle.",
    "stiffness": "Stiffness of the platform on its cables.",
    "frequency": "Lowest frequency of the platform on its cables.",
    "dexterity": "Ratio of the smallest to the largest singular value of the wrench matrix.",
    "compare": "Verify the same poses by linear programs.",
    "combine": "Combine two workspaces: and, or, minus.",
    "plot": "Draw a workspace with its robot on a page.",
    "export": "Convert a workspace for ParaView, mesh viewers, or tables.",
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
    """Compute the poses at which a robot can hold its platform, exert wrenches or accelerate, and save them."""
