"""A workspace: what was found at each cell of a box, how large it is, and its file."""

from __future__ import annotations

import json
import os
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cdpr.distribution import distribute
from cdpr.errors import CdprError, LogError
from cdpr.log.files import unwritable
from cdpr.model import Robot
from cdpr.model.arrays import checked
from cdpr.model.robot import Array
from cdpr.workspace.kinds import WorkspaceKind, kind_of
from cdpr.workspace.measure import Measured, measure
from cdpr.workspace.regions import Region
from cdpr.workspace.required import Required

FORMAT = "cdpr workspace 1"
Over = Literal["all", "any"]

# Share of a value's scale below which its sign is round-off, as `cdpr.workspace.assess` has it.
BOUNDARY = 1e-9


@dataclass(frozen=True, eq=False)
class Workspace:
    """What was found at the middles of the cells of a region.

    Attributes:
        kind: what was asked.
        robot: name of the robot.
        region: where.
        value: (nx, ny, nz), >= 0 inside, `kind.unit`; over several attitudes the least, or the greatest where one is
            enough. NaN where there is none: W lacks rank.
        inside: (nx, ny, nz).
        boundary: (nx, ny, nz), whether round-off decides.
        about: all that it depends on, as plain data: robot file, required set, gravity, versions, ...
    """

    kind: WorkspaceKind
    robot: str
    region: Region
    value: Array
    inside: NDArray[np.bool_]
    boundary: NDArray[np.bool_]
    about: dict[str, Any]

    def __repr__(self) -> str:
        return f"<Workspace {self.kind.name} of {self.robot}: {self.volume:.4g} {self.region.unit}>"

    @property
    def volume(self) -> float:
        """Size of what is inside, m^3, or m^2 or m where the platform moves in a plane or along a line."""
        return float(self.inside.sum()) * self.region.cell

    def summary(self) -> dict[str, Any]:
        """Return the figures of it as plain numbers."""
        here, values = np.argwhere(self.inside), self.value[self.inside]
        region = self.region
        bounds = None
        if len(here):
            size = (region.upper - region.lower) / region.shape
            bounds = [
                (region.lower + here.min(axis=0) * size).tolist(),
                (region.lower + (here.max(axis=0) + 1) * size).tolist(),
            ]
        known = values[np.isfinite(values)]
        return {
            "kind": self.kind.name,
            "robot": self.robot,
            "volume": self.volume,
            "unit": region.unit,
            "share": float(self.inside.mean()),
            "bounds": bounds,
            "value": {"name": self.kind.value, "unit": self.kind.unit, **_spread(known)},
            "cells": list(region.shape),
            "orientations": len(region.orientations),
            "on_boundary": int(self.boundary.sum()),
            "without_value": int(np.isnan(self.value).sum()),
            "box": [region.lower.tolist(), region.upper.tolist()],
        }

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write it as NPZ. Raises OutputError."""
        region, target = self.region, Path(path)
        part = target.with_name(f".{target.name}.part")
        about = {"format": FORMAT, "kind": self.kind.name, "robot": self.robot, **self.about}
        try:
            with part.open("wb") as file:
                np.savez_compressed(
                    file,
                    value=self.value,
                    inside=self.inside,
                    boundary=self.boundary,
                    lower=region.lower,
                    upper=region.upper,
                    orientations=region.orientations,
                    x=region.axes[0],
                    y=region.axes[1],
                    z=region.axes[2],
                    about=np.array(json.dumps(about, sort_keys=True)),
                )
            part.replace(target)
        except OSError as error:
            part.unlink(missing_ok=True)
            raise unwritable(target, error) from error


def load_workspace(path: str | os.PathLike[str]) -> Workspace:
    """Read what `Workspace.save` wrote. Raises LogError where it cannot be read."""
    try:
        with open(path, "rb") as file, np.load(file, allow_pickle=False) as found:
            about = json.loads(str(found["about"]))
            if about.pop("format", None) != FORMAT:
                raise ValueError("another format")
            value, inside, boundary = found["value"], found["inside"], found["boundary"]
            region = Region(found["lower"], found["upper"], value.shape, found["orientations"])
        if value.ndim != 3 or not value.shape == inside.shape == boundary.shape:
            raise ValueError("arrays of different shapes")
        return Workspace(kind_of(about.pop("kind")), about.pop("robot"), region, value, inside, boundary, about)
    except (OSError, ValueError, KeyError, TypeError, CdprError, zipfile.BadZipFile, EOFError) as error:
        raise LogError(f"{os.fspath(path)}: is no workspace that can be read ({error})") from error


def workspace(
    robot: Robot,
    kind: str,
    region: Region,
    *,
    required: Required | None = None,
    gravity: ArrayLike = (0.0, 0.0, -9.81),
    length: float | None = None,
    over: Over = "all",
    jobs: int | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Workspace:
    """Find which cells of a region are inside a workspace.

    Args:
        robot: whose it is.
        kind: "static", "wrench-feasible", "dynamic", "closure" or "payload".
        region: where, and in which attitudes.
        required: the set of wrenches or accelerations that a wrench-feasible, or dynamic, workspace needs: what the
            cables must exert beyond carrying the weight at rest.
        gravity: (3,), m/s^2, world.
        length: by which moments are divided, m; the robot's characteristic length unless given.
        over: whether "all" attitudes of the region must be inside, or "any" of them.
        jobs: threads; the result is the same.
        progress: called with the number of cells that are done, and their total.

    Raises CdprError where an argument makes no sense.
    """
    asked = kind_of(kind)
    wanted = asked.required(required)
    if over not in ("all", "any"):
        raise CdprError(f"over: all or any of the orientations is expected, got {over!r}")
    given = checked(gravity, (3,), "gravity", finite=True)
    value, boundary = np.full(region.cells, np.nan), np.zeros(region.cells, dtype=bool)
    inside = np.full(region.cells, over == "all")
    for first, stop in region.pieces():
        poses = np.empty((stop - first, 7))
        poses[:, :3] = region.positions(first, stop)
        cut = slice(first, stop)
        for k, q in enumerate(region.orientations):
            poses[:, 3:] = q
            found = measure(robot, poses, asked.mode, wanted, gravity=given, length=length, jobs=jobs)
            here = _inside(robot, asked, wanted, found, poses, given)
            close = np.abs(found.value) <= BOUNDARY * found.scale
            better = np.fmin if over == "all" else np.fmax
            value[cut] = found.value if k == 0 else better(value[cut], found.value)
            inside[cut] = inside[cut] & here if over == "all" else inside[cut] | here
            boundary[cut] |= close
        progress(stop, region.cells)
    table = region.shape
    about = {
        "required": wanted.plain(),
        "gravity": given.tolist(),
        "length": robot.characteristic_length if length is None else float(length),
        "over": over,
        "method": "grid",
    }
    return Workspace(
        asked,
        robot.name,
        region,
        value.reshape(table),
        inside.reshape(table),
        boundary.reshape(table),
        about,
    )


def verdicts(found: Workspace, robot: Robot, poses: Array) -> tuple[NDArray[np.bool_], Array, Array]:
    """Ask again as a workspace was, of other poses (K, 7): whether inside, value and scale, each (K,)."""
    wanted, gravity = Required.from_plain(found.about["required"]), np.array(found.about["gravity"])
    length = found.about["length"]
    measured = measure(robot, poses, found.kind.mode, wanted, gravity=gravity, length=length, jobs=1)
    return _inside(robot, found.kind, wanted, measured, poses, gravity), measured.value, measured.scale


def _inside(
    robot: Robot, kind: WorkspaceKind, wanted: Required, found: Measured, poses: Array, gravity: Array
) -> NDArray[np.bool_]:
    """Whether poses are inside, (K,); where W lacks rank, and one wrench is asked for, a solver says so."""
    value = found.value
    with np.errstate(invalid="ignore"):
        inside = value >= -BOUNDARY * found.scale if kind.at_zero else value > BOUNDARY * found.scale
    lost = found.singular
    if lost.any() and kind.held:
        inside[lost] = distribute(robot, poses[lost], gravity=gravity).feasible
    return np.asarray(inside)


def _spread(values: Array) -> dict[str, float | None]:
    """Smallest, mean and largest."""
    if not len(values):
        return {"min": None, "mean": None, "max": None}
    return {"min": float(values.min()), "mean": float(values.mean()), "max": float(values.max())}
