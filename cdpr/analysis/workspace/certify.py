"""Boxes of a region that are proved to be inside or outside a workspace; undecided boxes are divided into eight.

A proof holds at every position of a box, not only at its centre. For forces, the operation `prove` (proofs.hpp) proves
it. For values with a bounded slope, the centre's value minus the slope times half the diagonal suffices. Data of the
robot and of the wrenches are assumed to be exact up to a few roundings.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr.analysis.workspace.kinds import KINDS, WorkspaceKind
from cdpr.analysis.workspace.measure import pose_question
from cdpr.analysis.workspace.question import Question
from cdpr.analysis.workspace.regions import Region
from cdpr.base.errors import CdprError
from cdpr.base.problems import shown
from cdpr.base.threads import in_threads
from cdpr.mechanics.dynamics import required_wrench
from cdpr.mechanics.kinematics import make_state
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import bind

START = 8  # initial boxes along the longest side
PIECE = 65536  # boxes between two checks of the undecided share
UNDECIDED = 0.02  # default share of the region that may stay undecided
MOST = 20_000_000  # limit of evaluated boxes: some minutes, and a gigabyte
LACKING = 3  # levels at which boxes are checked for rank-deficient W
WITHIN = 0.21, 0.79  # shares of a side at which they are checked; corners may coincide with anchors
DEEPEST = 17  # maximum number of divisions: boxes can be numbered, and their sides exceed round-off
# Relative error of given data, and of data computed from them in a few operations.
ROUNDED = 2.0**-46
# Relative increase of half sides, so that adjacent boxes overlap in spite of rounding.
OVERLAP = 2.0**-40
# Round-off of a clearance, m: a hundred times that of distances between segments within 100 m.
SLACK = 1e-9

OUTSIDE, NEITHER, INSIDE = -1, 0, 1
NAMES = {INSIDE: "proved_inside", OUTSIDE: "proved_outside", NEITHER: "undecided"}

Whole = NDArray[np.integer[Any]]


@dataclass(frozen=True, eq=False)
class Proofs:
    """Boxes that together fill a region.

    Attributes:
        region: the region.
        roots: (3,), initial boxes along each axis.
        level: (k,), number of divisions.
        place: (k, 3), index along each axis among the boxes of its level.
        proved: (k,), INSIDE, OUTSIDE, or NEITHER if undecided.
        evaluated: number of evaluated boxes.
        lacking: share of the region that was not divided further, because W is rank-deficient in all of it: the proofs
            invert W W^T. Not stored in files.
    """

    region: Region
    roots: Whole
    level: Whole
    place: Whole
    proved: Whole
    evaluated: int
    lacking: float = 0.0

    @property
    def notes(self) -> list[str]:
        """Reason why a part has no proof, in a sentence."""
        if not self.lacking:
            return []
        part = "anywhere in the box" if self.lacking > 1.0 - ROUNDED else f"in {100 * self.lacking:.3g} % of the box"
        return [
            f"no proof {part}: the wrench matrix is rank-deficient there, so the cables exert no wrench in some "
            "direction; cells are evaluated one by one"
        ]

    @property
    def volume(self) -> float:
        """Size of the part proved to be inside, m^3, or m^2 or m for motion in a plane or along a line."""
        return self.shares()[NAMES[INSIDE]] * self.region.cell * self.region.cells

    def figures(self) -> dict[str, Any]:
        """Return its figures."""
        shares = self.shares()
        open_ = shares[NAMES[NEITHER]] * self.region.cell * self.region.cells
        return {"shares": shares, "boxes": self.evaluated, "at_most": self.volume + open_}

    def corners(self) -> tuple[Array, Array]:
        """Return the lowest and the highest corners of all boxes, each (k, 3), m."""
        sides = _sides(self.region, self.roots, self.level[:, None])
        low = self.region.lower + self.place * sides
        return low, low + sides

    def shares(self) -> dict[str, float]:
        """Return the shares of the region that are "proved_inside", "proved_outside" and "undecided"."""
        size = self._sizes()
        return {name: float(size[self.proved == verdict].sum()) for verdict, name in NAMES.items()}

    def at(self, positions: Array) -> Whole:
        """Return the verdicts at positions (n, 3) of the region, (n,)."""
        region, found = self.region, np.full(len(positions), NEITHER)
        extent = np.where(region.upper > region.lower, region.upper - region.lower, 1.0)
        share = (positions - region.lower) / extent
        for level in np.unique(self.level).tolist():
            here = self.level == level
            counts = _counts(region, self.roots, level)
            keys = np.ravel_multi_index(tuple(self.place[here].T), counts)
            order = np.argsort(keys)
            places = np.clip((share * counts).astype(np.int64), 0, np.array(counts) - 1)
            wanted = np.ravel_multi_index(tuple(places.T), counts)
            at = np.minimum(np.searchsorted(keys[order], wanted), len(keys) - 1)
            hit = keys[order][at] == wanted
            found[hit] = self.proved[here][order][at][hit]
        return found

    def drawn(self, rng: np.random.Generator, count: int) -> tuple[Array, Whole]:
        """Return uniformly random decided positions (n, 3) and their verdicts; empty if nothing is decided."""
        size = self._sizes() * (self.proved != NEITHER)
        if not size.any():
            return np.empty((0, 3)), np.empty(0, dtype=np.int64)
        chosen = rng.choice(len(size), size=count, p=size / size.sum())
        low, high = self.corners()
        return low[chosen] + rng.random((count, 3)) * (high - low)[chosen], self.proved[chosen]

    def _sizes(self) -> Array:
        """Return the sizes of the boxes as shares of the region, (k,)."""
        return np.asarray(0.5 ** (self.level * len(self.region.moving)) / float(np.prod(self.roots)))

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return its data as arrays for a file."""
        asked = np.array(self.evaluated)
        named = {"level": self.level, "place": self.place, "proved": self.proved, "roots": self.roots, "asked": asked}
        return {f"box_{name}": array for name, array in named.items()}

    @classmethod
    def from_plain(cls, region: Region, arrays: dict[str, NDArray[Any]]) -> Proofs:
        """Return the proofs from the arrays of `plain`."""
        level, place, proved, roots = (arrays[f"box_{name}"] for name in ("level", "place", "proved", "roots"))
        return cls(region, roots, level, place, proved, int(arrays["box_asked"]))


