"""Option `--chunks` of `cdpr workspace KIND`: results in a folder that can be resumed."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from cdpr.base.errors import CdprError, ExitCode
from cdpr.ui.cli.names import OutPath, again

if TYPE_CHECKING:
    from cdpr.analysis.workspace.regions import Region
    from cdpr.model import Robot

OPTIONS = (
    click.option("--chunks", type=OutPath(), metavar="DIR", help="Folder for a workspace that may exceed the memory."),
    click.option("--resume", is_flag=True, help="Continue --chunks that contain a part of this workspace."),
    click.option("--scheduler", metavar="ADDRESS", help="Compute chunks on a Dask cluster, such as tcp://host:8786."),
)


class Chunked(NamedTuple):
    """Folder of the chunks, and options of their computation."""

    folder: Path
    resume: bool
    scheduler: str | None


def chunked_of(
    chunks: str | None, resume: bool, scheduler: str | None, method: str, jobs: int | None, out: str | None
) -> Chunked | None:
    """Return the values of the options, or None without --chunks.

    Raises:
        UsageError: if options conflict.
    """
    if chunks is None:
        if resume or scheduler is not None:
            raise click.UsageError(f"{'--resume' if resume else '--scheduler'} requires --chunks, a folder")
        return None
    if method != "grid":
        raise click.UsageError(f"--chunks requires --method grid, got {method}: chunks are ranges of cells")
    if out is not None:
        raise click.UsageError("--out does not go with --chunks: the folder of --chunks is the result")
    if jobs is not None and scheduler is not None:
        raise click.UsageError(
            "--jobs does not go with --scheduler: the cluster's workers compute a chunk for each thread"
        )
    return Chunked(Path(chunks), resume, scheduler)


def compute(
    to: Chunked, robot: Robot, kind: str, where: Region, jobs: int | None, source: dict[str, Any], given: dict[str, Any]
) -> dict[str, Any]:
    """Compute a workspace into a folder and return its figures; after an interruption print how to resume."""
    from cdpr.analysis.workspace.chunks import workspace_in_chunks
    from cdpr.ui.cli.progress import Progress, terminating

    with terminating(), Progress("cells") as progress:
        try:
            return workspace_in_chunks(
                robot,
                kind,
                where,
                to.folder,
                resume=to.resume,
                scheduler=to.scheduler,
                jobs=jobs,
                progress=progress,
                source=source,
                **given,
            )
        except (KeyboardInterrupt, CdprError) as stop:
            if isinstance(stop, KeyboardInterrupt) or stop.exit_code == ExitCode.BACKEND_DIED:
                outcome = "interrupted" if isinstance(stop, KeyboardInterrupt) else "stopped"
                more = () if to.resume else ("--resume",)
                progress.print_line(f"{outcome}; continue by: {again(click.get_current_context(), *more)}")
            raise
