"""Workspace: results at the cells of a box, their summary, and the file."""

from __future__ import annotations

import json
import os
import zipfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cdpr.analysis.workspace import answers, schema
from cdpr.analysis.workspace.accumulator import figures, tally, total
from cdpr.analysis.workspace.certify import INSIDE, NEITHER, UNDECIDED, Proofs, certify
from cdpr.analysis.workspace.chunk_files import read_folder
from cdpr.analysis.workspace.connected import Connected
from cdpr.analysis.workspace.evaluate import Over, checked_question, evaluate_positions, inside_of
from cdpr.analysis.workspace.hull import RAYS, Hull, hull
from cdpr.analysis.workspace.kinds import WorkspaceKind, combined, kind_of
from cdpr.analysis.workspace.octree import CellResults, octree
from cdpr.analysis.workspace.question import Question
from cdpr.analysis.workspace.rays import Rays, rays
from cdpr.analysis.workspace.regions import MOST_CELLS, Region
from cdpr.analysis.workspace.regions import region as region_of
from cdpr.analysis.workspace.turns import Turns, check_turns, turns
from cdpr.base.checksums import check_archive, seal_archive, validated
from cdpr.base.errors import CdprError, LogError
from cdpr.base.problems import shown
from cdpr.log.files import replacing
from cdpr.mechanics.clearance import Clearance
from cdpr.mechanics.properties import home_pose
from cdpr.model import Robot
from cdpr.model.arrays import shape_text
from cdpr.model.robot import Array
from cdpr.scenario import Scenario
from cdpr.scenario.loader import AnyRobot, robot_or_scenario

FORMAT = "cdpr workspace 5"
Method = Literal["grid", "octree", "hull", "rays", "turns", "certify"]
METHODS: tuple[Method, ...] = get_args(Method)
Detail = Proofs | Hull | Rays | Turns
DETAILS: dict[str, type[Proofs] | type[Hull] | type[Rays] | type[Turns]] = {
    "certify": Proofs,
    "hull": Hull,
    "rays": Rays,
    "turns": Turns,
}


@dataclass(frozen=True, eq=False)
class Workspace:
    """Results at the centres of the cells of a region.

    Attributes:
        kind: kind of workspace.
        robot: name of the robot.
        region: the region.
        value: (nx, ny, nz), >= 0 inside, `kind.unit`; over several attitudes the smallest, or the greatest if one
            attitude suffices. NaN if there is none: W is rank-deficient.
        inside: (nx, ny, nz).
        boundary: (nx, ny, nz), True if round-off decides, or if a certified workspace is undecided.
        limit: (nx, ny, nz), limiting cause, a key of `about["limited_by"]`; -1 if none.
        evaluated: (nx, ny, nz), True for evaluated cells; others are interpolated.
        about: all other parameters as plain data: robot file, required set, gravity, versions, ...
        detail: results of a method that are finer than cells: certified boxes, which then define `inside` at the
            centres of cells; the boundary as seen from a point; free intervals of rays; or turns.
    """

    kind: WorkspaceKind
    robot: str
    region: Region
    value: Array
    inside: NDArray[np.bool_]
    boundary: NDArray[np.bool_]
    limit: NDArray[np.int64]
    evaluated: NDArray[np.bool_]
    about: dict[str, Any]
    detail: Detail | None = None

    def __repr__(self) -> str:
        return f"<Workspace {self.kind.name} of {self.robot}: {self.volume:.4g} {self.region.unit}>"

    @cached_property
    def question(self) -> Question:
        """Parameters of each pose."""
        return Question.from_plain(self.about["question"])

    @property
    def proofs(self) -> Proofs | None:
        """Certified boxes, if any."""
        return self.detail if isinstance(self.detail, Proofs) else None

    @property
    def volume(self) -> float:
        """Size of the inside, m^3, or m^2 or m for motion in a plane or along a line."""
        if self.detail is not None:
            return self.detail.volume
        return float(self.inside.sum()) * self.region.cell

    def summary(self) -> dict[str, Any]:
        """Return its figures as plain numbers."""
        region, pieces, connected = self.region, [], Connected(self.region.shape)
        value, limit = self.value.ravel(), self.limit.ravel()
        inside, boundary = self.inside.ravel(), self.boundary.ravel()
        for cells in region.pieces():
            cut = slice(cells[0], cells[-1] + 1)
            pieces.append(tally(cells, region.shape, CellResults(value[cut], limit[cut], inside[cut], boundary[cut])))
            connected.add(inside[cut])
        return figures(
            self.kind,
            self.robot,
            region,
            self.question,
            self.about,
            total(pieces),
            evaluated=int(self.evaluated.sum()),
            components=connected.pieces,
            detail=self.detail,
        )

    def save(self, path: str | os.PathLike[str], force: bool = True) -> None:
        """Write the workspace as NPZ; replace an existing file only with `force`.

        Raises:
            OutputError: if it cannot be written.
        """
        region = self.region
        about = {"format": FORMAT, "kind": self.kind.name, "robot": self.robot, **self.about}
        x, y, z = region.axes
        tables = {
            "value": self.value,
            "inside": self.inside,
            "boundary": self.boundary,
            "limit": self.limit,
            "evaluated": self.evaluated,
            "lower": region.lower,
            "upper": region.upper,
            "orientations": region.orientations,
            "x": x,
            "y": y,
            "z": z,
            "about": np.array(json.dumps(about, sort_keys=True)),
            **({} if self.detail is None else self.detail.arrays()),
        }
        with replacing(Path(path), force) as file:
            np.savez_compressed(file, allow_pickle=False, **tables)
            seal_archive(file)


