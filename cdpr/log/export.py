"""Writes a run as a file for other programs: CSV, NumPy, MATLAB, Parquet."""

from __future__ import annotations

import importlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from cdpr.errors import OutputError, PluginError
from cdpr.log.files import replacing
from cdpr.log.layout import FIELDS
from cdpr.log.run import Header, Run

# Where a column stands for one component or one cable of a field, {} is its name.
_COLUMNS = {
    "time": "t",
    "position": "position_{}_m",
    "orientation": "orientation_{}",
    "velocity": "velocity_{}_m_per_s",
    "angular_velocity": "angular_velocity_{}_rad_per_s",
    "desired_position": "desired_position_{}_m",
    "desired_orientation": "desired_orientation_{}",
    "desired_velocity": "desired_velocity_{}_m_per_s",
    "desired_angular_velocity": "desired_angular_velocity_{}_rad_per_s",
    "desired_acceleration": "desired_acceleration_{}_m_per_s2",
    "desired_angular_acceleration": "desired_angular_acceleration_{}_rad_per_s2",
    "tension": "tension_{}_N",
    "length": "length_{}_m",
    "rate": "rate_{}_m_per_s",
    "status": "status",
    "residual": "residual_N",
    "margin": "margin_N",
    "at_limit": "at_limit",
    "kinetic": "kinetic_J",
    "potential": "potential_J",
    "cable_work": "cable_work_J",
    "external_work": "external_work_J",
}
_WRENCH = [f"{{}}_force_{axis}_N" for axis in "xyz"] + [f"{{}}_moment_{axis}_Nm" for axis in "xyz"]


def export(run: Run, to: str, out: Path, force: bool = False) -> None:
    """Write `run` to the file `out`.

    `to` is one of `EXPORTS`: "csv" and "parquet" have one column for each column of the rows, named with its
    unit; "npz" and "mat" one array for each field, named as in `Run`, beside the run's header as JSON.

    Raises:
        OutputError: the file exists and not `force`, or it cannot be written.
        PluginError: a package that this needs is not installed.
    """
    write = EXPORTS[to]
    if out.exists() and not out.is_file():
        raise OutputError(f"{out}: is no regular file; choose another --out")
    if out.exists() and not force:
        raise OutputError(f"{out}: exists; choose another --out or give --force")
    with replacing(out) as file:
        write(run, file)


def column_names(header: Header) -> list[str]:
    """Return the names of a row's columns, with their units; the time is `t`."""
    names: list[str] = []
    for field, width in FIELDS:
        parts = header.cables if width == 0 else tuple("wxyz" if width == 4 else "xyz"[:width])
        if width == 6:
            names += [name.format(field) for name in _WRENCH]
        else:
            names += [_COLUMNS[field].format(part) for part in parts]
    return names


def _csv(run: Run, file: BinaryIO) -> None:
    file.write((",".join(map(_quoted, column_names(run.header))) + "\n").encode())
    for first in range(0, len(run.rows), 1024):
        lines = [",".join(map(repr, row)) + "\n" for row in run.rows[first : first + 1024].tolist()]
        file.write("".join(lines).encode())


def _quoted(name: str) -> str:
    return '"' + name.replace('"', '""') + '"' if any(mark in name for mark in ',"\n\r') else name


def _npz(run: Run, file: BinaryIO) -> None:
    arrays: dict[str, Any] = {name: np.asarray(value) for name, value in _fields(run).items()}
    np.savez(file, **arrays)


def _mat(run: Run, file: BinaryIO) -> None:
    fields = _fields(run)
    fields["cables"] = np.array(fields["cables"], dtype=object)  # a cell array of names
    _module("scipy.io", "scipy").savemat(file, {"run": fields}, oned_as="column")


def _parquet(run: Run, file: BinaryIO) -> None:
    arrow, parquet = _module("pyarrow", "pyarrow"), _module("pyarrow.parquet", "pyarrow")
    columns = [arrow.array(column) for column in run.rows.T]
    table = arrow.Table.from_arrays(columns, names=column_names(run.header))
    parquet.write_table(table.replace_schema_metadata({"cdpr": json.dumps(run.header.to_dict())}), file)


EXPORTS: dict[str, Callable[[Run, BinaryIO], None]] = {
    "csv": _csv,
    "npz": _npz,
    "mat": _mat,
    "parquet": _parquet,
}


def _fields(run: Run) -> dict[str, Any]:
    fields: dict[str, Any] = {name: run[name] for name, _ in FIELDS}
    fields["solver_status"] = fields.pop("status")
    known = {"header": json.dumps(run.header.to_dict()), "cables": list(run.header.cables)}
    return fields | known | {"status": run.status, "message": run.message}


def _module(name: str, package: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError as error:
        text = f"this format needs {package}, which is not installed: pip install 'cdpr[data]'"
        raise PluginError(text) from error
