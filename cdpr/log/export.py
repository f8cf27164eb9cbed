"""Export of runs: CSV, NumPy, MATLAB, Parquet."""

from __future__ import annotations

import importlib
import json
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from cdpr.base.errors import OutputError, PluginError
from cdpr.log.csv_lines import csv_lines
from cdpr.log.files import NAME_OR_FORCE_IN_PYTHON, make_folder, replacing, require_new
from cdpr.log.header import Header
from cdpr.log.run import Run
from cdpr.model.robot import Array

PIECE = 16_384  # rows in memory at a time
MAT_LIMIT = 2**31  # B, limit of a variable in a MATLAB file of version 5


def export(run: Run, to: str, out: Path, force: bool = False, remedy: str = NAME_OR_FORCE_IN_PYTHON) -> None:
    """Write a run to a file; missing folders are created.

    Args:
        run: the run.
        to: format, a key of `EXPORTS`. "csv" and "parquet" have one column per column of the rows, named with its unit;
            "npz" and "mat" have one array per field, named as in `Run`, and the run's header as JSON.
        out: the file.
        force: replace an existing file.
        remedy: remedy in the message about an existing file.

    Raises:
        OutputError: if the file exists without `force`, or cannot be written.
        PluginError: if a required package is not installed.
    """
    write = EXPORTS[to]
    require_new(out, force, remedy)
    make_folder(out.parent)
    with replacing(out, force) as file:
        write(run, file)


def column_names(header: Header) -> list[str]:
    """Return the names of a row's columns with units; the time is `t`."""
    return [name for column in header.layout.fields.values() for name in column.headings(header.cables)]


def _pieces(run: Run) -> Iterator[Array]:
    """Yield all rows in pieces: the rows of a long run are on disk."""
    for first in range(0, len(run.rows), PIECE):
        yield run.rows[first : first + PIECE]


def _csv(run: Run, file: BinaryIO) -> None:
    file.write((",".join(map(_quoted, column_names(run.header))) + "\n").encode())
    for piece in _pieces(run):
        file.write(csv_lines(piece))


def _quoted(name: str) -> str:
    return '"' + name.replace('"', '""') + '"' if any(mark in name for mark in ',"\n\r') else name


def _npz(run: Run, file: BinaryIO) -> None:
    """Write an archive as numpy.savez does, but each field in pieces."""
    with zipfile.ZipFile(file, "w", allowZip64=True) as archive:
        for name, value in _fields(run).items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                if isinstance(value, _Field):
                    described = {"descr": "<f8", "fortran_order": False, "shape": value.shape}
                    np.lib.format.write_array_header_1_0(member, described)
                    for piece in value.pieces():
                        member.write(piece.tobytes())
                else:
                    np.lib.format.write_array(member, np.asarray(value), allow_pickle=False)


def _mat(run: Run, file: BinaryIO) -> None:
    size = 8 * run.header.layout.width * len(run.rows)
    if size > MAT_LIMIT:
        raise OutputError(
            f"{size / 2**30:.3g} GiB of samples do not fit into a MATLAB file of version 5, whose limit is "
            f"{MAT_LIMIT / 2**30:g} GiB: export as parquet or csv, or thin the log by log.step"
        )
    fields = _fields(run)
    fields["cables"] = np.array(fields["cables"], dtype=object)  # cell array of names
    _module("scipy.io", "scipy").savemat(file, {"run": fields}, oned_as="column")


def _parquet(run: Run, file: BinaryIO) -> None:
    arrow, parquet = _module("pyarrow", "pyarrow"), _module("pyarrow.parquet", "pyarrow")
    columns = [(name, arrow.float64()) for name in column_names(run.header)]
    schema = arrow.schema(columns, metadata={"cdpr": json.dumps(run.header.to_dict())})
    with parquet.ParquetWriter(file, schema) as writer:
        for piece in _pieces(run):
            writer.write_table(arrow.Table.from_arrays([arrow.array(column) for column in piece.T], schema=schema))


def to_pandas(run: Run) -> Any:
    """Return the rows as a DataFrame with the time as index.

    Raises:
        PluginError: if pandas is not installed.
    """
    pandas = _module("pandas", "pandas")
    time, *names = column_names(run.header)
    rows = np.asarray(run.rows[:])
    return pandas.DataFrame(rows[:, 1:].copy(), columns=names, index=pandas.Index(rows[:, 0].copy(), name=time))


EXPORTS: dict[str, Callable[[Run, BinaryIO], None]] = {
    "csv": _csv,
    "npz": _npz,
    "mat": _mat,
    "parquet": _parquet,
}


@dataclass(frozen=True)
class _Field:
    """Field of a run that becomes an array only when it is written."""

    run: Run
    name: str

    @property
    def shape(self) -> tuple[int, ...]:
        return (len(self.run.rows), *self.run.part(0, 0)[self.name].shape[1:])

    def pieces(self) -> Iterator[Array]:
        """Yield its rows in pieces."""
        for first in range(0, len(self.run.rows), PIECE):
            yield self.run.part(first, first + PIECE)[self.name]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return self.run[self.name]


def _fields(run: Run) -> dict[str, Any]:
    fields: dict[str, Any] = {name: _Field(run, name) for name in run.header.layout.fields}
    fields["solver_status"] = fields.pop("status")
    known = {"header": json.dumps(run.header.to_dict()), "cables": list(run.header.cables)}
    return fields | known | {"status": run.status, "message": run.message}


def _module(name: str, package: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError as error:
        text = f"this needs {package}, which is not installed: pip install 'cdpr[data]'"
        raise PluginError(text) from error