def load_workspace(path: str | os.PathLike[str]) -> Workspace:
    """Read a file of `Workspace.save` or a folder of `workspace_in_chunks`.

    Raises:
        LogError: if it cannot be read.
    """
    if os.path.isdir(path):
        return _of_folder(Path(path))
    try:
        with open(path, "rb") as file:
            check_archive(file)
            with np.load(file, allow_pickle=False) as members:
                found = {**members}
        about = json.loads(str(found["about"]))
        if about.pop("format", None) != FORMAT:
            raise ValueError("another format")
        validated(about, schema.ABOUT)
        value, inside, boundary, limit, evaluated = (
            _table(found, name, kind, (None, None, None))
            for name, kind in (("value", "f"), ("inside", "b"), ("boundary", "b"), ("limit", "i"), ("evaluated", "b"))
        )
        if any(each.shape != value.shape for each in (inside, boundary, limit, evaluated)):
            raise ValueError("arrays of different shapes")
        lower, upper = (_table(found, name, "f", (3,)) for name in ("lower", "upper"))
        region = Region(lower, upper, value.shape, _table(found, "orientations", "f", (None, 4)))
        kind_of_detail = DETAILS.get(about["method"])
        detail = None if kind_of_detail is None else kind_of_detail.from_plain(region, found)
        name, robot = about.pop("kind"), about.pop("robot")
        kind = combined(name) if "of" in about else kind_of(name)
        return Workspace(kind, robot, region, value, inside, boundary, limit, evaluated, about, detail)
    except OSError as error:
        raise LogError(f"{os.fspath(path)}: cannot be read: {error.strerror or error}") from error
    except (ValueError, LookupError, CdprError, zipfile.BadZipFile) as error:
        raise LogError(f"{os.fspath(path)}: cannot be read as a workspace ({error})") from error


def _table(found: Mapping[str, NDArray[Any]], name: str, kind: str, shape: tuple[int | None, ...]) -> NDArray[Any]:
    """Return an array of a file.

    Raises:
        ValueError: if it is missing or has another type or shape.
    """
    table = found.get(name)
    if table is None or table.dtype.kind != kind or table.ndim != len(shape):
        raise ValueError(f"{name}: expected an array of {len(shape)} dimensions and kind '{kind}'")
    if any(want not in (None, got) for want, got in zip(shape, table.shape, strict=True)):
        raise ValueError(f"{name}: expected an array of shape {shape_text(shape)}, got {table.shape}")
    return table


