"""Workspaces of any number of cells, computed in chunks into a folder that can be resumed.

A chunk is a fixed range of cell numbers. The folder's files and its summary have the same bits for any number of
threads, on a cluster, and after interruptions. The summary equals that of `workspace` in memory to the bit. The memory
holds a few chunks per thread, and one layer of the table across its first axis to count connected parts.
"""

from __future__ import annotations

import json
import math
import os
import shutil
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cdpr.analysis.jobs.cases import Outcome
from cdpr.analysis.jobs.cluster import spread
from cdpr.analysis.jobs.folder import JobFolder
from cdpr.analysis.jobs.threads import beside
from cdpr.analysis.workspace import answers, chunk_files
from cdpr.analysis.workspace.accumulator import Accumulator, figures, tally, total
from cdpr.analysis.workspace.chunk_files import TALLY, chunk_path, packed, read_chunk, unpacked
from cdpr.analysis.workspace.connected import Connected, layer
from cdpr.analysis.workspace.evaluate import Over, checked_question, evaluate_positions
from cdpr.analysis.workspace.kinds import kind_of
from cdpr.analysis.workspace.octree import CellResults
from cdpr.analysis.workspace.question import Question
from cdpr.analysis.workspace.regions import PIECE, Region
from cdpr.base.checksums import checksum, sealed
from cdpr.base.errors import CdprError, Interrupted, LogError, OutputError
from cdpr.base.incomplete import TEMPORARY
from cdpr.log.files import make_folder
from cdpr.log.files import replace as write
from cdpr.log.run_folder import folder_name
from cdpr.model import Robot
from cdpr.native.operations import kernels_version

PIECES = 8  # pieces of cells per chunk: half a second of margins, and 5 MB
AHEAD = 2  # chunks of a cluster per thread: one running, one waiting
MOST_WIDE = 10**7  # limit of cells along an axis and in a layer: half a gigabyte of memory

Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class Task:
    """Parameters of all cells."""

    robot: Robot
    kind: str
    question: Question
    region: Region
    over: Over
    jobs: int  # threads within a chunk


class Chunk(NamedTuple):
    """Range of cells."""

    task: Task
    number: int
    cells: range


class ChunkResult(NamedTuple):
    """Result of a chunk."""

    number: int
    content: bytes  # content of its file
    checksum: str
    counted: Accumulator


