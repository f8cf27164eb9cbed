"""Storage of the rows of a rollout: in memory, or as `rows.npy` in its folder, with a checksum for each case."""

from __future__ import annotations

import contextlib
import errno
import io
import os
import warnings
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from cdpr.analysis.jobs.cases import Outcome
from cdpr.analysis.jobs.folder import RESULTS, JobFolder
from cdpr.base.checksums import checksum
from cdpr.base.errors import OutputError
from cdpr.log.files import unwritable
from cdpr.model.robot import Array

ROWS_NAME = "rows.npy"
SUM = "rows_sha256"  # in the summary of a case in the ledger
THINNER = "set a larger every= or fewer columns="
NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
NAMED = 8  # damaged cases listed in a warning

Shape = tuple[int, int, int]


class RowsInMemory:
    """Rows (n, K, W) in memory, initially NaN.

    Attributes:
        ended: outcomes of the ended cases, by key.
    """

    def __init__(self, shape: Shape) -> None:
        self.ended: dict[str, Outcome] = {}
        self._rows = np.full(shape, np.nan)

    def keep(self, outcome: Outcome, row: Array) -> None:
        """Store a case with its rows (K, W)."""
        self._rows[int(outcome.key)] = row
        self.ended[outcome.key] = outcome

    def rows(self) -> Array:
        """Return all rows, (n, K, W)."""
        return self._rows

    def close(self) -> None:
        """Do nothing."""


class RowsInFolder:
    """Rows (n, K, W) in the folder of a rollout.

    The whole file is allocated first and written by calls that report a full disk; a write to mapped memory would end
    the process instead.

    Attributes:
        ended: outcomes of the ended cases with intact rows, by key.
    """

    def __init__(self, folder: JobFolder, shape: Shape) -> None:
        """Open the file, or create it.

        Raises:
            OutputError: if it cannot be written or the disk is too small.
        """
        self._folder, self._shape = folder, shape
        self._path = folder.path / ROWS_NAME
        header = io.BytesIO()
        described = {"descr": "<f8", "fortran_order": False, "shape": shape}
        np.lib.format.write_array_header_1_0(header, described)
        self._header = header.getvalue()
        self._size = 8 * shape[1] * shape[2]  # bytes of a case
        new = not self._path.exists()
        try:
            self._file = os.open(self._path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
        except OSError as error:
            raise unwritable(self._path, error) from error
        try:
            self._allocate()
            self.ended = self._intact(folder.rows)
        except BaseException:
            self.close()
            if new:
                with contextlib.suppress(OSError):
                    self._path.unlink()
            raise

    def keep(self, outcome: Outcome, row: Array) -> None:
        """Write a case with its rows (K, W), and then its line of the ledger.

        Raises:
            OutputError: if the files cannot be written.
        """
        content = np.ascontiguousarray(row, dtype="<f8").tobytes()
        self._write(content, self._place(outcome.key))
        summary = {**outcome.summary, SUM: checksum(content)}
        self._folder.record(replace(outcome, summary=summary))
        self.ended[outcome.key] = outcome

    def rows(self) -> Array:
        """Return all rows, (n, K, W), mapped from the file and read-only."""
        return np.memmap(self._path, np.float64, "r", len(self._header), self._shape)

    def close(self) -> None:
        """Close the file."""
        os.close(self._file)

    def _allocate(self) -> None:
        whole = len(self._header) + self._shape[0] * self._size
        try:
            os.ftruncate(self._file, min(whole, os.fstat(self._file).st_size))
            os.posix_fallocate(self._file, 0, whole)
        except OSError as error:
            if error.errno in NO_ROOM:
                need = f"the rows need {whole / 2**30:.3g} GiB, more than its disk has"
                raise OutputError(f"{self._path}: {need}: {THINNER}") from error
            if error.errno not in (errno.EINVAL, errno.EOPNOTSUPP):  # not supported by some file systems
                raise unwritable(self._path, error) from error
        self._write(self._header, 0)

    def _write(self, content: bytes, place: int) -> None:
        done = 0
        try:
            while done < len(content):
                done += os.pwrite(self._file, content[done:], place + done)
        except OSError as error:
            raise unwritable(self._path, error) from error

    def _place(self, key: str) -> int:
        return len(self._header) + int(key) * self._size

    def _intact(self, ledger: Mapping[str, Outcome]) -> dict[str, Outcome]:
        """Return the intact cases; warn of damaged ones."""
        intact, damaged = {}, []
        for key, row in ledger.items():
            if row.status not in RESULTS:
                continue
            summary = dict(row.summary)
            try:
                content = os.pread(self._file, self._size, self._place(key))
            except OSError as error:
                raise OutputError(f"{self._path}: cannot be read: {error.strerror or error}") from error
            if summary.pop(SUM, None) == checksum(content):
                intact[key] = replace(row, summary=summary)
            else:
                damaged.append(key)
        if damaged:
            named = ", ".join(damaged[:NAMED]) + (", ..." if len(damaged) > NAMED else "")
            text = f"{len(damaged)} damaged of {len(ledger)} cases; repeating them: {named}"
            warnings.warn(f"{self._path}: {text}", stacklevel=4)
        return intact
