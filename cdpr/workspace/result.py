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
from cdpr.model import Robot
from cdpr.model.arrays import checked
from cdpr.model.robot import Array
from cdpr.workspace import answers
from cdpr.workspace.chunk_files import read_folder
from cdpr.workspace.connected import Connected
from cdpr.workspace.kinds import KINDS, WorkspaceKind, combined, kind_of
from cdpr.workspace.measure import Measured
from cdpr.workspace.octree import Asked, octree
from cdpr.workspace.question import Question
from cdpr.workspace.regions import MOST_CELLS, PIECE, Region
from cdpr.workspace.required import NOTHING
from cdpr.workspace.tally import figures, tally, total

FORMAT = "cdpr workspace 3"
Over = Literal["all", "any"]
Method = Literal["grid", "octree"]
METHODS: tuple[Method, ...] = get_args(Method)

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
        limit: (nx, ny, nz), what limits the value, a key of `about["limited_by"]`; -1 of nothing.
        evaluated: (nx, ny, nz), whether the cell was looked at; what is told of the others is interpolated.
        about: all that it depends on, as plain data: robot file, required set, gravity, versions, ...
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

    def __repr__(self) -> str:
        return f"<Workspace {self.kind.name} of {self.robot}: {self.volume:.4g} {self.region.unit}>"

    @cached_property
    def question(self) -> Question:
        """What was asked of each pose."""
        return Question.from_plain(self.about["question"])

    @property
    def volume(self) -> float:
        """Size of what is inside, m^3, or m^2 or m where the platform moves in a plane or along a line."""
        return float(self.inside.sum()) * self.region.cell

    def summary(self) -> dict[str, Any]:
        """Return the figures of it as plain numbers."""
        region, pieces, connected = self.region, [], Connected(self.region.shape)
        value, limit = self.value.ravel(), self.limit.ravel()
        inside, boundary = self.inside.ravel(), self.boundary.ravel()
        for cells in region.pieces():
            cut = slice(cells[0], cells[-1] + 1)
            pieces.append(tally(cells, region.shape, Asked(value[cut], limit[cut], inside[cut], boundary[cut])))
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
        )

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
                    limit=self.limit,
                    evaluated=self.evaluated,
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
    """Read a file of `Workspace.save` or a folder of `workspace_in_chunks`. Raises LogError where it cannot be read."""
    if os.path.isdir(path):
        return _of_folder(Path(path))
    try:
        with open(path, "rb") as file, np.load(file, allow_pickle=False) as found:
            about = json.loads(str(found["about"]))
            if about.pop("format", None) != FORMAT:
                raise ValueError("another format")
            value, *tables = (found[name] for name in ("value", "inside", "boundary", "limit", "evaluated"))
            inside, boundary, limit, evaluated = tables
            region = Region(found["lower"], found["upper"], value.shape, found["orientations"])
        if value.ndim != 3 or any(each.shape != value.shape for each in tables):
            raise ValueError("arrays of different shapes")
        name, robot = about.pop("kind"), about.pop("robot")
        kind = combined(name) if "of" in about else kind_of(name)
        read = Workspace(kind, robot, region, value, inside, boundary, limit, evaluated, about)
        read.summary()  # all that it needs is there
        return read
    except (OSError, ValueError, KeyError, TypeError, CdprError, zipfile.BadZipFile, EOFError) as error:
        raise LogError(f"{os.fspath(path)}: is no workspace that can be read ({error})") from error


def _of_folder(path: Path) -> Workspace:
    about, place, found = read_folder(path)
    kind, robot, table = kind_of(about.pop("kind")), about.pop("robot"), place.shape
    value, limit = found.value.reshape(table), found.limit.reshape(table)
    inside, boundary = found.inside.reshape(table), found.boundary.reshape(table)
    return Workspace(kind, robot, place, value, inside, boundary, limit, np.ones(table, dtype=bool), about)


def workspace(
    robot: Robot,
    kind: str,
    region: Region,
    question: Question | None = None,
    *,
    over: Over = "all",
    method: Method = "grid",
    jobs: int | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
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
        method: "grid" looks at all cells, "octree" at those that decide (`cdpr.workspace.octree`).
        jobs: threads; the result is the same.
        progress: called with the number of cells that are done, and their total.
        asked: parts of the question.

    Raises CdprError where an argument makes no sense.
    """
    chosen = kind_of(kind)
    whole = checked_question(chosen, robot, question, over, asked)
    if method not in METHODS:
        raise CdprError(f"method: one of {', '.join(METHODS)} is expected, got {method!r}")
    if region.cells > MOST_CELLS:
        text = "which a table in memory holds; in chunks, --chunks, a folder may hold as many as its disk"
        raise CdprError(f"cells: {region.cells} cells are more than {MOST_CELLS}, {text}")

    def ask(cells: NDArray[np.int64]) -> Asked:
        return ask_cells(robot, chosen, whole, region, over, cells, jobs)

    if method == "octree":
        edge = whole.at_least or 0.0
        (value, limit, inside, boundary), evaluated = octree(ask, region, edge, chosen.slope, progress)
    else:
        pieces = []
        for cells in region.pieces():
            pieces.append(ask(cells))
            progress(int(cells[-1]) + 1, region.cells)
        value, limit, inside, boundary = (np.concatenate(each) for each in zip(*pieces, strict=True))
        evaluated = np.ones(region.cells, dtype=bool)
    table, numbers = region.shape, np.unique(limit)
    about = {
        "question": whole.plain(robot),
        "over": over,
        "method": method,
        "limited_by": answers.limits(robot, whole, numbers.tolist(), bodies=chosen.bodies),
        "notes": answers.notes(robot, whole, bodies=chosen.bodies),
    }
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
    )


def ask_cells(
    robot: Robot,
    kind: WorkspaceKind,
    question: Question,
    region: Region,
    over: Over,
    cells: NDArray[np.int64],
    jobs: int | None,
) -> Asked:
    """Answer cells by their numbers, (n,), in all attitudes of a region."""
    value, limit = np.full(len(cells), np.nan), np.full(len(cells), -1, dtype=np.int64)
    boundary, inside = np.zeros(len(cells), dtype=bool), np.full(len(cells), over == "all")
    for first in range(0, len(cells), PIECE):
        cut = slice(first, first + PIECE)
        poses = np.empty((len(cells[cut]), 7))
        poses[:, :3] = region.positions(cells[cut])
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


def verdicts(found: Workspace, robot: Robot, poses: Array) -> tuple[NDArray[np.bool_], Array, Array]:
    """Ask again as a workspace was, of other poses (K, 7): whether inside, value and scale, each (K,)."""
    question = found.question
    measured = found.kind.answer(robot, poses, question, 1)
    return _inside(robot, found.kind, question, measured, poses), measured.value, measured.scale


def checked_question(
    kind: WorkspaceKind, robot: Robot, question: Question | None, over: Over, asked: dict[str, Any]
) -> Question:
    """Return what is asked, with the parts that are given by their names. Raises CdprError."""
    if over not in ("all", "any"):
        raise CdprError(f"over: all or any of the orientations is expected, got {over!r}")
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
