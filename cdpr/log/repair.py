"""Repair of killed runs: completes the log and run.json in place, because there may be no space for a copy."""

from __future__ import annotations

import contextlib
import itertools
import os
import shutil
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

from cdpr.base.errors import OutputError
from cdpr.base.locks import Lock, lock, open_to_lock
from cdpr.log import run_json
from cdpr.log.blocks import BLOCK
from cdpr.log.files import GOES_ON, Reserved, replacing, unwritable
from cdpr.log.header import Header
from cdpr.log.mcap_file import FORMATS, LOG_NAME, PICTURE_ROWS, LogFormat, Piece
from cdpr.log.reader import Scan, amended, locate, scan
from cdpr.log.run import Run
from cdpr.log.run_folder import SCENARIO_NAME


@dataclass(frozen=True)
class RepairReport:
    """Result of `repair`."""

    log: Path
    rows: int  # number of kept rows
    problem: str | None  # defect of the log; None if it was complete
    torn: Path | None  # file with the overwritten bytes
    lost: int  # bytes not kept for lack of space: part of one incomplete block
    interrupted: bool  # True if run.json changed from "running" to "interrupted"

    @property
    def changed(self) -> bool:
        """True if anything was written."""
        return self.problem is not None or self.interrupted


def repair(path: str | Path) -> RepairReport:
    """Repair a run folder or a log; do nothing if it is valid.

    A truncated or damaged log is completed from its last complete block on. The bytes after it are kept as
    `log.mcap.torn`, unless there is no space for them and they are part of one block. The status "running" in run.json
    becomes "interrupted", also if the run was killed before it had a log.

    Raises:
        LogError: if there is no log, it is not from cdpr, or nothing can be read.
        OutputError: if the run is still active, or the folder cannot be written; all rows are still in the log.
    """
    path = Path(path)
    folder = path if path.is_dir() else path.parent if path.name == LOG_NAME else None
    with _locked(path, folder) as reserved:
        if folder is not None and _never_began(folder):
            return _interrupt_unbegun(folder, reserved)
        log, folder = locate(path)
        found = scan(log)
        torn, lost = (None, 0) if found.problem is None else _mend(log, found)
        interrupted = folder is not None and _interrupt(folder, found, reserved)
        return RepairReport(log, len(found.rows), found.problem, torn, lost, interrupted)


@contextlib.contextmanager
def _locked(path: Path, folder: Path | None) -> Iterator[Reserved | None]:
    """Lock out runs and other repairs; yield the space that a killed run reserved for run.json.

    A run locks that space before it writes anything else, until its end. Without the space no run can be active, and
    the log itself is locked.

    Raises:
        OutputError: if another process is active.
    """
    reserved = None if folder is None else Reserved.left(folder / run_json.NAME)
    file = None
    if reserved is None:
        with contextlib.suppress(OSError):  # errors are reported by the reader
            log = folder / LOG_NAME if folder is not None else path
            file = open_to_lock(log.resolve(), os.O_RDONLY)
    try:
        if file is not None and lock(file) is Lock.ANOTHERS:
            raise OutputError(f"{path}: {GOES_ON}")
        yield reserved
    finally:
        if file is not None:
            os.close(file)
        if reserved is not None:
            reserved.close()


def _mend(log: Path, found: Scan) -> tuple[Path | None, int]:
    """Complete the log from its last block on; return the file of overwritten bytes and the number of lost bytes."""
    end, data = _completed(found)
    form = found.form
    torn = _unused(log)
    try:
        with log.open("r+b") as file:
            start = file.read(len(form.description))
            damaged = b"" if start == form.description else start
            rest = file.seek(0, os.SEEK_END) - end
            # At most the last block and the rest of one after a kill or a full disk; otherwise possibly more than a
            # damaged block.
            short = rest <= 2 * _block_size(form) + form.gap
            kept = not (damaged or rest)

            def keep(content: BinaryIO) -> None:
                with replacing(torn) as copy:
                    copy.write(damaged)
                    shutil.copyfileobj(content, copy)
                    copy.flush()
                    os.fsync(copy.fileno())  # on disk before anything is overwritten

            file.seek(end)
            spare = BytesIO(file.read()) if short else None
            if not kept:
                try:
                    file.seek(end)
                    keep(file)
                    kept = True
                except OutputError:
                    if not short:
                        raise
            for place, content in ((0, form.description), (end, data)):
                file.seek(place)
                file.write(content)
            file.truncate()
    except OSError as error:
        raise unwritable(log, error) from error
    if not kept and spare is not None:  # space may be available now
        try:
            keep(spare)
        except OutputError:
            return None, len(damaged) + rest
    return torn if damaged or rest else None, 0


