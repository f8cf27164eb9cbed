"""Headers, rows and files that the tests of cdpr.log share."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cdpr.log.header import Header
from cdpr.log.writer import LogWriter
from cdpr.model.robot import Array

BOX = {"box": [0.4, 0.3, 0.2]}


def make_header(m: int = 8, **changes: Any) -> Header:
    """A header for m cables, one of them with a name beyond ASCII."""
    names = ("Seil α", *(f"cable_{i}" for i in range(2, m + 1)))[:m]
    header = Header(
        scenario="test",
        robot="robot",
        backend="reference",
        controller="pd",
        solver="qp",
        control_step=0.001,
        physics_step=0.0005,
        seed=3,
        gravity=(0.0, 0.0, -9.81),
        mass=12.5,
        cables=names,
        anchors=tuple(tuple(0.25 * ((7 * i + j) % 13) - 1.5 for j in range(6)) for i in range(m)),
        tension_min=(1.0,) * m,
        tension_max=(100.0,) * m,
        characteristic_length=0.5,
        shape=BOX,
        versions={"cdpr": "0.1.0", "python": "3.11"},
        scenario_yaml="name: test  # Prüfung\n",
    )
    return replace(header, **changes)


def make_rows(header: Header, k: int, seed: int = 0) -> Array:
    """k rows of random numbers of all sizes; the time is what the loop would write."""
    rng = np.random.default_rng(seed)
    width = header.layout.width
    rows = rng.standard_normal((k, width)) * 10.0 ** rng.integers(-6, 6, (k, width))
    columns = header.layout.columns
    for name in ("orientation", "desired_orientation"):
        rows[:, columns[name]] /= np.linalg.norm(rows[:, columns[name]], axis=1, keepdims=True)
    rows[:, columns["tension"]] = rng.uniform(-20.0, 120.0, (k, len(header.cables)))
    rows[:, columns["status"]] = rng.integers(0, 5, (k, 1))
    rows[:, 0] = [i * header.control_step for i in range(k)]
    return rows


def plain_rows(header: Header, k: int) -> Array:
    """k rows of short binary fractions of a platform that does not turn: the same pictures on any machine."""
    width, columns = header.layout.width, header.layout.columns
    rows = (np.arange(float(k) * width).reshape(k, width) % 64) / 8
    for name in ("orientation", "desired_orientation"):
        rows[:, columns[name]] = (1.0, 0.0, 0.0, 0.0)
    rows[:, 0] = np.arange(k) * header.control_step
    return rows


def write_log(path: Path, header: Header, rows: Array) -> Path:
    """A complete log of `rows`."""
    LogWriter(path, header).close(rows, len(rows))
    return path


def same_bits(a: Array, b: Array) -> bool:
    """Return True if two arrays are equal to the last bit, NaN and -0.0 included."""
    return a.shape == b.shape and a.tobytes() == b.tobytes()