def certify(
    robot: Robot,
    kind: WorkspaceKind,
    region: Region,
    question: Question,
    *,
    over: str = "all",
    undecided: float = UNDECIDED,
    jobs: int | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Proofs:
    """Prove boxes of a region to be inside or outside a workspace.

    Args:
        robot: robot whose cables leave from points.
        kind: kind with `proved`.
        region: region to divide into boxes; its cells are ignored.
        question: parameters of the kind.
        over: "all" or "any" attitudes must be inside.
        undecided: share of the region that may stay undecided; more if `MOST` boxes were evaluated.
        jobs: threads; the result is the same.
        progress: called with the decided share in percent, and 100.

    Raises:
        CdprError: if nothing can be proved for such a robot or question.
    """
    _check(robot, kind, question, undecided)
    provers = [_prover(robot, kind, question, region, q, jobs) for q in region.orientations]
    roots = np.array([max(1, round(START * side / (region.upper - region.lower).max())) for side in _extent(region)])
    children = np.array(
        [each for each in product((0, 1), repeat=3) if not any(np.array(each)[_extent(region) == 0.0])]
    ).astype(np.int32)
    twice = np.where(_extent(region) > 0.0, 2, 1).astype(np.int32)
    place = np.stack(np.meshgrid(*map(np.arange, roots), indexing="ij"), axis=-1).reshape(-1, 3).astype(np.int32)
    kept: list[tuple[Whole, Whole, Whole]] = []
    open_, evaluated, level, lacking = 1.0, 0, 0, 0.0
    while len(place):
        share = 0.5 ** (level * len(region.moving)) / float(np.prod(roots))
        sides = _sides(region, roots, level)
        proved = np.full(len(place), NEITHER, dtype=np.int8)
        stop = 0
        while stop < len(place) and open_ > undecided and evaluated < MOST:
            cut = slice(stop, min(stop + PIECE, len(place)))
            middles = region.lower + (place[cut] + 0.5) * sides
            found = np.array([prove(middles, 0.5 * sides * (1.0 + OVERLAP)) for prove in provers])
            proved[cut] = found.min(axis=0) if over == "all" else found.max(axis=0)
            stop, evaluated = cut.stop, evaluated + cut.stop - cut.start
            open_ -= share * float(np.count_nonzero(proved[cut]))
            progress(min(int(100 * (1.0 - open_)), 99), 100)
        enough = stop < len(place) or open_ <= undecided or level == DEEPEST
        done = (proved != NEITHER) | enough
        if level < LACKING and kind.slope is None:
            lost = ~done
            lost[lost] = _lacks(robot, kind, question, region, region.lower + place[lost] * sides, sides)
            done, lacking = done | lost, lacking + share * float(np.count_nonzero(lost))
        kept.append((np.full(int(done.sum()), level, dtype=np.int8), place[done], proved[done]))
        rest = place[~done]
        place = (rest[:, None] * twice + children[None]).reshape(-1, 3)
        level += 1
    progress(100, 100)
    levels, places, verdicts = (np.concatenate(each) for each in zip(*kept, strict=True))
    return Proofs(region, roots, levels, places, verdicts, evaluated, lacking)


def _lacks(
    robot: Robot, kind: WorkspaceKind, question: Question, region: Region, low: Array, sides: Array
) -> NDArray[np.bool_]:
    """Return True for boxes with W rank-deficient at all sampled points in all attitudes; corners are (k, 3)."""
    lost = np.ones(len(low), dtype=bool)
    for share in [(0.5, 0.5, 0.5), *product(WITHIN, repeat=3)]:
        for q in region.orientations:
            poses = _poses(low[lost] + np.array(share) * sides, q)
            if not len(poses):
                return lost
            found = kind.answer(robot, poses, question, 1)
            lost[lost] = found.singular
    return lost


def _check(robot: Robot, kind: WorkspaceKind, question: Question, undecided: float) -> None:
    """Raise CdprError if nothing can be proved."""
    if not kind.proved:
        known = ", ".join(each.name for each in KINDS.values() if each.proved)
        raise CdprError(f"method: certify supports {known}, not {kind.name}; use grid or octree")
    if not 0.0 <= undecided < 1.0:
        raise CdprError(f"undecided: expected a share from 0 to below 1, got {shown(undecided)}")
    for cable in robot.cables:
        if cable.exit is not None and cable.exit.header:
            raise CdprError(
                "method: certify proves nothing of cables that leave from something else than a point, as "
                f"'{cable.name}' does; take grid or octree"
            )
    if kind.slope is None and question.at_least is not None:
        raise CdprError(f"at_least: certify supports {kind.name} margins above 0 only")


def _prover(
    robot: Robot, kind: WorkspaceKind, question: Question, region: Region, q: Array, jobs: int | None
) -> Callable[[Array, Array], Whole]:
    """Return the function that proves boxes with centres (n, 3) and half sides (3,) in one attitude."""
    if kind.slope is not None:
        slope, edge = kind.slope, question.at_least or 0.0

        def by_slope(middles: Array, half: Array) -> Whole:
            value = kind.answer(robot, _poses(middles, q), question, jobs).value - edge
            reach = slope * float(np.linalg.norm(half)) + SLACK
            return np.where(value > reach, INSIDE, np.where(value < -reach, OUTSIDE, NEITHER))

        return by_slope
    pose = pose_question(robot, "margin", question.required, question.gravity, question.length)
    wrenches = np.ascontiguousarray(pose.weights * _wrenches(robot, question, q)[:, robot.rows])
    lengths = np.abs(robot.anchors).max() + np.abs([region.lower, region.upper]).max()
    errors = ROUNDED * np.array([lengths, np.abs(wrenches).max()])

    def by_forces(middles: Array, half: Array) -> Whole:
        proved, poses = np.empty(len(middles), dtype=np.int64), _poses(middles, q)
        halves = np.repeat(half[None], len(middles), axis=0)

        def part(cut: slice) -> None:
            boxes = {"poses": poses[cut], "halves": halves[cut], "proved": proved[cut]}
            bind("prove", **pose._asdict(), **boxes, wrenches=wrenches, errors=errors).unlocked()

        in_threads(len(middles), part, jobs)
        return proved

    return by_forces


def _wrenches(robot: Robot, question: Question, q: Array) -> Array:
    """Return all required wrenches in one attitude, (k, 6): corners of the required set plus the weight."""
    state = make_state((0.0, 0.0, 0.0), q)
    corners, required = question.required.corners(), question.required
    if required.accelerations:
        return np.array([required_wrench(robot, state, question.gravity, c[:3], c[3:]) for c in corners])
    return np.asarray(required_wrench(robot, state, question.gravity) + corners)


def _poses(positions: Array, q: Array) -> Array:
    return np.concatenate([positions, np.repeat(q[None], len(positions), axis=0)], axis=1)


def _extent(region: Region) -> Array:
    return np.asarray(region.upper - region.lower)


def _sides(region: Region, roots: Whole, level: Any) -> Array:
    """Return the sides of boxes after a number of divisions, m."""
    return np.asarray(_extent(region) / roots * 0.5**level)


def _counts(region: Region, roots: Whole, level: int) -> tuple[int, ...]:
    """Return the number of boxes of a level along each axis."""
    return tuple(int(n) << level if side else 1 for n, side in zip(roots, _extent(region), strict=True))