def _completed(found: Scan) -> tuple[int, bytes]:
    """Return the start of the bytes to be written, and the bytes."""
    form, rows = found.form, found.rows
    chunks, end, pieces, sample = list(found.chunks), found.end, [], 0
    n, first = found.tail, (len(rows) - found.tail) * form.every
    if not n:  # repeat the last block, whose index may be incomplete, and everything after it
        last = max((i for i, chunk in enumerate(chunks) if chunk.group == 0), default=-1)
        if last >= 0:
            n, first, end = chunks[last].n, chunks[last].first, chunks[last].start
        chunks = chunks[: max(last, 0)]
    if n:
        pieces.append(Piece(0, first, n, form.block(rows[len(rows) - n :], first)))
        sample = first + (n - 1) * form.every
        if sample % form.every == 0:  # a last row off the grid follows the pictures and has none
            begin = (len(rows) - 1) // PICTURE_ROWS * PICTURE_ROWS  # all earlier pictures exist
            pieces += form.pictures(rows[begin:], begin * form.every)
    data = b""
    for piece in pieces:
        stored, written = form.stored(piece, end + len(data))
        data += b"".join(stored)
        chunks.append(written)
    return end, data + form.ending(chunks, sample, end + len(data))


def _block_size(form: LogFormat) -> int:
    template = form.templates[0]
    return template.chunk_length(BLOCK) + len(template.group.topics) * template.index_length(BLOCK)


def _unused(log: Path) -> Path:
    """Return an unused name for the file of the overwritten bytes."""
    names = itertools.chain([f"{log.name}.torn"], (f"{log.name}.torn-{number}" for number in itertools.count(2)))
    return next(path for path in map(log.with_name, names) if not path.exists())


def _never_began(folder: Path) -> bool:
    """Return True if a run was killed before its log had a complete description."""
    known = run_json.read(folder)
    if known is None or known.get("status") != "running":
        return False
    log = folder / LOG_NAME
    if not log.exists():
        return True
    try:
        text = (folder / SCENARIO_NAME).read_text(encoding="utf-8")
        header = Header.from_dict({**known["header"], "scenario_yaml": text})
        begun = [LogFormat(header, version=version).description for version in FORMATS]
        with log.open("rb") as file:
            found = file.read(max(map(len, begun)))
    except (OSError, KeyError, TypeError, ValueError):
        return False  # unknown; the reader reports defects of the log
    return any(len(found) < len(description) and description.startswith(found) for description in begun)


def _interrupt_unbegun(folder: Path, reserved: Reserved | None) -> RepairReport:
    log = folder / LOG_NAME
    known = run_json.read(folder) or {}
    status = {"status": "interrupted"}
    message = {"message": "killed before the first sample"}
    _write(folder, reserved, known | status | message | {"summary": {**known.get("summary", {}), **status}})
    with contextlib.suppress(OSError):
        log.unlink()  # part of a description, whose content is in run.json and scenario.yaml
    return RepairReport(log, 0, None, None, 0, True)


def _interrupt(folder: Path, found: Scan, reserved: Reserved | None) -> bool:
    known = run_json.read(folder)
    if known is None:
        return False
    if known["status"] != "running":
        if found.problem is not None:  # the rows have changed
            bound = {"log": asdict(run_json.log_of(found.header, found.rows))}
            _write(folder, reserved, known | bound)
        return False
    run = Run(
        amended(found.header, known), found.rows, "interrupted", f"killed while it ran; {len(found.rows)} rows kept"
    )
    kept = ("argv", "started", "finished", "events", "timings", "unused")
    _write(folder, reserved, run_json.describe(run) | {key: known[key] for key in kept if key in known})
    return True


def _write(folder: Path, reserved: Reserved | None, content: dict[str, Any]) -> None:
    """Write run.json, into the reserved space if there is any."""
    (reserved or Reserved(folder / run_json.NAME, 0)).write(run_json.encode(content))
