"""Eight cases side by side: their acts with arrays of lanes in place of each one's own, as far as lanes do them.

The arrays of the cases stand in one block, a lane each. While all goes its usual way nothing else is touched. Where an
act does not serve a case, such as a solver where limits are in the way, that case's own program does it on its own
arrays, up to where the others wait. What needs Python is done by each case alone, and they come together again later.
So each case is what it is alone, to the bit.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr.cables import exits_of
from cdpr.model.bound import Bound, bound, taken_apart
from cdpr.model.jit import Kernel
from cdpr.model.lanes import WIDTH
from cdpr.model.robot import Array
from cdpr.plugins import CompiledSolver, TensionSolver
from cdpr.rollouts import advance as go
from cdpr.rollouts.advance import Cases, Kept, advance, move
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
GIVEN = 5  # arguments of a solver's kernel before its parameters

Words = NDArray[np.int64]


class Eights:
    """What goes on with up to eight cases that are made alike.

    Args:
        plan: what all cases of the rollout share.
        case: one of them, begun. Raises UnfitError where such cannot go side by side.
    """

    def __init__(self, plan: Plan, case: Case) -> None:
        self._plan, self._parts, memory = plan, case.loop.parts, _memory(case)
        if exits_of(self._parts.robot):
            raise UnfitError
        self._acts = acts = _acts(case)
        self._does = does = [
            _kind(act, found, self._parts.solver) for act, found in zip(acts, _bounds(case), strict=True)
        ]
        self._wide = [at for at, each in enumerate(does) if each in (go.SIDE_BY_SIDE, go.ANSWERING)]
        self._recipe = recipe = Recipe(memory)
        given = []
        for at in self._wide:
            used = GIVEN if does[at] == go.ANSWERING else None
            given.append(recipe.read(at, taken_apart(acts[at].do)[1], used))
        self._moved, sizes = len(memory), [root.size for root in recipe.roots]
        self._starts = np.cumsum([0, *sizes])
        self._block = _aligned((int(self._starts[-1]), WIDTH))
        self._table = np.zeros((len(acts), 5), dtype=np.int64)
        self._table[:, go.DOES] = does
        self._table[:, go.TOGETHER] = [1 + act.skip for act in acts]
        self._held = [self._of_lanes(acts[at], arguments) for at, arguments in zip(self._wide, given, strict=True)]
        for at, found in zip(self._wide, self._held, strict=True):
            self._table[at, [go.CALLED, go.GIVEN]] = found.entry, found.place
        self._complete, self._motion = does.index(go.COMPLETE), does.index(go.MOTION)
        self._words, self._parameters = self._words_of(case), _parameters(case)

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

    def _of_lanes(self, act: Act, arguments: Sequence[Any]) -> Bound:
        """Bind what an act does to arrays of the block."""
        function: Any = taken_apart(act.do)[0]
        lifted, wide = [self._lifted(each) for each in arguments], True
        if act.name == "solver":
            solver: Any = self._parts.solver
            lifted += [solver.parameters, _aligned((*solver.work.shape, WIDTH))]
            function, wide = solver.lanes, False
        found = bound(partial(function, *lifted), act.timed, wide)
        if found is None:
            raise UnfitError
        return found

    def _lifted(self, given: Any) -> Any:
        """Return an argument as it stands in the block."""
        if isinstance(given, View):
            first = int(self._starts[given.root]) + given.first
            return self._block[first : first + math.prod(given.shape)].reshape(*given.shape, WIDTH)
        if isinstance(given, tuple):
            parts = [self._lifted(each) for each in given]
            return type(given)(*parts) if hasattr(given, "_fields") else tuple(parts)
        return given

    def _words_of(self, case: Case) -> Words:
        """Where the arrays of a case are, and what else its acts are given; as the recipe says."""
        known = _bounds(case)
        own = [known[at] for at in self._wide if at < len(known)]
        moved = np.array([array.ctypes.data for array in _memory(case)])
        return np.concatenate([moved, *(found.words for found in own if found is not None)])

    def _fits(self, case: Case, words: Words) -> bool:
        """Whether a case is made like the one that this was made of."""
        recipe, mine, acts = self._recipe, self._words, _acts(case)
        if [act.name for act in acts] != [act.name for act in self._acts] or len(words) != len(mine):
            return False
        indices = [[taken_apart(of[at].do)[1][i] for of in (acts, self._acts)] for at, i in recipe.indices]
        return (
            np.array_equal(words[recipe.fixed], mine[recipe.fixed])
            and all(words[word] - offset == _address(words, recipe.roots[root]) for word, root, offset in recipe.again)
            and all(np.array_equal(*pair) for pair in indices)
            and np.array_equal(_parameters(case), self._parameters)
        )

    def _together(self, cases: Sequence[Case], words: Sequence[Words]) -> tuple[int, bool]:
        """Advance cases, until Python has to go on; each then stands by itself.

        Return the sample where they are, and whether the one before is complete but for looking at this one.
        """
        count, first, plan = len(cases), cases[0].loop, self._plan
        lanes = [*range(count), *[0] * (WIDTH - count)]  # those beyond repeat the first case
        roots = self._recipe.roots
        places = list(zip(roots, self._starts[:-1].tolist(), strict=True))
        arrays = np.array([[(_address(words[j], root), root.size, start) for root, start in places] for j in lanes])
        for lane, own in enumerate(arrays):
            move(own, own.ctypes.data, self._block, lane, True)
        described = self._described([cases[j].loop for j in lanes], arrays)
        at = np.array([each.ctypes.data for each in (described.programs, described.arrays, described.desired)])
        rows = np.empty((WIDTH, *cases[0].out.shape))
        counting = self._table[-1, [go.CALLED, go.GIVEN]]
        kept = Kept(counting, plan.places, plan.every, rows)
        place, time = np.zeros(6, dtype=np.int64), np.array([first.time])
        place[go.DUE_AT] = min(_dues(cases), default=-1)
        place[go.AT_SAMPLE] = begun = first.count
        place[go.ALIVE] = (1 << count) - 1
        table = self._table[:-1].copy()
        table[:, go.WHEN] = first.program.when
        code = REACHED
        while code == REACHED and place[go.AT_SAMPLE] < plan.steps and not cases[0].stopped():
            place[go.STOP] = min(plan.steps, place[go.AT_SAMPLE] + BLOCK)
            code = advance(table, place, time, described, at, kept, self._block, self._parts.control_step)
        sample, act = int(place[go.AT_SAMPLE]), int(place[go.AT_ACT])
        since = slice(-(-begun // plan.every), (sample - 1) // plan.every + 1)
        for lane, case in enumerate(cases):
            case.out[since] = rows[lane, since]
            case.figures.samples = sample
            if not place[go.LEFT] >> lane & 1:
                own = described.arrays[lane]
                move(own, own.ctypes.data, self._block, lane, False)
                standing, when = case.loop.program.standing
                standing[[SAMPLE, ACT]], when[:] = (sample, act), time
            if sample:  # it is not there, and is looked for where the next state cannot be true
                ring = case.loop.program.rows
                ring[(sample - 1) % len(ring)] = case.loop.row
        return sample, act > self._complete or act == 0

    def _described(self, loops: Sequence[Loop], arrays: Words) -> Cases:
        """Tell compiled code of the programs of eight cases whose arrays are these, as `Cases` says."""
        motions = [loop.program.bound[self._motion] for loop in loops]
        programs, written, asked = [], [], []
        for loop, motion in zip(loops, motions, strict=True):
            whole, (standing, time) = loop.program.whole, loop.program.standing
            assert whole is not None
            assert motion is not None
            place = standing.ctypes.data, standing.size, time.ctypes.data, time.size
            programs.append((whole.entry, whole.place, *place))
            written.append(loop.desired.ctypes.data)
            asked.append(motion.words[motion.words != written[-1]])
        alike = all(np.array_equal(each, asked[0]) for each in asked)
        start = (written[0] - int(arrays[0, 0, go.ADDRESS])) // go.WORD  # of the row, which is the first of them
        return Cases(
            programs=np.array(programs),
            arrays=np.ascontiguousarray(arrays[:, : self._moved]),
            motions=np.array([(each.entry, each.place) for each in motions if each is not None])[
                : 1 if alike else None
            ],
            desired=np.array([(address, loops[0].desired.size, start) for address in written]),
        )


def _memory(case: Case) -> list[Array]:
    """The arrays that the steps of a case change."""
    memory = case.loop.memory
    if memory is None:
        raise UnfitError
    return [*memory, case.figures.values]


def _acts(case: Case) -> list[Act]:
    """What a case does in a step, and last what looks at each complete sample."""
    return [*case.loop.program.acts, Act("", case.figures.counting)]


def _bounds(case: Case) -> list[Bound | None]:
    return [*case.loop.program.bound, bound(case.figures.counting)]


def _kind(act: Act, known: Bound | None, solver: TensionSolver) -> int:
    """How an act is done of cases side by side."""
    if act in (COMPLETE, NEXT):
        return go.COMPLETE if act is COMPLETE else go.NEXT
    if act.due:
        return go.PYTHON
    function = taken_apart(act.do)[0]
    if known is None or not isinstance(function, Kernel):
        raise UnfitError
    if act.name == "trajectory":
        return go.MOTION
    if act.name == "solver":
        if isinstance(solver, CompiledSolver) and isinstance(solver.lanes, Kernel) and function is solver.kernel:
            return go.ALONE if solver.follows else go.ANSWERING
        return go.ALONE
    if not function.any_width:
        raise UnfitError
    return go.SIDE_BY_SIDE


def _parameters(case: Case) -> Array:
    """What a case's solver was given beside the problem, as `CompiledSolver` has it."""
    solver = case.loop.parts.solver
    return solver.parameters if isinstance(solver, CompiledSolver) else np.zeros(0)


def _dues(cases: Sequence[Case]) -> list[int]:
    """The samples, from the present one on, at which something is due."""
    dues = ((case.loop.program.due, case.loop.count) for case in cases)
    return [due for due, count in dues if due >= count]


def _address(words: Words, root: Root) -> int:
    return int(words[root.word]) - root.offset


def _aligned(shape: tuple[int, ...]) -> Array:
    """Return zeros that begin where a register of eight is read at once."""
    raw = np.zeros(math.prod(shape) + WIDTH)
    start = -(raw.ctypes.data // raw.itemsize) % WIDTH
    return raw[start : start + math.prod(shape)].reshape(shape)
