"""Folder of a workspace in chunks: description, ledger, tables of the cells, and summary.

    workspace.json    parameters, robot and versions; everything that determines the result
    cases.jsonl       one line per written chunk, with its checksum and its tally (`cdpr.analysis.jobs.folder`)
    chunks/000000.npz value, float64; inside and boundary, packed bits; limit, integers as small as possible
    summary.json      written after all chunks

Values are stored exactly, so that a loaded workspace equals one computed in memory to the bit. A cell takes 9.25 bytes;
margins are hardly compressible.
"""

from __future__ import annotations

import io
import json
import os
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from pydantic import TypeAdapter

from cdpr.analysis.jobs.cases import Outcome
from cdpr.analysis.jobs.folder import LEDGER_NAME, read_rows
from cdpr.analysis.workspace import schema
from cdpr.analysis.workspace.accumulator import Accumulator
from cdpr.analysis.workspace.octree import CellResults
from cdpr.analysis.workspace.regions import MOST_CELLS, Region
from cdpr.base.checksums import checksum, opened, unsealed, validated
from cdpr.base.errors import LogError, OutputError

KIND = "workspace"
FORMAT = "cdpr workspace chunks 2"
CHUNKS, SUMMARY, MANIFEST = "chunks", "summary.json", f"{KIND}.json"

MEMORY = 0.5  # largest share of the machine's memory for tables
CELL = 19  # bytes of a cell in memory: value, limit, inside, boundary and evaluated
CELL_WRITTEN = 10  # bytes of a cell on disk, with some reserve

# Keys of workspace.json that identify a workspace, and their names in messages.
ASKED = {
    "format": "format",
    "kind": "kind",
    "robot": "robot",
    "question": "question",
    "over": "over",
    "region": "region",
    "chunk": "cells of a chunk",
    "versions": "versions",
}

TALLY = TypeAdapter(Accumulator)


def packed(found: CellResults) -> bytes:
    """Return the content of a chunk's file."""
    limit, file = found.limit, io.BytesIO()
    small = next(kind for kind in (np.int8, np.int16, np.int32, np.int64) if limit.max() <= np.iinfo(kind).max)
    np.savez(
        file,
        value=found.value,
        inside=np.packbits(found.inside),
        boundary=np.packbits(found.boundary),
        limit=limit.astype(small),
    )
    return file.getvalue()


def unpacked(content: bytes, count: int) -> CellResults:
    """Return the cells of the content of a chunk's file with `count` cells.

    Raises:
        ValueError, KeyError, BadZipFile: if it is damaged.
    """
    with np.load(io.BytesIO(content), allow_pickle=False) as found:
        inside, boundary = (np.unpackbits(found[name], count=count).astype(bool) for name in ("inside", "boundary"))
        read = CellResults(found["value"], found["limit"].astype(np.int64), inside, boundary)
    if any(each.shape != (count,) for each in read):
        raise ValueError("tables of another length")
    return read


def chunk_path(folder: Path, number: int) -> Path:
    """Return the path of a chunk."""
    return folder / CHUNKS / f"{number:06d}.npz"


def read_chunk(folder: Path, number: int, row: Outcome) -> bytes | None:
    """Return the content of a chunk's file; None if it is missing or damaged."""
    try:
        content = chunk_path(folder, number).read_bytes()
    except OSError:
        return None
    return content if checksum(content) == row.summary.get("sha256") else None


def to_json(value: Any) -> Any:
    """Return frozen data, such as a robot, as JSON data; non-finite numbers become text."""
    if is_dataclass(value):
        return {each.name: to_json(getattr(value, each.name)) for each in fields(value)}
    if isinstance(value, Mapping):
        return {str(name): to_json(each) for name, each in value.items()}
    if isinstance(value, np.ndarray):
        return to_json(value.tolist())
    if isinstance(value, tuple | list):
        return [to_json(each) for each in value]
    return str(value) if isinstance(value, float) and not np.isfinite(value) else value


def digest(content: Mapping[str, Any]) -> str:
    """Return the hash that identifies a workspace."""
    question = {name: content[name] for name in ASKED}
    return checksum(json.dumps(question, sort_keys=True).encode())


