"""Import of other programs' files: they are read in a separate process, previewed, and written on request.

The files are on the machine that runs `cdpr gui`, or they are uploaded by a browser into a temporary folder.
"""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from threading import Lock
from typing import Any
from weakref import WeakKeyDictionary

from cdpr.analysis.jobs.forks import Surroundings
from cdpr.base import processes
from cdpr.base.errors import CdprError
from cdpr.base.problems import shown
from cdpr.formats.read.gazebo import is_motion
from cdpr.formats.read.import_files import ENDINGS, ImportResult, write
from cdpr.formats.read.limits import WALL
from cdpr.log.files import unwritable
from cdpr.ui.gui.broadcast import Reader
from cdpr.ui.gui.choices import in_window
from cdpr.ui.gui.editor.files import named
from cdpr.ui.gui.scratch import scratch
from cdpr.ui.gui.server import Words

MOST_FILES = 100  # in one upload
MOST_NAME = 255  # bytes of a file name, as on most file systems
MOST_SHOWN = 2**20  # characters of converted files that are sent to a window
MOST_LINES = 200  # of omitted items that are sent to a window, per source
SECONDS = 60.0  # default time limit of reading
MOST_SECONDS = 3600.0  # largest CPU time that a user may set


class Incoming:
    """Last import of each window, which it may write."""

    def __init__(self) -> None:
        self._read: WeakKeyDictionary[Reader, list[ImportResult]] = WeakKeyDictionary()
        self._lock = Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._reader: Reader | None = None  # window of the running import
        self._given_up = False
        self._closed = False

    def read(
        self,
        reader: Reader,
        path: str = "",
        files: Any = (),
        body: bytes = b"",
        cable_set: str = "",
        trajectory: str = "",
        tension: Any = None,
        seconds: Any = None,
    ) -> list[Words]:
        """Read robots of another program, and return the message that previews them.

        Args:
            reader: the window.
            path: a file or folder on this machine, if no files are uploaded.
            files: name and size of each uploaded file.
            body: contents of the uploaded files, concatenated.
            cable_set: cable set of a CASPR model; defaults to that of the model.
            trajectory: trajectory of a robot of the Gazebo plug-in: an uploaded file or a path.
            tension: lowest and highest tension, N, for files without limits.
            seconds: limit of CPU time for reading a file; defaults to the importer's.

        Raises:
            CdprError: if nothing can be read.
        """
        self._read.pop(reader, None)
        given: dict[str, Any] = {"cable_set": cable_set, "trajectory": trajectory}
        given = {key: value for key, value in given.items() if value}
        for key, value in given.items():
            if not isinstance(value, str):
                raise CdprError(f"{key}: expected a name, got {shown(value)}")
        given |= _numbers(tension, seconds)
        if files:
            every = self._uploaded(reader, _received(files, body), given)
        elif path:
            every = self._apart(reader, {"path": named(path), **given})
        else:
            raise CdprError("choose files, or enter a path")
        if len(every) == 1 and every[0].error:
            raise CdprError(every[0].error)
        self._read[reader] = every
        return [_message(every)]

    def write(self, reader: Reader, out: str = "", open: str = "") -> tuple[list[str], str]:
        """Write the last import of a window; return the written files, and the one to open.

        Args:
            reader: the window.
            out: output folder, created if necessary; defaults to the working folder.
            open: name of the robot or scenario to open.

        Raises:
            CdprError: if nothing was imported or `open` is not part of it.
            OutputError: if a file exists or cannot be written; then nothing is written.
        """
        every = self._read.get(reader, [])
        merged = ImportResult("", {name: text for each in every for name, text in each.files.items()})
        if not merged.files:
            raise CdprError("no imported data to write: import the file again")
        if open not in list(merged.files):
            raise CdprError(f"open: expected one of {', '.join(merged.files)}, got {shown(open)}")
        folder = Path(named(out) if out else ".")
        written = [str(path) for path in write(merged, folder, force=False)]
        self._read.pop(reader, None)
        return written, str(folder / open)

    def give_up(self, reader: Reader) -> None:
        """Abort a window's running import, if there is one."""
        with self._lock:
            if self._process is not None and self._reader is reader:
                self._given_up = True
                self._process.kill()

    def close(self) -> None:
        """Abort the running import, and reject further ones."""
        with self._lock:
            self._closed = self._given_up = True
            if self._process is not None:
                self._process.kill()

    def _uploaded(self, reader: Reader, files: Mapping[str, bytes], given: dict[str, Any]) -> list[ImportResult]:
        """Read uploaded files, isolated from all other files."""
        if len(files) == 2 and len(motions := [name for name in files if is_motion(files[name])]) == 1:
            given = {"trajectory": motions[0], **given}  # it belongs to the other file
        trajectory = given.get("trajectory")
        if trajectory is not None and trajectory not in files:
            raise CdprError(f"trajectory: {shown(trajectory)} is not among the files: choose it, too")
        robots = [name for name in files if name != trajectory]
        if not robots:
            raise CdprError("trajectory: expected a robot with the trajectory: choose the robot's file, too")
        if len(robots) > 1 and trajectory is not None:
            raise CdprError("trajectory: expected the files of one robot and one trajectory")
        if len(robots) > 1 and not any(name.lower().endswith(ENDINGS) for name in robots):
            raise CdprError(f"none of these files has a supported format: {', '.join(ENDINGS)}")
        with scratch() as temporary:
            folder = Path(temporary.path)
            for name, content in files.items():
                try:
                    (folder / name).write_bytes(content)  # no temporary file: nobody reads it yet
                except OSError as error:
                    raise unwritable(Path(name), error) from error
            return self._apart(reader, {"path": robots[0] if len(robots) == 1 else ".", **given}, folder)

    def _apart(self, reader: Reader, request: dict[str, Any], folder: Path | None = None) -> list[ImportResult]:
        """Read in a separate process; its working folder defaults to ours."""
        process = self._begin(reader, folder)
        longest = max(SECONDS, WALL * request.get("seconds", 0.0))
        with process:
            try:
                out, _ = process.communicate(json.dumps(request).encode(), longest)
            except subprocess.TimeoutExpired:
                process.kill()
                text = f"reading it takes more than {longest:g} s, and was stopped"
                raise CdprError(f"{request['path']}: {text}") from None
            finally:
                with self._lock:
                    self._process = None
        if self._given_up:
            raise CdprError(f"{request['path']}: reading it was stopped")
        if process.returncode:
            how = processes.ended(process.returncode)
            raise CdprError(f"{request['path']}: the process that reads it {how}; nothing was imported")
        answer = json.loads(out)
        if "fault" in answer:
            fault = RuntimeError(answer["fault"])
            fault.add_note(answer["trace"])
            raise fault
        if "error" in answer:
            raise CdprError(answer["error"])
        return [ImportResult(**each) for each in answer["taken"]]

    def _begin(self, reader: Reader, folder: Path | None) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-P", "-m", "cdpr.ui.gui.reading", str(os.getpid())]
        with self._lock:
            if self._closed:
                raise CdprError("the window is being closed")
            self._reader, self._given_up = reader, False
            self._process = processes.start(
                lambda: subprocess.Popen(
                    command,
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=subprocess.DEVNULL,
                    cwd=folder,
                    env=Surroundings.ours().environment,
                    start_new_session=True,  # Ctrl-C is handled by this process
                )
            )
            return self._process


