"""Check of memory and disk space for the samples of a run, before anything is made."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

from cdpr.base.errors import OutputError, ScenarioError
from cdpr.log.blocks import BLOCK
from cdpr.log.chunk import Template
from cdpr.log.files import unwritable
from cdpr.log.header import Header
from cdpr.log.topics import run_topics
from cdpr.scenario import Scenario

FLOAT = 8  # bytes


def check_room(scenario: Scenario, header: Header, folder: Path | None) -> None:
    """Check that log.mcap in `folder`, or without one the rows in memory, can fit.

    The compression of a log is unknown in advance: only its indexes, which are not compressed, are counted.

    Raises:
        ScenarioError: if the samples can never fit.
        OutputError: if the disk of `folder` is too full or its free space is unknown.
    """
    samples = scenario.simulation.steps // header.log_every + 1
    if folder is None:
        need = samples * FLOAT * header.layout.width
        have, where = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"), "the memory of this machine"
        most = have
    else:
        group = run_topics(header)
        need = samples * len(group.topics) * Template(group).index_length(BLOCK) // BLOCK
        try:
            above = next(path for path in (folder.absolute(), *folder.absolute().parents) if path.is_dir())
            disk, where = shutil.disk_usage(above), f"the disk of {folder}"
            have = disk.free if disk.total else need  # 0: no disk, and not writable
            most = disk.total
        except OSError as error:  # for example below a folder without search permission
            raise unwritable(folder, error) from error
    if need > have:
        least = "at least " if folder is not None else ""
        text = (
            f"{scenario.place('simulation', 'duration')}: simulation.duration: {samples} samples need {least}"
            f"{_size(need)}, {where} has {_size(have)}: shorten it or thin the log by log.step"
        )
        raise OutputError(f"{text}, or make room there") if need <= most else ScenarioError([text])


def _size(count: int) -> str:
    """Return a number of bytes in a readable unit."""
    unit, name = next(each for each in ((1e9, "GB"), (1e6, "MB"), (1e3, "kB")) if count >= each[0] or each[0] == 1e3)
    return f"{count / unit:.3g} {name}"