def workspace_in_chunks(
    robot: Robot,
    kind: str,
    region: Region,
    folder: str | os.PathLike[str],
    question: Question | None = None,
    *,
    over: Over = "all",
    resume: bool = False,
    jobs: int | None = None,
    scheduler: str | None = None,
    progress: Progress = lambda done, total: None,
    source: Mapping[str, Any] | None = None,
    pieces: int = PIECES,
    **options: Any,
) -> dict[str, Any]:
    """Find the cells of a region inside a workspace, like `workspace` by its grid, and write them into a folder.

    After a KeyboardInterrupt the folder can be resumed.

    Args:
        robot: as in `workspace`.
        kind: as in `workspace`.
        region: as in `workspace`.
        question: as in `workspace`.
        over: as in `workspace`.
        **options: as in `workspace`.
        folder: new, empty, or with some chunks of the same workspace.
        resume: continue a folder with some chunks; damaged chunks are computed again.
        jobs: threads, one per core by default; the result is the same.
        scheduler: address of a Dask cluster that computes the chunks, such as tcp://host:8786.
        progress: called with the number of finished cells and their total.
        source: information to find the robot's file again, for the record.
        pieces: size of a chunk in units of 65536 cells.

    Returns:
        The summary, as `Workspace.summary`; `load_workspace(folder)` reads the tables if they fit into memory.

    Raises:
        CdprError: if an argument is invalid.
        OutputError: if the folder has other content, is in use or cannot be written.
        PluginError: if distributed is not installed.
    """
    chosen, place = kind_of(kind), folder_name(folder)
    whole = checked_question(chosen, robot, question, over, options)
    if max(*region.shape, math.prod(layer(region.shape))) > MOST_WIDE:
        raise CdprError(f"cells: expected at most {MOST_WIDE} along an axis, and in a layer across the first")
    if jobs is not None and scheduler is not None:
        raise CdprError("jobs does not go with scheduler: the cluster's workers compute a chunk for each thread")
    content = _content(Task(robot, kind, whole, region, over, 1), pieces * PIECE, source)
    chunk_files.refuse_another(place, content)
    opened = JobFolder(place, chunk_files.KIND, content)
    try:
        ended = _whole(opened, content["cases"], resume)
        done = sum(len(_cells(region, content["chunk"], number)) for number in ended)
        _check_disk(place, region.cells - done)
        waiting = [number for number in range(content["cases"]) if number not in ended]
        progress(done, region.cells)

        def keep(found: ChunkResult) -> None:
            nonlocal done
            path = chunk_path(place, found.number)
            write(path, found.content)
            row = {"sha256": found.checksum, "tally": asdict(found.counted)}
            opened.record(Outcome(str(found.number), "finished", "", f"{path.parent.name}/{path.name}", row))
            done += found.counted.cells
            progress(done, region.cells)

        if waiting:
            (place / chunk_files.SUMMARY).unlink(missing_ok=True)
            make_folder(place / chunk_files.CHUNKS)
        threads = len(os.sched_getaffinity(0)) if jobs is None else jobs
        every = Task(robot, kind, whole, region, over, 1 if scheduler else max(1, threads // max(1, len(waiting))))
        chunks = (Chunk(every, number, _cells(region, content["chunk"], number)) for number in waiting)
        if scheduler is None:
            beside(chunks, run_chunk, threads, keep, chunk_files.KIND)
        else:
            _on_cluster(chunks, scheduler, keep)
        return _finish(opened, every, content)
    finally:
        opened.close()


def run_chunk(chunk: Chunk, stopped: Callable[[], bool] = lambda: False) -> ChunkResult:
    """Compute a chunk, piece by piece.

    Raises:
        Interrupted: after `stopped` returns True.
    """
    task, numbers = chunk.task, np.arange(chunk.cells.start, chunk.cells.stop)
    kind, region, parts, counted = kind_of(task.kind), task.region, [], []
    for first in range(0, len(numbers), PIECE):
        if stopped():
            raise Interrupted("interrupted")
        cells = numbers[first : first + PIECE]
        parts.append(
            evaluate_positions(task.robot, kind, task.question, region, task.over, region.positions(cells), task.jobs)
        )
        counted.append(tally(cells, region.shape, parts[-1]))
    content = packed(CellResults(*(np.concatenate(each) for each in zip(*parts, strict=True))))
    return ChunkResult(chunk.number, content, checksum(content), total(counted))


def _content(task: Task, chunk: int, source: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return the content of workspace.json."""
    region, kind = task.region, kind_of(task.kind)
    content: dict[str, Any] = {
        "name": f"{kind.name} of {task.robot.name}",
        "cases": -(-region.cells // chunk),
        "format": chunk_files.FORMAT,
        "kind": kind.name,
        "region": {
            "lower": region.lower.tolist(),
            "upper": region.upper.tolist(),
            "cells": list(region.shape),
            "orientations": region.orientations.tolist(),
        },
        "question": task.question.to_dict(task.robot),
        "over": task.over,
        "method": "grid",
        "notes": answers.notes(task.robot, task.question, bodies=kind.bodies),
        "chunk": chunk,
        "versions": {
            "kernels": kernels_version(),
            **{name: version(name) for name in ("cdpr", "numpy")},
        },
        "robot": chunk_files.to_json(task.robot),
        "source": dict(source or {}),
    }
    content = json.loads(json.dumps(content))  # as read from the file
    return content | {"digest": chunk_files.digest(content)}


def _cells(region: Region, chunk: int, number: int) -> range:
    return range(number * chunk, min((number + 1) * chunk, region.cells))


def _whole(folder: JobFolder, count: int, resume: bool) -> set[int]:
    """Return the numbers of the undamaged chunks in the folder."""
    if resume:
        for left in chunk_path(folder.path, 0).parent.glob(f"*{TEMPORARY}"):  # of a killed writer
            left.unlink(missing_ok=True)
    if folder.rows and not resume:
        raise OutputError(
            f"{folder.path}: contains {len(folder.rows)} of {count} chunks of this workspace: continue by --resume "
            "(in Python resume=True), or choose another folder"
        )
    return {int(key) for key, row in folder.rows.items() if read_chunk(folder.path, int(key), row) is not None}


def _check_disk(folder: Path, cells: int) -> None:
    need = chunk_files.CELL_WRITTEN * cells
    if need > shutil.disk_usage(folder).free:
        raise OutputError(f"{folder}: {cells} cells need {need / 2**30:.3g} GiB, more than its disk has: fewer --cells")


def _on_cluster(chunks: Iterator[Chunk], address: str, keep: Callable[[ChunkResult], None]) -> None:
    def end(key: str, found: ChunkResult | None, lost: str) -> None:
        if found is None:
            raise CdprError(f"chunk {key} was {lost}; --resume continues")
        keep(found)

    spread(address, partial(run_chunk), {str(chunk.number): chunk for chunk in chunks}, end, AHEAD)


def _finish(folder: JobFolder, task: Task, content: Mapping[str, Any]) -> dict[str, Any]:
    """Combine the summary in the order of the chunks, and write it."""
    region, kind, pieces, parts = task.region, kind_of(task.kind), Connected(task.region.shape), []
    for number in range(content["cases"]):
        row = folder.rows[str(number)]
        parts.append(TALLY.validate_python(row.summary["tally"]))
        read = read_chunk(folder.path, number, row)
        if read is None:
            raise LogError(f"{chunk_path(folder.path, number)}: was changed meanwhile; --resume computes it again")
        pieces.add(unpacked(read, parts[-1].cells).inside)
    counted = total(parts)
    named = answers.limits(task.robot, task.question, list(counted.limits), bodies=kind.bodies)
    about = {"limited_by": named, "method": content["method"], "notes": content["notes"]}
    result = figures(
        kind,
        task.robot.name,
        region,
        task.question,
        about,
        counted,
        evaluated=region.cells,
        components=pieces.pieces,
    )
    summary = sealed(result | {"limited_by": named}, content["digest"])
    write(folder.path / chunk_files.SUMMARY, json.dumps(summary, indent=1) + "\n")
    return result