def _numbers(tension: Any, seconds: Any) -> dict[str, Any]:
    """Return the numeric arguments that were given."""
    given: dict[str, Any] = {}
    if tension is not None:
        if not (isinstance(tension, list) and len(tension) == 2 and all(map(_is_finite, tension))):
            raise CdprError("tension: expected two numbers, the lowest and the highest tension (N)")
        given["tension"] = tension
    if seconds is not None:
        if not (_is_finite(seconds) and 0.0 < seconds <= MOST_SECONDS):
            raise CdprError(f"seconds: expected a number above 0 and up to {MOST_SECONDS:g}, got {shown(seconds)}")
        given["seconds"] = seconds
    return given


def _is_finite(value: Any) -> bool:
    return type(value) in (int, float) and math.isfinite(value)


def _received(files: Any, body: bytes) -> dict[str, bytes]:
    """Return uploaded files by name.

    Raises:
        CdprError: if a name contains folders or sizes do not match.
    """
    if not isinstance(files, list) or len(files) > MOST_FILES:
        raise CdprError(f"files: expected at most {MOST_FILES} files, each with its name and size")
    found: dict[str, bytes] = {}
    start = 0
    for each in files:
        name, size = (each.get("name"), each.get("size")) if isinstance(each, dict) else (None, None)
        if not isinstance(name, str) or not _is_plain(name):
            text = f"file name: expected a name without folders, of at most {MOST_NAME} bytes"
            raise CdprError(f"{text}, got {shown(name)}: rename it")
        if name in found:
            raise CdprError(f"two files are named {shown(name)}: rename one, or import them one by one")
        if type(size) is not int or not 0 <= size <= len(body) - start:
            raise CdprError(f"{name}: the received size differs from the announced one")
        found[name] = body[start : start + size]
        start += size
    if start != len(body):
        raise CdprError("received more data than announced")
    return found


def _is_plain(name: str) -> bool:
    return (
        name.isprintable()
        and name not in ("", ".", "..")
        and not set(name) & {"/", "\\"}
        and len(name.encode()) <= MOST_NAME
    )


def _message(every: list[ImportResult]) -> Words:
    """Return the preview message, with texts of files up to a limit."""
    left = MOST_SHOWN
    sources = []
    for each in every:
        files: list[dict[str, Any]] = []
        for name, text in each.files.items():
            fits = len(text) <= left
            left -= len(text) if fits else 0
            files.append({"name": name, "size": len(text), "text": text if fits else None})
        lists = {"left_out": _first(each.left_out), "warnings": _first(each.warnings)}
        sources.append({**vars(each), **lists, "error": in_window(each.error), "files": files})
    return {"kind": "imported", "sources": sources}


def _first(lines: list[str]) -> list[str]:
    more = len(lines) - MOST_LINES
    return lines if more <= 0 else [*lines[:MOST_LINES], f"and {more} more"]
