"""`cdpr fmu trust`."""

from __future__ import annotations

import json

import click


@click.command("trust")
@click.argument("file", required=False, type=click.Path())
@click.option("--remove", is_flag=True, help="Remove FILE, or the FMU with that sha256, from the list.")
@click.option("--json", "as_json", is_flag=True, help="Print the list as JSON.")
def command(file: str | None, remove: bool, as_json: bool) -> None:
    """Allow the native code of the FMU in FILE on this account from now on; without FILE, list the trusted FMUs.

    Native code has your permissions. Trust belongs to the content: a changed file must be trusted again.
    """
    import re

    from cdpr.fmu.read import trust
    from cdpr.fmu.read.archive import open_archive

    if file is None and remove:
        raise click.UsageError("--remove needs FILE or a sha256")
    if file is not None:
        given = re.fullmatch(r"[0-9a-f]{64}", file)
        sha256 = file if remove and given else open_archive(file).sha256
        if remove:
            trust.remove(sha256)
        else:
            trust.add(sha256, file)
        click.echo(f"{'no longer trusted' if remove else 'trusted'}: {sha256}  {file}", err=True)
        click.echo(f"list: {trust.list_path()}", err=True)
        return
    found = trust.trusted()
    if as_json:
        click.echo(json.dumps([{"sha256": sha256, "name": name} for sha256, name in found.items()], indent=2))
    else:
        for sha256, name in found.items():
            click.echo(f"{sha256}  {name}")
        if not found:
            click.echo(f"no FMU is trusted; list: {trust.list_path()}", err=True)
