"""Eight cases side by side: their acts with arrays of lanes in place of each one's own, as far as lanes do them.

The arrays of the cases stand in one block, a lane each. While all goes its usual way nothing else is touched. Where an
act does not serve a case, such as a solver where limits are in the way, that case's own program does it on its own
arrays, up to where the others wait. What needs Python is done by each case alone, and they come together again later.
So each case is what it is alone, to the bit.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cdpr.model.robot import Array
from cdpr.native.bind import Compiled, bind
from cdpr.native.library import Bound
from cdpr.native.operations import LANES, operations
from cdpr.rollouts import advance as go
from cdpr.rollouts.case import Case, Plan
from cdpr.rollouts.recipe import Recipe, Root, UnfitError, View
from cdpr.simulation.loop import Loop
from cdpr.simulation.proceed import ACT, REACHED, SAMPLE
from cdpr.simulation.program import COMPLETE, NEXT
from cdpr.tension.acts import Act

BLOCK = 16384  # samples that go by before somebody asks whether to stop: some hundredths of a second
WORTHWHILE = 3  # cases: fewer are as fast alone
# Cases that come not even so far together, in samples, go on alone as far, then ever further up to the longest.
SOON, LONGEST = 16, 1024

EXIT_KIND = slice(6, 7)  # column of the tables of cables, `cdpr/native/include/cdpr/line.hpp`

Words = NDArray[np.int64]


class Eights:
    """What goes on with up to eight cases that are made alike.

    Args:
        plan: what all cases of the rollout share.
        case: one of them, begun. Raises UnfitError where such cannot go side by side.
    """

    def __init__(self, plan: Plan, case: Case) -> None:
        self._plan, self._parts, memory = plan, case.loop.parts, _memory(case)
        self._acts, self._bound = _acts(case), _bounds(case)
        bound = self._bound
        ways = [_way(act, found, self._parts.solver) for act, found in zip(self._acts, bound, strict=True)]
        self._wide = [at for at, way in enumerate(ways) if way == go.IN_LANES]
        self._recipe = recipe = Recipe(memory)
        given = [recipe.read(at, _native(bound[at])) for at in self._wide]
        self._starts = np.cumsum([0, *(root.size for root in recipe.roots)])
        self._block = np.zeros((int(self._starts[-1]), LANES))
        self._table = np.zeros((len(ways), 5), dtype=np.int64)
        self._table[:, go.WAY] = ways
        self._table[:, go.TOGETHER] = _together(ways, [act.skip for act in self._acts])
        self._held = []
        for at, arguments in zip(self._wide, given, strict=True):
            lifted = {name: self._lifted(each) for name, each in arguments.items()}
            self._held.append(bind(f"{_native(bound[at]).name}_lanes", **lifted))
            self._table[at, [go.OPERATION, go.PLACE]] = self._held[-1].operation, self._held[-1].place
        self._complete, self._motion = ways.index(go.COMPLETE), ways.index(go.MOTION)
        self._words = self._words_of(case)

    def run(self, cases: Sequence[Case]) -> None:
        """Go on with cases, begun and at one sample, as far as they go together; some may end early meanwhile."""
        steps, alone = self._plan.steps, 0
        words = {id(case): self._words_of(case) for case in cases}
        cases = [case for case in cases if self._fits(case, words[id(case)])]
        while len(cases := [case for case in cases if case.going]) >= WORTHWHILE:
            begun = cases[0].loop.count
            if begun == steps:
                return
            whens = [case.loop.program.when for case in cases]
            if all(np.array_equal(when, whens[0]) for when in whens):
                reached, complete = self._together(cases, [words[id(case)] for case in cases])
                for case in cases:
                    case.come(reached if complete else reached + 1)
                alone = 0 if reached >= begun + SOON else min(2 * alone + SOON, LONGEST)
                until = reached + alone
            else:  # of some a cable is held and of others not, say
                until = min(_dues(cases), default=steps)
            for case in cases:
                if case.going and case.loop.count < until:
                    case.go(min(until, steps))

    def _lifted(self, given: object) -> object:
        """Return an argument as it stands in the block."""
        if not isinstance(given, View):
            return given
        first = int(self._starts[given.root]) + given.first
        return self._block[first : first + math.prod(given.shape)].reshape(*given.shape, LANES)

    def _words_of(self, case: Case) -> Words:
        """Return addresses of the arrays of a case, then the structs of its acts, as the recipe says."""
        bound = _bounds(case)
        moved = np.array([array.ctypes.data for array in _memory(case)])
        wide = (bound[at] for at in self._wide if at < len(bound))
        return np.concatenate([moved, *(_words(found) for found in wide if found is not None)])

    def _fits(self, case: Case, words: Words) -> bool:
        """Return whether a case is made like the one that this was made of."""
        recipe, mine, acts = self._recipe, self._words, _acts(case)
        if [act.name for act in acts] != [act.name for act in self._acts] or len(words) != len(mine):
            return False
        pairs = list(zip(_bounds(case), self._bound, strict=True))
        if any(_name(pairs[at][0]) != _name(pairs[at][1]) for at in self._wide):
            return False
        shared = [[_native(each).given[name] for each in pairs[at]] for at, name in recipe.shared]
        # Kernels take the kind of an exit from the first lane.
        lined = [at for at in self._wide if "lines" in _native(self._bound[at]).given]
        shared += [[_native(each).given["lines"][:, EXIT_KIND] for each in pairs[at]] for at in lined]
        return (
            np.array_equal(words[recipe.fixed], mine[recipe.fixed])
            and all(words[word] - offset == _address(words, recipe.roots[root]) for word, root, offset in recipe.again)
            and all(np.array_equal(*pair) for pair in shared)
        )

    def _together(self, cases: Sequence[Case], words: Sequence[Words]) -> tuple[int, bool]:
        """Advance cases, until Python has to go on; each then stands by itself.

        Return the sample where they are, and whether the one before is complete but for looking at this one.
        """
        count, first, plan = len(cases), cases[0].loop, self._plan
        lanes = [*range(count), *[0] * (LANES - count)]  # those beyond repeat the first case
        roots = self._recipe.roots
        places = list(zip(roots, self._starts[:-1].tolist(), strict=True))
        arrays = np.array([[(_address(words[j], root), root.size, start) for root, start in places] for j in lanes])
        for lane, own in enumerate(arrays):
            _move(own, self._block, lane, True)
        moved = np.take(arrays, self._recipe.moved, axis=1)
        rows = np.empty((LANES, *cases[0].out.shape))
        place, time = np.zeros(6, dtype=np.int64), np.array([first.time])
        place[go.DUE_AT] = min(_dues(cases), default=-1)
        place[go.AT_SAMPLE] = begun = first.count
        place[go.ALIVE] = (1 << count) - 1
        table = self._table[:-1].copy()
        table[:, go.WHEN] = first.program.when
        advance = bind(
            "advance",
            table=table,
            place=place,
            time=time,
            arrays=moved,
            counting=self._table[-1, [go.OPERATION, go.PLACE]],
            columns=plan.places,
            rows=rows,
            block=self._block,
            period=self._parts.control_step,
            every=plan.every,
            **self._described([cases[j].loop for j in lanes], arrays),
        )
        code = REACHED
        while code == REACHED and place[go.AT_SAMPLE] < plan.steps and not cases[0].stopped():
            place[go.STOP] = min(plan.steps, place[go.AT_SAMPLE] + BLOCK)
            code = advance.unlocked()
        sample, act = int(place[go.AT_SAMPLE]), int(place[go.AT_ACT])
        since = slice(-(-begun // plan.every), (sample - 1) // plan.every + 1)
        for lane, case in enumerate(cases):
            case.out[since] = rows[lane, since]
            case.figures.samples = sample
            if not place[go.LEFT] >> lane & 1:
                _move(moved[lane], self._block, lane, False)
                standing, when = case.loop.program.standing
                standing[[SAMPLE, ACT]], when[:] = (sample, act), time
            if sample:  # it is not there, and is looked for where the next state cannot be true
                ring = case.loop.program.rows
                ring[(sample - 1) % len(ring)] = case.loop.row
        return sample, act > self._complete or act == 0

    def _described(self, loops: Sequence[Loop], arrays: Words) -> dict[str, Words]:
        """Return the programs of eight cases whose arrays are these, as `advance` takes them."""
        motions = [_compiled(loop.program.bound[self._motion]) for loop in loops]
        programs, written, asked = [], [], []
        for loop, motion in zip(loops, motions, strict=True):
            whole, (standing, time) = loop.program.whole, loop.program.standing
            programs.append((whole.operation, whole.place, standing.ctypes.data, time.ctypes.data))
            written.append(loop.desired.ctypes.data)
            words = _words(motion)
            asked.append(words[words != written[-1]])
        alike = all(np.array_equal(each, asked[0]) for each in asked)
        start = (written[0] - int(arrays[0, 0, go.ADDRESS])) // go.WORD  # of the row, which is the first of them
        return {
            "programs": np.array(programs),
            "motions": np.array([(each.operation, each.place) for each in motions])[: 1 if alike else None],
            "desired": np.array([(address, loops[0].desired.size, start) for address in written]),
        }


def _move(arrays: Words, block: Array, lane: int, into: bool) -> None:
    """Copy arrays (R, 3) of a case into a lane of the block, or from there."""
    bind("move_lane", arrays=arrays, block=block, into=int(into), lane=lane)()


def _memory(case: Case) -> list[Array]:
    """The arrays that the steps of a case change."""
    memory = case.loop.memory
    if memory is None:
        raise UnfitError
    return [*memory, case.figures.values]


def _acts(case: Case) -> list[Act]:
    """What a case does in a step, and last what looks at each complete sample."""
    return [*case.loop.program.acts, Act("", case.figures.counting)]


def _bounds(case: Case) -> list[Compiled | None]:
    return [*case.loop.program.bound, case.figures.counting]


def _way(act: Act, found: Compiled | None, solver: object) -> int:
    """Return how an act is done of cases side by side."""
    if act in (COMPLETE, NEXT):
        return go.COMPLETE if act is COMPLETE else go.NEXT
    if act.due:
        return go.BY_PYTHON
    if found is None:
        raise UnfitError
    if act.name == "trajectory":
        return go.MOTION
    if act.name == "solver" and getattr(solver, "follows", False):
        return go.ALONE  # in lanes it would write over the answer before
    return go.IN_LANES if isinstance(found, Bound) and f"{found.name}_lanes" in operations() else go.ALONE


def _together(ways: Sequence[int], skips: Sequence[int]) -> list[int]:
    """Return after how many acts a case that was not served joins the others: after all that are done alone, too."""
    joins = [at + 1 + skip for at, skip in enumerate(skips)]
    for at in reversed(range(len(ways))):
        after = joins[at]
        if ways[at] == go.ALONE and after < len(ways) and ways[after] == go.ALONE:
            joins[at] = joins[after]
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


def _dues(cases: Sequence[Case]) -> list[int]:
    """The samples, from the present one on, at which something is due."""
    dues = ((case.loop.program.due, case.loop.count) for case in cases)
    return [due for due, count in dues if due >= count]


def _address(words: Words, root: Root) -> int:
    return int(words[root.word]) - root.offset