def _silent(done: int, total: int) -> None:
    """Ignore the progress."""


def _of_folder(path: Path) -> Workspace:
    about, place, found = read_folder(path)
    kind, robot, table = kind_of(about.pop("kind")), about.pop("robot"), place.shape
    value, limit = found.value.reshape(table), found.limit.reshape(table)
    inside, boundary = found.inside.reshape(table), found.boundary.reshape(table)
    return Workspace(kind, robot, place, value, inside, boundary, limit, np.ones(table, dtype=bool), about)


def workspace(
    robot: AnyRobot,
    kind: str,
    region: Region | None = None,
    question: Question | None = None,
    *,
    lower: ArrayLike | None = None,
    upper: ArrayLike | None = None,
    cells: int | Sequence[int] | None = None,
    orientations: ArrayLike | None = None,
    over: Over = "all",
    method: Method = "grid",
    undecided: float = UNDECIDED,
    n_rays: int = RAYS,
    about: str = "rz",
    jobs: int | None = None,
    progress: Callable[[int, int], None] = _silent,
    **options: Any,
) -> Workspace:
    """Find the cells of a region that are inside a workspace.

    Args:
        robot: a Robot, a file, the name of an example, a dict or a Scenario, whose gravity and obstacles apply.
        kind: key of `cdpr.analysis.workspace.kinds.KINDS`, such as "static", "wrench-feasible" or "stiffness".
        region: positions and attitudes, from `cdpr.analysis.workspace.region`; made from the next four by default.
        lower: lowest corner, (3,), m; that of the frame by default.
        upper: highest corner, likewise.
        cells: cells along x, y, z, or along the longest side; 40 by default.
        orientations: (4,) or (k, 4), quaternions w, x, y, z; that of home by default.
        question: parameters of the kind; its parts may be given by name instead, such as `required=box([50, 50, 50, 5,
            5, 5])`: see `Question`. A given question replaces gravity and obstacles of a Scenario.
        over: "all" or "any" attitudes of the region must be inside.
        method: "grid" evaluates all cells, "octree" only the decisive ones (`cdpr.analysis.workspace.octree`). In
            addition to the cells, "hull" finds the boundary from a point inside (`.hull`), "rays" the free intervals
            along lines (`.rays`), "turns" the reachable rotations of the platform (`.turns`), and "certify" proves
            boxes of any size to be inside or outside (`.certify`).
        undecided: share of the box that "certify" may leave undecided.
        n_rays: minimum number of rays of "hull".
        about: world axis of "turns": "rx", "ry" or "rz".
        jobs: threads; the result is the same.
        progress: called with the number of finished cells and their total.
        options: parts of the question.

    Returns:
        The results of all cells, with `volume`, `summary()` and `save()`.

    Raises:
        CdprError: if an argument is invalid.

    Example:
        >>> import cdpr
        >>> cdpr.workspace("caroca", "static", cells=8)
        <Workspace static of caroca: 98 m^3>
    """
    chosen = kind_of(kind)
    if isinstance(loaded := robot_or_scenario(robot), Scenario):
        known = {"gravity": loaded.gravity, "obstacles": loaded.obstacles} if question is None else {}
        options = {key: known[key] for key in known if key == "gravity" or key in chosen.takes} | options
        loaded = loaded.robot
    robot = loaded
    limits: dict[str, Any] = {"lower": lower, "upper": upper, "cells": cells, "orientations": orientations}
    if region is None:
        region = region_of(robot, **limits)
    elif not isinstance(region, Region):
        raise CdprError(f"region: expected a cdpr.analysis.workspace.Region, got {shown(region)}")
    elif any(each is not None for each in limits.values()):
        raise CdprError("region: give either a region, or lower, upper, cells and orientations")
    whole = checked_question(chosen, robot, question, over, options)
    if method not in METHODS:
        raise CdprError(f"method: expected one of {', '.join(METHODS)}, got {shown(method)}")
    if region.cells > MOST_CELLS:
        text = "which a table in memory holds; in chunks, --chunks, a folder may hold as many as its disk"
        raise CdprError(f"cells: {region.cells} cells are more than {MOST_CELLS}, {text}")

    def at(positions: Array) -> CellResults:
        return evaluate_positions(robot, chosen, whole, region, over, positions, jobs)

    def evaluate(numbers: NDArray[np.int64]) -> CellResults:
        return at(region.positions(numbers))

    detail: Detail | None = None
    edge, report = whole.at_least or 0.0, progress if method in ("grid", "octree") else _silent
    if method == "certify":
        detail = certify(robot, chosen, region, whole, over=over, undecided=undecided, jobs=jobs, progress=progress)
    elif method == "turns":
        check_turns(robot, region, about)
    elif method == "rays":
        detail = rays(_bodies(robot, chosen, whole), region, edge, over, jobs, progress)
    evaluated = np.ones(region.cells, dtype=bool)
    if method == "octree":
        (value, limit, inside, boundary), evaluated = octree(evaluate, region, edge, chosen.slope_of(robot), report)
    else:
        pieces = []
        for numbers in region.pieces():
            pieces.append(evaluate(numbers))
            report(int(numbers[-1]) + 1, region.cells)
        value, limit, inside, boundary = (np.concatenate(each) for each in zip(*pieces, strict=True))
    if method == "hull":
        cells_ = CellResults(value, limit, inside, boundary)
        detail = hull(at, region, edge, home_pose(robot)[0][:3], cells_, n_rays, progress)
    elif method == "turns":

        def held(poses: Array) -> NDArray[np.bool_]:
            return inside_of(robot, chosen, whole, chosen.answer(robot, poses, whole, jobs), poses)

        detail = turns(held, region, about, inside, progress)
    if isinstance(detail, Proofs):
        proved = np.concatenate([detail.at(region.positions(piece)) for piece in region.pieces()])
        inside, boundary = proved == INSIDE, proved == NEITHER
    elif isinstance(detail, Rays):
        inside = detail.at_cells()
    table, numbers = region.shape, np.flatnonzero(np.bincount(limit + 1)) - 1  # small integers from -1
    known = {
        "question": whole.to_dict(robot),
        "over": over,
        "method": method,
        "limited_by": answers.limits(robot, whole, numbers.tolist(), bodies=chosen.bodies),
        "notes": answers.notes(robot, whole, bodies=chosen.bodies)
        + (detail.notes if isinstance(detail, Proofs) else []),
    } | ({"undecided": undecided} if method == "certify" else {"rays": n_rays} if method == "hull" else {})
    return Workspace(
        chosen,
        robot.name,
        region,
        value.reshape(table),
        inside.reshape(table),
        boundary.reshape(table),
        limit.reshape(table),
        evaluated.reshape(table),
        known,
        detail,
    )


def _bodies(robot: Robot, kind: WorkspaceKind, question: Question) -> Clearance:
    """Return the bodies for rays."""
    if not kind.bodies:
        raise CdprError(f"method: rays are for ifcow, not for {kind.name}; take grid, octree or hull")
    if kind.slope_of(robot) is None:
        raise CdprError("method: rays are for cables that leave from points; take grid or octree")
    return answers.bodies_of(robot, question)


def verdicts(found: Workspace, robot: Robot, poses: Array) -> tuple[NDArray[np.bool_], Array, Array]:
    """Evaluate other poses (K, 7) as a workspace was: True if inside, value and scale, each (K,)."""
    question = found.question
    measured = found.kind.answer(robot, poses, question, 1)
    return inside_of(robot, found.kind, question, measured, poses), measured.value, measured.scale
