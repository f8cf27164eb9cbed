"""Blocks of up to eight cases that run in lanes, with the bits of each case alone.

The arrays of the cases are the lanes of one block. An operation without a vector form, or one that does not serve a
case, such as a solver at tension limits, runs on that case's own arrays. A case that needs Python, for example for an
event, leaves its lane and returns to it later.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cdpr.analysis.rollouts import ways
from cdpr.analysis.rollouts.case import Case, Plan
from cdpr.analysis.rollouts.recipe import Recipe, Root, UnfitError, View, whole
from cdpr.model.robot import Array
from cdpr.native.bind import Compiled, bind
from cdpr.native.library import Bound, address
from cdpr.native.operations import LANES, operations
from cdpr.simulation.pipeline import COMPLETE, NEXT
from cdpr.simulation.step_kernel import NEVER
from cdpr.tension.operations import Operation

SPAN = 16384  # samples of one call: an interrupt waits for some hundredths of a second
WORTHWHILE = 3  # cases: fewer are as fast alone
# A case that leaves its lane within SOON samples continues alone for as many, then for twice as many, up to LONGEST.
SOON, LONGEST = 16, 1024

# Columns of the tables of cables with kinds, which kernels read from the first lane: `cdpr/cables/line.hpp` and
# `chain.hpp`.
KINDS = {"lines": slice(6, 7), "chains": slice(0, 2)}

Words = NDArray[np.int64]


class Block:
    """Lanes of up to eight cases of one structure.

    Args:
        plan: data shared by all cases.
        case: one of them, begun.

    Raises:
        UnfitError: if such cases cannot share a block.
    """

    def __init__(self, plan: Plan, case: Case) -> None:
        self._operations, self._bound = _operations(case), _bounds(case)
        if "count_sample_lanes" not in operations():
            raise UnfitError  # the library for plain x86-64 has no operations in lanes
        memory = _memory(case)
        self._recipe = recipe = Recipe(memory)
        self._sizes = [array.size for array in memory]
        found = [_way(operation, bound, case) for operation, bound in zip(self._operations, self._bound, strict=True)]
        self._wide = [at for at, way in enumerate(found) if way == ways.IN_LANES]
        given = [recipe.read(at, _native(self._bound[at])) for at in self._wide]
        for bound in self._bound:
            recipe.note(bound)
        own = None if case.given is None else recipe.known(case.given)
        if own is not None and own not in recipe.moved:
            recipe.moved.append(own)
        self._starts = np.cumsum([0, *(root.size for root in recipe.roots)])
        self.lanes = np.zeros((int(self._starts[-1]), LANES))
        self._given = None if own is None else slice(int(self._starts[own]), int(self._starts[own + 1]))
        self._table = np.zeros((len(found), 5), dtype=np.int64)
        self._table[:, ways.WAY], self._table[:, ways.IN] = found, -1
        complete = found.index(ways.COMPLETE)
        self._table[:, ways.TOGETHER] = _together(found, [operation.skip for operation in self._operations], complete)
        self._held = []
        for at, arguments in zip(self._wide, given, strict=True):
            lifted = {name: self._lifted(each) for name, each in arguments.items()}
            self._held.append(bind(f"{_native(self._bound[at]).name}_lanes", **lifted))
            self._table[at, [ways.OPERATION, ways.PLACE]] = self._held[-1].operation, self._held[-1].place
        self._complete, self._motion = complete, found.index(ways.MOTION)
        count = len(recipe.roots)
        self._roots = np.zeros((count, 3), dtype=np.int64)  # address, size and first row of each array
        self._roots[:, 1], self._roots[:, 2] = [root.size for root in recipe.roots], self._starts[:-1]
        self._cases: list[Case | None] = [None] * LANES
        self._tables: list[tuple[Compiled | None, Words]] = [(None, self._roots)] * LANES  # see `_enlist`
        self._present: list[Case] = []  # cases of the last call
        self._alive = 0  # bits of their lanes
        self._order: slice | list[int] = []  # their lanes
        self._alike, self._place = np.zeros(1, dtype=np.int64), np.zeros(3, dtype=np.int64)
        self._progress = self._place.data  # faster
        self._pipelines, self._motions = np.zeros((LANES, 4), dtype=np.int64), np.zeros((LANES, 2), dtype=np.int64)
        self._desired, self._kept = np.zeros((LANES, 3), dtype=np.int64), np.zeros(LANES, dtype=np.int64)
        self._arrays = np.zeros((LANES, len(recipe.moved), 3), dtype=np.int64)
        self._advance = bind(
            "advance",
            table=self._table[:-1],
            place=self._place,
            pipelines=self._pipelines,
            arrays=self._arrays,
            motions=self._motions,
            desired=self._desired,
            counting=self._table[-1, [ways.OPERATION, ways.PLACE]],
            columns=plan.places,
            kept=self._kept,
            alike=self._alike,
            block=self.lanes,
            period=case.loop.parts.control_step,
            every=plan.every,
            n=len(case.out),
        )
        self._moving, self._moved = np.zeros_like(self._roots), np.zeros(3, dtype=np.int64)
        self._mover = bind("move_lane", arrays=self._moving, moved=self._moved, block=self.lanes)
        self._words = self._words_of(case)
        for lane in range(LANES):  # lanes without a case contain valid numbers, and the kinds that all cases share
            self._move(self._placed(self._words), lane, into=True)

    def go(self, cases: Sequence[Case], stops: Sequence[int]) -> None:
        """Take each case to its own sample, unless it ends before.

        Cases may stay in their lanes: see `release`.
        """
        pairs = list(zip(cases, stops, strict=True))
        fitting = [(case, stop) for case, stop in pairs if self._fits(case)]
        while len(going := [pair for pair in fitting if pair[0].ready(pair[1])]) >= WORTHWHILE:
            present, goals = [case for case, _ in going], [stop for _, stop in going]
            steps = min([stop - case.count for case, stop in going])
            if left := self._forward(present, steps):
                self._leaving(present, goals, left)
            if going[0][0].stopped():
                break
        for case, stop in pairs:
            if case.ready(stop):
                case.go(stop)

    def again(self, cases: list[Case], stops: Sequence[int], rows: Array, at: slice | list[int]) -> bool:
        """Take the cases of the last call all this number of steps further, and write their rows into columns `at`.

        Return False if `go` has to do or to finish this.
        """
        if cases != self._present or stops[0] > cases[0].count + SPAN:
            return False
        if left := self._forward(cases, stops[0] - cases[0].count):
            self._leaving(cases, stops, left)
            return False
        rows[:, at] = self.lanes[: len(rows), self._order]
        return True

    def give(self, cases: list[Case], values: Array) -> bool:
        """Write the values (cases, k) of an external command for the cases of the last call.

        Return whether these are the same cases.
        """
        if cases != self._present or self._given is None:
            return False
        self.lanes[self._given, self._order] = values.T
        return True

    def _leaving(self, cases: Sequence[Case], stops: Sequence[int], left: int) -> None:
        for case, stop in zip(cases, stops, strict=True):
            if left >> self._cases.index(case) & 1:
                self._leave(case, stop)

    def _forward(self, cases: list[Case], steps: int) -> int:
        """Take cases this number of steps further, or fewer; return the bits of the lanes that have to leave."""
        self._enter(cases)
        self._progress[ways.STEPS], self._progress[ways.ALIVE] = min(steps, SPAN), self._alive
        self._advance.unlocked()
        return self._progress[ways.LEFT]

    def release(self, case: Case) -> None:
        """Move a case from its lane to its own arrays."""
        lane = self._cases.index(case)
        self._move(self._arrays[lane], lane, into=False)
        self._out(case)

    def show(self, cases: Sequence[Case], rows: Array, columns: Sequence[int]) -> None:
        """Write the rows of the cases in lanes here into columns of `rows`."""
        pairs = [(case, at) for case, at in zip(cases, columns, strict=True) if case.home is self]
        if pairs:
            lanes = [self._cases.index(case) for case, _ in pairs]
            rows[:, [at for _, at in pairs]] = self.lanes[: len(rows), lanes]

    def _enter(self, going: list[Case]) -> None:
        """Move these cases to lanes, and the others out: the next call would overwrite them."""
        if going == self._present:
            return
        for case in self._cases:
            if case is not None and case not in going:
                self.release(case)
        for case in going:
            if case not in self._cases:
                case.leave_block()
                self._take(case, self._cases.index(None))
        motions = [self._motion_struct(case) for case in going]
        self._alike[0] = all(np.array_equal(motion, motions[0]) for motion in motions[1:])
        self._alive = sum(1 << lane for lane, case in enumerate(self._cases) if case is not None)
        lanes = [self._cases.index(case) for case in going]
        self._present, self._order = going, slice(len(going)) if lanes == list(range(len(going))) else lanes

    def _take(self, case: Case, lane: int) -> None:
        if self._tables[lane][0] is not case.pipeline.whole:  # cases before may have had its loop and this lane
            self._tables[lane] = case.pipeline.whole, self._enlist(case, lane)
        self._move(self._tables[lane][1], lane, into=True)
        motion = _compiled(case.pipeline.bound[self._motion])
        self._motions[lane] = motion.operation, motion.place
        self._kept[lane] = address(case.out)
        needed, bit = case.pipeline.when != NEVER, 1 << lane
        column = self._table[:-1, ways.IN]
        column[:] = np.where(needed, column | bit, column & ~bit)
        self._cases[lane], case.home, case.joined = case, self, case.count

    def _enlist(self, case: Case, lane: int) -> Words:
        """Write the addresses of a case into the tables of a lane; return those of its arrays."""
        loop, (_, words) = case.loop, case.known[self]
        assert words is not None
        placed = self._placed(words)
        self._arrays[lane] = placed[self._recipe.moved]
        whole, (standing, time) = case.pipeline.whole, case.pipeline.standing
        self._pipelines[lane] = whole.operation, whole.place, address(standing), address(time)
        desired = address(loop.desired)
        self._desired[lane] = desired, loop.desired.size, (desired - int(placed[0, 0])) // ways.WORD  # of the row
        return placed

    def _out(self, case: Case) -> None:
        self._cases[self._cases.index(case)] = None
        self._present = []
        case.home, case.figures.samples = None, case.count

    def _leave(self, case: Case, stop: int) -> None:
        """Move a case to its own arrays for Python; a case that leaves often continues alone for a while."""
        self._out(case)
        case.rest = 0 if case.count >= case.joined + SOON else min(2 * case.rest + SOON, LONGEST)
        case.finish_step(self._complete)
        if case.rest and case.ready(stop):
            case.go(min(case.count + case.rest, stop))

    def _lifted(self, given: object) -> object:
        """Return an argument in the layout of the block."""
        if not isinstance(given, View):
            return given
        first = int(self._starts[given.root]) + given.first
        return self.lanes[first : first + math.prod(given.shape)].reshape(*given.shape, LANES)

    def _placed(self, words: Words) -> Words:
        """Return address, size and first row of the arrays of a case, (roots, 3)."""
        placed = self._roots.copy()
        placed[:, 0] = words[self._recipe.words] - self._recipe.offsets
        return placed

    def _move(self, placed: Words, lane: int, *, into: bool) -> None:
        """Copy arrays of a case into a lane, or back."""
        self._moving[: len(placed)] = placed
        self._moved[:] = lane, into, len(placed)
        self._mover()

    def _motion_struct(self, case: Case) -> Words:
        """Return the struct of the motion of a case, without the addresses of outputs."""
        words = _words(case.pipeline.bound[self._motion])
        used: Words = words[words != address(case.loop.desired)]
        return used

    def _words_of(self, case: Case) -> Words:
        """Return addresses of the arrays of a case, then the structs of its operations, in the order of the recipe."""
        bound = _bounds(case)
        moved = np.array([address(array) for array in _memory(case)])
        wide = (bound[at] for at in self._wide if at < len(bound))
        return np.concatenate([moved, *(_words(found) for found in wide if found is not None)])

    def _fits(self, case: Case) -> bool:
        """Return whether a case has the structure of this block."""
        found = case.known.get(self)
        if found is None or found[0] is not case.pipeline:
            words = self._words_of(case) if case.going and case.loop.memory is not None else None
            fitting = words is not None and self._alike_in_structure(case, words)
            found = case.known[self] = case.pipeline, words if fitting else None
        return found[1] is not None

    def _alike_in_structure(self, case: Case, words: Words) -> bool:
        recipe, mine, calls = self._recipe, self._words, _operations(case)
        if [operation.name for operation in calls] != [operation.name for operation in self._operations] or len(
            words
        ) != len(mine):
            return False
        if [array.size for array in _memory(case)] != self._sizes:
            return False
        pairs = list(zip(_bounds(case), self._bound, strict=True))
        if any(_name(pairs[at][0]) != _name(pairs[at][1]) for at in self._wide):
            return False
        given = [[_native(each).given[name] for each in pairs[at]] for at, name in recipe.given]
        if any(one.shape != other.shape or whole(one).size != whole(other).size for one, other in given):
            return False
        shared = [[_native(each).given[name] for each in pairs[at]] for at, name in recipe.shared]
        for name, kinds in KINDS.items():
            tabled = [at for at in self._wide if name in _native(self._bound[at]).given]
            shared += [[_native(each).given[name][:, kinds] for each in pairs[at]] for at in tabled]
        return (
            np.array_equal(words[recipe.fixed], mine[recipe.fixed])
            and all(words[word] - offset == _address(words, recipe.roots[root]) for word, root, offset in recipe.again)
            and all(np.array_equal(*pair) for pair in shared)
        )


def _memory(case: Case) -> list[Array]:
    """Return the arrays that the steps of a case change."""
    memory = case.loop.memory
    if memory is None:
        raise UnfitError
    return [*memory, case.figures.values]


def _operations(case: Case) -> list[Operation]:
    """Return the operations of a step, and last the one that counts each complete sample."""
    return [*case.pipeline.operations, Operation("", case.figures.counting)]


def _bounds(case: Case) -> list[Compiled | None]:
    return [*case.pipeline.bound, case.figures.counting]


def _way(operation: Operation, found: Compiled | None, case: Case) -> int:
    """Return how an operation is run."""
    if operation in (COMPLETE, NEXT):
        return ways.COMPLETE if operation is COMPLETE else ways.NEXT
    if operation.due:
        return ways.EVENTS
    if found is None:
        raise UnfitError
    if operation.name == "trajectory":
        return ways.MOTION
    if operation.name == "time":
        return ways.TIME
    if operation.name == "solver" and getattr(case.loop.parts.solver, "follows", False):
        return ways.ALONE  # in lanes it would overwrite the previous answer
    vector = isinstance(found, Bound) and f"{found.name}_lanes" in operations()
    return ways.IN_LANES if vector else ways.ALONE  # in lanes it takes no time, as that may differ


def _together(found: Sequence[int], skips: Sequence[int], complete: int) -> list[int]:
    """Return the number of operations after which a case without a result rejoins the others.

    No operation in between may skip more than that; operations that run alone are consecutive.

    Raises:
        UnfitError: if these are not in one part of a step.
    """
    joins = [at + 1 + skip for at, skip in enumerate(skips)]
    for at in reversed(range(len(found))):
        while (after := joins[at]) < max(joins[at:after]):
            joins[at] = max(joins[at:after])
        if found[at] == ways.ALONE and after < len(found) and found[after] == ways.ALONE:
            joins[at] = joins[after]
    if any(at <= complete < join - 1 for at, join in enumerate(joins)):
        raise UnfitError
    return [join - at for at, join in enumerate(joins)]


def _native(found: Compiled | None) -> Bound:
    assert isinstance(found, Bound)
    return found


def _compiled(found: Compiled | None) -> Compiled:
    assert found is not None
    return found


def _name(found: Compiled | None) -> str | None:
    return found.name if isinstance(found, Bound) else None


def _words(found: Compiled | None) -> Words:
    """Return the struct of an operation as numbers of 8 bytes."""
    words: Words = np.frombuffer(_compiled(found).words, dtype=np.int64)
    return words


def _address(words: Words, root: Root) -> int:
    return int(words[root.word]) - root.offset
