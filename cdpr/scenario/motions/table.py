"""Motion as CSV file: the first line has the column names, each further line a point in time."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from cdpr.base import tolerances
from cdpr.base.fields import MAX_DISTANCE, MAX_MAGNITUDE
from cdpr.base.files import MAX_FAULTS, ContentError, text_of
from cdpr.base.nearest import did_you_mean
from cdpr.base.problems import shown
from cdpr.config.problems import exact
from cdpr.model.frozen import Frozen
from cdpr.model.robot import Array

MAX_ROWS = 100_000
MAX_BYTES = 32 * 1024 * 1024

# Groups of columns. Units: t s, position m, rates m/s, rad/s, m/s^2, world axes; quaternion w, x, y, z.
GROUPS = {
    "time": ("t",),
    "position": ("x", "y", "z"),
    "orientation": ("qw", "qx", "qy", "qz"),
    "velocity": ("vx", "vy", "vz"),
    "angular_velocity": ("wx", "wy", "wz"),
    "acceleration": ("ax", "ay", "az"),
}
COLUMNS = tuple(name for names in GROUPS.values() for name in names)
REQUIRED = (*GROUPS["time"], *GROUPS["position"])


@dataclass(frozen=True, eq=False)
class Table(Frozen):
    """Content of a file with K points.

    Attributes:
        columns: arrays (K, n) by name in GROUPS; groups that are not in the file are missing.
        lines: (K,), line of each point, starting at 1.
        sha256: checksum of the file.
    """

    columns: dict[str, Array]
    lines: list[int] = field(repr=False)
    sha256: str

    @property
    def times(self) -> Array:
        """Times of the points, (K,), s."""
        return self.columns["time"][:, 0]

    def get(self, name: str) -> Array | None:
        """Return a group of columns; None if it is not in the file."""
        return self.columns.get(name)


@lru_cache(maxsize=4)  # cases of a study use the same file
def parse_table(content: bytes) -> Table:
    """Return the table in a file's content; raise ContentError if it is invalid."""
    text = text_of(content, MAX_BYTES)
    rows: list[list[float]] = []
    lines: list[int] = []
    faults: list[tuple[int, int, str]] = []
    names: list[str] = []
    limits: list[float] = []
    for number, row_text in enumerate(text.split("\n"), 1):
        if not row_text.strip() or row_text.lstrip().startswith("#"):
            continue
        if not names:
            names = _header(number, row_text)
            limits = [_limit(name) for name in names]
            continue
        try:
            row = [float(cell) for cell in row_text.split(",")]
        except ValueError:
            row = []
        # Only Python accepts 1_000. The comparison is False for NaN.
        moderate = "_" not in row_text and all(abs(value) <= limit for value, limit in zip(row, limits, strict=False))
        if not moderate or len(row) != len(names):
            faults += _row_faults(number, row_text, names)
        rows.append(row)
        lines.append(number)
        if len(faults) >= MAX_FAULTS or len(rows) > MAX_ROWS:
            break
    if len(rows) > MAX_ROWS:
        faults.append((lines[-1], 0, f"{MAX_ROWS} points at most are allowed"))
    if not names:
        faults.append((1, 0, f"the first line must name the columns: {','.join(REQUIRED)} and if wanted more"))
    elif len(rows) < 2:
        faults.append((lines[-1] if lines else 1, 0, f"expected two or more points, got {len(rows)}"))
    if faults:
        raise ContentError(faults[:MAX_FAULTS])
    data = np.array(rows)
    columns = {
        group: data[:, [names.index(name) for name in members]]
        for group, members in GROUPS.items()
        if members[0] in names
    }
    _check(columns, lines)
    for column in columns.values():
        column.flags.writeable = False
    return Table(columns, lines, hashlib.sha256(content).hexdigest())


def _limit(name: str) -> float:
    return MAX_DISTANCE if name in GROUPS["position"] else MAX_MAGNITUDE


def _header(number: int, line: str) -> list[str]:
    names = [cell.strip() for cell in line.split(",")]
    faults = []
    for k, name in enumerate(names):
        where = (number, _column(line, k))
        if name not in COLUMNS:
            hint = "columns are separated by commas; " if len(names) == 1 else did_you_mean(name, COLUMNS)
            faults.append((*where, f"unknown column {shown(name)}: {hint}allowed: {', '.join(COLUMNS)}"))
        elif name in names[:k]:
            faults.append((*where, f"column '{name}' occurs twice"))
    if not faults:
        for members in GROUPS.values():
            missing = [name for name in members if name not in names]
            if missing and (len(missing) < len(members) or members[0] in REQUIRED):
                together = f"; {', '.join(members)} go together" if len(members) > 1 else ""
                faults.append((number, 0, f"missing column {', '.join(missing)}{together}"))
    if faults:
        raise ContentError(faults)
    return names


def _row_faults(number: int, line: str, names: list[str]) -> list[tuple[int, int, str]]:
    cells = line.split(",")
    if len(cells) != len(names):
        return [(number, 0, f"expected {len(names)} numbers ({', '.join(names)}), got {len(cells)}")]
    faults = []
    for k, (name, cell) in enumerate(zip(names, cells, strict=True)):
        try:
            value = float(cell.replace("_", "?"))
        except ValueError:
            faults.append((number, _column(line, k), f"{name}: expected a number, got {shown(cell.strip())}"))
            continue
        if not math.isfinite(value):
            faults.append((number, _column(line, k), f"{name}: expected a finite number, got {value}"))
        elif abs(value) > (limit := _limit(name)):
            text = f"{name}: must lie between -{limit:g} and {limit:g}, got {exact(value)}"
            faults.append((number, _column(line, k), text))
    return faults


def _column(line: str, k: int) -> int:
    """Return the column, starting at 1, of the first character of the k-th cell."""
    cells = line.split(",")
    return sum(len(cell) + 1 for cell in cells[:k]) + len(cells[k]) - len(cells[k].lstrip()) + 1


def _check(columns: dict[str, Array], lines: list[int]) -> None:
    """Check that times increase and quaternions have unit norm; normalise the latter."""
    times = columns["time"][:, 0]
    faults = []
    if times[0] < 0.0:
        faults.append((lines[0], 0, f"t: must be at least 0 (s), got {exact(times[0])}"))
    for k in np.flatnonzero(np.diff(times) <= 0.0)[:MAX_FAULTS]:
        text = f"t: must be greater than the previous point's, {times[k]:.12g} (s), got {times[k + 1]:.12g}"
        faults.append((lines[k + 1], 0, text))
    if "orientation" in columns:
        norms = np.linalg.norm(columns["orientation"], axis=1)
        for k in np.flatnonzero(np.abs(norms - 1.0) > tolerances.UNIT)[:MAX_FAULTS]:
            faults.append((lines[k], 0, f"qw, qx, qy, qz: expected a quaternion of norm 1, got norm {norms[k]:.6g}"))
        if not faults:
            columns["orientation"] = columns["orientation"] / norms[:, None]
    if faults:
        raise ContentError(sorted(faults)[:MAX_FAULTS])
