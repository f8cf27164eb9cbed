"""Reading of logs.

A short log is read and verified immediately (`cdpr.log.walk`). Of a long complete log, only the index at its end is
read (`cdpr.log.index`); rows are read and verified on access.
"""

from __future__ import annotations

import json
import math
import os
import struct
import warnings
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from mcap import records
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode

from cdpr.base.errors import LogError
from cdpr.base.problems import shown
from cdpr.log import run_json
from cdpr.log.checksum import crc32
from cdpr.log.chunk_index import Written
from cdpr.log.event import Event
from cdpr.log.header import Header
from cdpr.log.index import read_index
from cdpr.log.mcap_file import FORMATS, LOG_NAME, MAGIC, METADATA, OPENING, LogFormat
from cdpr.log.rows import IN_MEMORY, LogRows
from cdpr.log.run import CLEARANCE, Run
from cdpr.log.walk import Walk
from cdpr.model.robot import Array

TEXTS = ("scenario", "robot", "backend", "controller", "solver", "scenario_yaml", "cable_model", "believed")


def load_run(path: str | Path) -> Run:
    """Load a run from its folder or its log.

    Status, events and timings come from `run.json`. Without it, a complete log counts as finished and any other as
    running. A truncated or damaged log gives the rows before the damage, with a warning.

    Args:
        path: folder of a run, or its log file.

    Returns:
        The run; rows of long runs stay on disk until they are read.

    Raises:
        LogError: if there is no log, it is not from cdpr, or nothing can be read.

    Example:
        >>> import tempfile
        >>> import cdpr
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     _ = cdpr.simulate("caroca", overrides={"simulation.duration": 0.1}, out=f"{folder}/run")
        ...     run = cdpr.load_run(f"{folder}/run")
        ...     print(run)
        <Run of caroca on reference: 101 samples, finished>
    """
    log, folder = locate(path)
    found = scan(log, verify=False)
    if found.problem is not None:
        warnings.warn(
            f"{log}: {found.problem}; {len(found.rows)} rows kept. `cdpr repair {path}` writes a complete log",
            stacklevel=2,
        )
    known = None if folder is None else run_json.read(folder)
    if known is None:
        known = {"status": "finished" if found.problem is None else "running"}
    elif folder is not None:
        run_json.check_log(known, folder, found.header, found.rows if found.problem is None else None)
    try:
        return Run(
            header=amended(found.header, known),
            rows=found.rows,
            status=known["status"],
            message=known.get("message", ""),
            events=tuple(Event(**event) for event in known.get("events", ())),
            timings=dict(known.get("timings", {})),
            unused=tuple(known.get("unused", ())),
            interpreted=_interpreted(known.get("loop")),
            plugins=dict(known.get("plugins", {})),
            folder=None if folder is None else str(folder),
            counted=_counted(found.header, known),
            clearance=_clearance(known),
        )
    except (KeyError, TypeError, ValueError) as error:
        raise LogError(
            f"{folder}/{run_json.NAME}: not as cdpr writes it ({error!r}); without that file the log still loads"
        ) from error


def amended(header: Header, known: dict[str, Any]) -> Header:
    """Return the header with the broken cables and limits of run.json: a log does not contain live changes."""
    found = known.get("header")
    found = found if isinstance(found, dict) else {}
    if (rows := found.get("broken")) is not None:
        header = replace(header, broken=tuple((int(i), float(time)) for i, time in rows))
    if (rows := found.get("limit_changes")) is not None:
        changes = ((float(time), tuple(low), tuple(map(_high, high))) for time, low, high in rows)
        header = replace(header, limit_changes=tuple(changes))
    return header


def _high(limit: float | None) -> float:
    """Return a highest tension, N, of run.json, which stores infinity as null."""
    return math.inf if limit is None else float(limit)


def _counted(header: Header, known: dict[str, Any]) -> dict[str, Any] | None:
    """Return the figures of all samples of a thinned run from run.json; None if they must be computed from the rows."""
    figures = known.get("summary")
    if header.log_every == 1 or known["status"] == "running" or not isinstance(figures, dict):
        return None
    if not all(key in figures for key in ("samples", "simulated_s", "infeasible_steps")):
        return None
    return {key: _number(value) for key, value in figures.items() if key not in ("status", "real_time_factor")}


def _clearance(known: dict[str, Any]) -> dict[str, Any]:
    """Return the smallest clearance from run.json, if known: the log has no cable diameters."""
    figures = known.get("summary")
    return {key: figures[key] for key in CLEARANCE if key in figures} if isinstance(figures, dict) else {}


def _number(value: Any) -> Any:
    """Restore non-finite numbers, which run.json stores as null."""
    if isinstance(value, dict):
        return {key: _number(item) for key, item in value.items()}
    return math.nan if value is None else value


def locate(path: str | Path) -> tuple[Path, Path | None]:
    """Return the log of a path (run folder or log), and the run folder, if any."""
    if not isinstance(path, str | os.PathLike):
        raise LogError(f"expected the folder of a run, or a log, got {shown(path)}")
    path = Path(path)
    if os.path.isdir(path):
        log = path / LOG_NAME
        if not log.exists():
            raise LogError(f"{path}: contains no {LOG_NAME}; give the folder of a run, or a log")
        return log, path
    if not os.path.exists(path):
        raise LogError(f"{path}: no such file or folder; give the folder of a run, or a log")
    return path, path.parent if path.name == LOG_NAME else None