def refuse_another(folder: Path, content: Mapping[str, Any]) -> None:
    """Raise OutputError with the difference if a folder belongs to another workspace, LogError if it is damaged."""
    if not (folder / MANIFEST).is_file():
        return
    known = _manifest(folder)
    for name, called in ASKED.items():
        there, here = known.get(name), content[name]
        if there == here:
            continue
        where, there, here = next(_differences(called, there, here))
        raise OutputError(
            f"{folder}: contains another workspace: {where} is {_short(there)} there, {_short(here)} here; "
            "choose another folder"
        )


class Folder(NamedTuple):
    """Content of a workspace folder: data as in a file, the cells, and their tables."""

    about: dict[str, Any]
    region: Region
    tables: CellResults


def read_folder(folder: Path) -> Folder:
    """Read a complete folder.

    Raises:
        LogError: if it is incomplete, damaged, or too large.
    """
    known = _manifest(folder)
    there = known["region"]
    lower, upper, attitudes = (np.array(there[name], dtype=float) for name in ("lower", "upper", "orientations"))
    place = Region(lower, upper, tuple(there["cells"]), attitudes)
    chunk, count = known["chunk"], known["cases"]
    about = {name: known[name] for name in ("kind", "question", "over", "method", "notes", "source")}
    about["robot"] = known["robot"]["name"]
    try:
        rows = read_rows((folder / LEDGER_NAME).read_bytes(), folder / LEDGER_NAME, known["digest"])
        summary = (folder / SUMMARY).read_bytes() if (folder / SUMMARY).exists() else None
    except OSError as error:
        raise LogError(f"{error.filename}: cannot be read: {error.strerror or error}") from error
    if summary is None:
        text = f"{len(rows)} of {count} chunks exist; continue by the original command with --resume"
        raise LogError(f"{folder}: is not finished: {text}")
    try:
        about["limited_by"] = dict(opened(summary, schema.SUMMARY, known["digest"]).limited_by)
    except ValueError as error:
        text = f"cannot be read ({error}); the command that wrote it makes it again with --resume"
        raise LogError(f"{folder / SUMMARY}: {text}") from error
    _check_room(folder, place)
    value, limit = np.empty(place.cells), np.empty(place.cells, dtype=np.int64)
    tables = CellResults(value, limit, np.empty(place.cells, dtype=bool), np.empty(place.cells, dtype=bool))
    for number in range(count):
        cut = slice(number * chunk, min((number + 1) * chunk, place.cells))
        content = read_chunk(folder, number, rows[str(number)]) if str(number) in rows else None
        try:
            if content is None:
                raise ValueError
            for table, part in zip(tables, unpacked(content, cut.stop - cut.start), strict=True):
                table[cut] = part
        except (ValueError, KeyError, zipfile.BadZipFile):
            text = "is damaged; the command that wrote it computes it again with --resume"
            raise LogError(f"{chunk_path(folder, number)}: {text}") from None
    return Folder(about, place, tables)


def _check_room(folder: Path, region: Region) -> None:
    need, have = CELL * region.cells, MEMORY * os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    if need > have or region.cells > MOST_CELLS:
        raise LogError(
            f"{folder}: its {region.cells} cells need {need / 2**30:.3g} GiB of memory, more than is available; "
            f"{SUMMARY} contains its figures; choose fewer --cells for a drawing"
        )


def _manifest(folder: Path) -> dict[str, Any]:
    try:
        known = unsealed((folder / MANIFEST).read_bytes())
        if known.get("format") != FORMAT:
            raise ValueError("another format")
        validated(known, schema.MANIFEST)
        if digest(known) != known["digest"]:
            raise ValueError("its digest is of another workspace")
    except (OSError, ValueError) as error:
        raise LogError(f"{folder / MANIFEST}: cannot be read as a workspace in chunks ({error})") from error
    return known


def _differences(name: str, there: Any, here: Any) -> Iterator[tuple[str, Any, Any]]:
    """Yield the names, such as robot.cables.3.tension_max, and both values of all differences."""
    if isinstance(there, dict) and isinstance(here, dict) and there.keys() == here.keys():
        for key in here:
            yield from _differences(f"{name}.{key}", there[key], here[key])
    elif isinstance(there, list) and isinstance(here, list) and len(there) == len(here):
        for k, (one, other) in enumerate(zip(there, here, strict=True)):
            yield from _differences(f"{name}.{k}", one, other)
    elif there != here:
        yield name, there, here


def _short(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 80 else f"{text[:77]}..."
