"""`cdpr fmu`; each of its commands has its own module."""

from __future__ import annotations

import click

from cdpr.ui.cli import LazyGroup

COMMANDS = {
    "info": "Show the metadata of an FMU.",
    "check": "Check an FMU: file, binary, standard and, for a robot, signals.",
    "map": "Print the variables of an FMU by signal, as YAML for a scenario.",
    "export": "Write a robot as an FMU, for other tools or as a plant of cdpr.",
    "trust": "Trust the native code of an FMU, list trusted FMUs, or withdraw trust.",
}


@click.group("fmu", cls=LazyGroup, table=COMMANDS, prefix="fmu_")
def command() -> None:
    """Inspect and export functional mock-up units (FMI 2.0 and 3.0, co-simulation); no native code runs here."""