@dataclass(frozen=True)
class Scan:
    """Content of a log."""

    header: Header
    rows: Array | LogRows  # (K, width), up to the first damage
    problem: str | None  # None if the log is complete
    form: LogFormat  # expected format
    chunks: tuple[Written, ...]  # valid chunks up to the first damage
    end: int  # end of the last one, byte
    tail: int = 0  # number of last rows in an incomplete block


def scan(log: Path, *, verify: bool = True) -> Scan:
    """Read the valid part of a log.

    Args:
        log: the log.
        verify: read all rows. Otherwise the rows of a long log with a valid end are read and verified on access.

    Raises:
        LogError: if it cannot be opened, is not from cdpr, or its header is damaged.
    """
    try:
        with log.open("rb") as file:
            header, form = _read_header(file, log)
            file.seek(0)
            intact = file.read(len(form.description)) == form.description
            index = None if verify or not intact else read_index(file, form)
            if index is not None and 8 * header.layout.width * index.rows > IN_MEMORY:
                unread = LogRows(os.dup(file.fileno()), form, index.blocks, name=str(log))
                return Scan(header, unread, None, form, index.chunks, index.end)
            walk = Walk(file, form, IN_MEMORY)
            problem = walk.run()
            rows = walk.rows(str(log))
    except OSError as error:
        raise LogError(f"{log}: cannot be read: {error.strerror or error}") from error
    problem = problem if intact else "the description at its start is damaged"
    return Scan(header, rows, problem, form, tuple(walk.chunks), walk.position, walk.tail)


def _read_header(file: BinaryIO, log: Path) -> tuple[Header, LogFormat]:
    opening = file.read(len(OPENING))
    if not opening:
        raise LogError(f"{log}: is empty: the run ended before it wrote anything")
    if not opening.startswith(MAGIC[: len(opening)]):
        raise LogError(f"{log}: is not an MCAP file")
    head = file.read(9)
    if len(head) < 9:
        raise LogError(f"{log}: is truncated within its first bytes: no data can be read")
    if opening != OPENING or head[0] != Opcode.METADATA:
        raise LogError(f"{log}: is an MCAP file, but no log of cdpr, or damaged at its start")
    length = min(int.from_bytes(head[1:], "little"), os.fstat(file.fileno()).st_size)
    try:
        metadata = records.Metadata.read(ReadDataStream(BytesIO(file.read(length))))
        values = metadata.metadata
        version, text, crc = values["format"], values["header"], values["header_crc32"]
        if metadata.name != METADATA or f"{crc32(text.encode()):08x}" != crc:
            raise ValueError("checksum")
    except (McapError, KeyError, ValueError, struct.error) as error:
        raise LogError(f"{log}: the header is damaged or truncated: no data can be read") from error
    if version not in FORMATS:
        known = f"{', '.join(FORMATS[:-1])} and {FORMATS[-1]}"
        raise LogError(f"{log}: has log format {version}, this cdpr reads {known}: use the version that wrote it")
    try:
        header = Header.from_dict(json.loads(text))
        form, unsound = LogFormat(header, text, version), _unsound(header)
    except (LookupError, ArithmeticError, TypeError, ValueError) as error:
        raise LogError(f"{log}: was written by another version of cdpr: {error}") from error
    if unsound:
        raise LogError(f"{log}: its header is not one that cdpr writes: {unsound}")
    return header, form


def _unsound(header: Header) -> str:
    """Return the invalid part of a header with a valid checksum, as other programs may write; "" if there is none."""
    m, bounds = len(header.cables), np.array(header.bounds, dtype=object)
    for name in TEXTS:
        if not isinstance(getattr(header, name), str):
            return f"{name}: expected a text"
    if not all(isinstance(cable, str) for cable in header.cables):
        return "cables: expected texts"
    if not all(0 <= cable < m for cable, _ in header.broken):
        return f"broken: expected cables from 0 to {m - 1}"
    for name, values, shape in (
        ("gravity", header.gravity, (3,)),
        ("anchors", header.anchors, (m, 6)),
        ("tension_min", np.nan_to_num(header.tension_min, posinf=0.0, neginf=0.0, nan=np.nan), (m,)),
        ("tension_max", np.nan_to_num(header.tension_max, posinf=0.0, neginf=0.0, nan=np.nan), (m,)),
        ("characteristic_length, mass and steps, above 0", _sizes(header), (4,)),
        ("frame", header.frame or np.empty((0, 6)), (len(header.frame), 6)),
        ("bounds", np.where(bounds == None, 0.0, bounds), (3, m) if header.bounds else (0,)),  # noqa: E711
        ("path", header.path or np.empty((0, 3)), (len(header.path), 3)),
        ("shape", _numbers(header.shape), (len(_numbers(header.shape)),)),
    ):
        array = np.array(values, dtype=np.float64)
        if array.shape != shape or not np.isfinite(array).all():
            return f"{name}: expected {' x '.join(map(str, shape))} finite numbers"
    return ""


def _sizes(header: Header) -> list[float]:
    sizes = [header.characteristic_length, header.mass, header.control_step, header.physics_step]
    return [size if size > 0.0 else math.nan for size in sizes]


def _numbers(value: Any) -> list[float]:
    """Return the numbers in plain data."""
    if isinstance(value, dict | list | tuple):
        inner = value.values() if isinstance(value, dict) else value
        return [number for each in inner for number in _numbers(each)]
    return [value] if isinstance(value, int | float) else []


def _interpreted(loop: Any) -> tuple[str, ...] | None:
    """Return the parts executed by Python according to run.json; None if unknown."""
    return tuple(map(str, loop.get("python", ()))) if isinstance(loop, dict) else None
