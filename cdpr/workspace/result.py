"""A workspace: what was found at each cell of a box, how large it is, and its file."""

from __future__ import annotations

import json
import os
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from cdpr.distribution import distribute
from cdpr.errors import CdprError, LogError
from cdpr.log.files import unwritable
from cdpr.mechanics.clearance import Clearance, clearance
from cdpr.mechanics.properties import home_pose
from cdpr.model import Robot
from cdpr.model.arrays import checked
from cdpr.model.robot import Array
from cdpr.workspace import answers
from cdpr.workspace.certify import INSIDE, NEITHER, UNDECIDED, Proofs, certify
from cdpr.workspace.hull import RAYS, Hull, hull
from cdpr.workspace.kinds import KINDS, WorkspaceKind, combined, kind_of
from cdpr.workspace.measure import Measured
from cdpr.workspace.octree import Asked, octree
from cdpr.workspace.question import Question
from cdpr.workspace.rays import Rays, rays
from cdpr.workspace.regions import PIECE, Region
from cdpr.workspace.required import NOTHING

FORMAT = "cdpr workspace 3"
Over = Literal["all", "any"]
Method = Literal["grid", "octree", "hull", "rays", "certify"]
METHODS: tuple[Method, ...] = get_args(Method)
Detail = Proofs | Hull | Rays
DETAILS: dict[str, type[Proofs] | type[Hull] | type[Rays]] = {"certify": Proofs, "hull": Hull, "rays": Rays}

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
        boundary: (nx, ny, nz), whether round-off decides; or nothing is proved, where that was asked for.
        limit: (nx, ny, nz), what limits the value, a key of `about["limited_by"]`; -1 of nothing.
        evaluated: (nx, ny, nz), whether the cell was looked at; what is told of the others is interpolated.
        about: all that it depends on, as plain data: robot file, required set, gravity, versions, ...
        detail: what a method found that is finer than cells: boxes that are proved, of which `inside` are then the
            cells whose middle is in one inside; the boundary as seen from a point; or free stretches of rays.
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
        """What was asked of each pose."""
        return Question.from_plain(self.about["question"])

    @property
    def proofs(self) -> Proofs | None:
        """The boxes that are proved, where that was asked for."""
        return self.detail if isinstance(self.detail, Proofs) else None

    @property
    def volume(self) -> float:
        """Size of what is inside, m^3, or m^2 or m where the platform moves in a plane or along a line."""
        if self.detail is not None:
            return self.detail.volume
        return float(self.inside.sum()) * self.region.cell

    def summary(self) -> dict[str, Any]:
        """Return the figures of it as plain numbers."""
        here, values = np.argwhere(self.inside), self.value[self.inside]
        region = self.region
        bounds = None
        if len(here):
            size = region.spacing
            bounds = [
                (region.lower + here.min(axis=0) * size).tolist(),
                (region.lower + (here.max(axis=0) + 1) * size).tolist(),
            ]
        known = values[np.isfinite(values)]
        outside, names = self.limit[~self.inside], self.about["limited_by"]
        counts = {names[str(n)]: int((outside == n).sum()) for n in np.unique(outside).tolist() if str(n) in names}
        return {
            "kind": self.kind.name,
            "robot": self.robot,
            "volume": self.volume,
            "unit": region.unit,
            "share": float(self.inside.mean()) if self.detail is None else self.volume / (region.cell * region.cells),
            "bounds": bounds,
            "value": {"name": self.kind.value, "unit": self.kind.unit_of(self.question), **_spread(known)},
            "at_least": self.question.at_least,
            "outside_by": dict(sorted(counts.items(), key=lambda each: (-each[1], each[0]))),
            "cells": list(region.shape),
            "method": self.about["method"],
            "evaluated": int(self.evaluated.sum()) * len(region.orientations),
            "orientations": len(region.orientations),
            "unlimited": int(np.isposinf(values).sum()),
            "notes": self.about.get("notes", []),
            "on_boundary": int(self.boundary.sum()),
            "without_value": int(np.isnan(self.value).sum()),
            "box": [region.lower.tolist(), region.upper.tolist()],
            "found": None if self.detail is None else self.detail.told(),
        }

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write it as NPZ. Raises OutputError."""
        region, target = self.region, Path(path)
        part = target.with_name(f".{target.name}.part")
        about = {"format": FORMAT, "kind": self.kind.name, "robot": self.robot, **self.about}
        finer: dict[str, Any] = {} if self.detail is None else self.detail.plain()
        try:
            with part.open("wb") as file:
                np.savez_compressed(
                    file,
                    value=self.value,
                    inside=self.inside,
                    boundary=self.boundary,
                    limit=self.limit,
                    evaluated=self.evaluated,
                    lower=region.lower,
                    upper=region.upper,
                    orientations=region.orientations,
                    x=region.axes[0],
                    y=region.axes[1],
                    z=region.axes[2],
                    about=np.array(json.dumps(about, sort_keys=True)),
                    **finer,
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
            value, *tables = (found[name] for name in ("value", "inside", "boundary", "limit", "evaluated"))
            inside, boundary, limit, evaluated = tables
            region = Region(found["lower"], found["upper"], value.shape, found["orientations"])
            kind_of_detail = DETAILS.get(about["method"])
            detail = None if kind_of_detail is None else kind_of_detail.from_plain(region, {**found})
        if value.ndim != 3 or any(each.shape != value.shape for each in tables):
            raise ValueError("arrays of different shapes")
        name, robot = about.pop("kind"), about.pop("robot")
        kind = combined(name) if "of" in about else kind_of(name)
        read = Workspace(kind, robot, region, value, inside, boundary, limit, evaluated, about, detail)
        read.summary()  # all that it needs is there
        return read
    except (OSError, ValueError, KeyError, TypeError, CdprError, zipfile.BadZipFile, EOFError) as error:
        raise LogError(f"{os.fspath(path)}: is no workspace that can be read ({error})") from error


def _silent(done: int, total: int) -> None:
    """Tell nobody."""


def workspace(
    robot: Robot,
    kind: str,
    region: Region,
    question: Question | None = None,
    *,
    over: Over = "all",
    method: Method = "grid",
    undecided: float = UNDECIDED,
    n_rays: int = RAYS,
    jobs: int | None = None,
    progress: Callable[[int, int], None] = _silent,
    **asked: Any,
) -> Workspace:
    """Find which cells of a region are inside a workspace.

    Args:
        robot: whose it is.
        kind: a key of `cdpr.workspace.kinds.KINDS`.
        region: where, and in which attitudes.
        question: what the kind asks for beside; its parts may be given by their names instead, such as
            `required=box([50, 50, 50, 5, 5, 5])`: see `Question`.
        over: whether "all" attitudes of the region must be inside, or "any" of them.
        method: "grid" looks at all cells, "octree" at those that decide (`cdpr.workspace.octree`), "hull" from a point
            within for the boundary (`.hull`), "rays" for where cables are free along lines (`.rays`), and "certify"
            proves boxes of any size to be inside or outside (`.certify`). The last three look at the cells besides.
        undecided: the share of the box of which "certify" may leave undecided what it is.
        n_rays: in how many directions, at least, "hull" looks.
        jobs: threads; the result is the same.
        progress: called with the number of cells that are done, and their total.
        asked: parts of the question.

    Raises CdprError where an argument makes no sense.
    """
    chosen = kind_of(kind)
    whole = _question(chosen, robot, question, asked)
    if over not in ("all", "any"):
        raise CdprError(f"over: all or any of the orientations is expected, got {over!r}")
    if method not in METHODS:
        raise CdprError(f"method: one of {', '.join(METHODS)} is expected, got {method!r}")

    def at(positions: Array) -> Asked:
        return _ask(robot, chosen, whole, region, over, positions, jobs)

    def ask(cells: NDArray[np.int64]) -> Asked:
        return at(region.positions(cells))

    detail: Detail | None = None
    edge, told = whole.at_least or 0.0, progress if method in ("grid", "octree") else _silent
    if method == "certify":
        detail = certify(robot, chosen, region, whole, over=over, undecided=undecided, jobs=jobs, progress=progress)
    elif method == "rays":
        detail = rays(_bodies(robot, chosen, whole), region, edge, over, jobs, progress)
    evaluated = np.ones(region.cells, dtype=bool)
    if method == "octree":
        (value, limit, inside, boundary), evaluated = octree(ask, region, edge, chosen.slope_of(robot), told)
    else:
        pieces = []
        for cells in region.pieces():
            pieces.append(ask(cells))
            told(int(cells[-1]) + 1, region.cells)
        value, limit, inside, boundary = (np.concatenate(each) for each in zip(*pieces, strict=True))
    if method == "hull":
        cells_ = Asked(value, limit, inside, boundary)
        detail = hull(at, region, edge, home_pose(robot)[0][:3], cells_, n_rays, progress)
    if isinstance(detail, Proofs):
        proved = np.concatenate([detail.at(region.positions(cells)) for cells in region.pieces()])
        inside, boundary = proved == INSIDE, proved == NEITHER
    elif isinstance(detail, Rays):
        inside = detail.at_cells()
    table, numbers = region.shape, np.unique(limit)
    about = {
        "question": whole.plain(robot),
        "over": over,
        "method": method,
        "limited_by": answers.limits(robot, whole, numbers.tolist(), bodies=chosen.bodies),
        "notes": answers.notes(robot, whole, bodies=chosen.bodies),
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
        about,
        detail,
    )


def _ask(
    robot: Robot,
    kind: WorkspaceKind,
    question: Question,
    region: Region,
    over: Over,
    positions: Array,
    jobs: int | None,
) -> Asked:
    """Answer positions (n, 3) in all attitudes of a region."""
    value, limit = np.full(len(positions), np.nan), np.full(len(positions), -1, dtype=np.int64)
    boundary, inside = np.zeros(len(positions), dtype=bool), np.full(len(positions), over == "all")
    for first in range(0, len(positions), PIECE):
        cut = slice(first, first + PIECE)
        poses = np.empty((len(positions[cut]), 7))
        poses[:, :3] = positions[cut]
        for q in region.orientations:
            poses[:, 3:] = q
            found = kind.answer(robot, poses, question, jobs)
            here = _inside(robot, kind, question, found, poses)
            before = value[cut]
            with np.errstate(invalid="ignore"):
                better = found.value < before if over == "all" else found.value > before
            better |= np.isnan(before) & ~np.isnan(found.value)
            value[cut], limit[cut] = np.where(better, found.value, before), np.where(better, found.limit, limit[cut])
            inside[cut] = inside[cut] & here if over == "all" else inside[cut] | here
            boundary[cut] |= np.abs(found.value - (question.at_least or 0.0)) <= BOUNDARY * found.scale
    return Asked(value, limit, inside, boundary)


def _bodies(robot: Robot, kind: WorkspaceKind, question: Question) -> Clearance:
    """Who may touch whom, where along rays."""
    if not kind.bodies:
        raise CdprError(f"method: rays are for ifcow, not for {kind.name}; take grid, octree or hull")
    if kind.slope_of(robot) is None:
        raise CdprError("method: rays are for cables that leave from points; take grid or octree")
    return clearance(robot, question.obstacles, question.diameter)


def verdicts(found: Workspace, robot: Robot, poses: Array) -> tuple[NDArray[np.bool_], Array, Array]:
    """Ask again as a workspace was, of other poses (K, 7): whether inside, value and scale, each (K,)."""
    question = found.question
    measured = found.kind.answer(robot, poses, question, 1)
    return _inside(robot, found.kind, question, measured, poses), measured.value, measured.scale


def _question(kind: WorkspaceKind, robot: Robot, question: Question | None, asked: dict[str, Any]) -> Question:
    """What is asked, checked."""
    known = [each.name for each in fields(Question)]
    for name in asked:
        if name not in known:
            raise CdprError(f"{name}: is no part of a question; there are {', '.join(known)}")
    if "gravity" in asked:
        asked["gravity"] = checked(asked["gravity"], (3,), "gravity", finite=True)
    given = replace(question or Question(), **asked)
    given.check(robot)
    for name in ("obstacles", "diameter", "axial_stiffness", "direction"):
        if getattr(given, name) not in (None, ()) and name not in kind.takes:
            raise CdprError(f"{kind.name}: takes no {name}; that is for {_takers(name)}")
    required = None if given.required is NOTHING else given.required
    return replace(given, required=kind.required(required))


def _takers(name: str) -> str:
    return " and ".join(kind.name for kind in KINDS.values() if name in kind.takes)


def _inside(robot: Robot, kind: WorkspaceKind, question: Question, found: Measured, poses: Array) -> NDArray[np.bool_]:
    """Whether poses are inside, (K,); where W lacks rank, and one wrench is asked for, a solver says so."""
    rounding = BOUNDARY * found.scale
    with np.errstate(invalid="ignore"):
        if question.at_least is not None:
            inside = found.value >= question.at_least - rounding
        else:
            inside = found.value >= -rounding if kind.at_zero else found.value > rounding
    lost = found.singular
    if lost.any() and kind.held and (question.at_least or 0.0) <= 0.0:
        inside[lost] = distribute(robot, poses[lost], gravity=question.gravity).feasible
    return np.asarray(inside)


def _spread(values: Array) -> dict[str, float | None]:
    """Smallest, mean and largest."""
    if not len(values):
        return {"min": None, "mean": None, "max": None}
    return {"min": float(values.min()), "mean": float(values.mean()), "max": float(values.max())}
