"""What runs eight programs side by side, compiled: their acts of lanes, one after the other, step after step.

What an act of lanes has not served is done by the program of each such case alone, up to where the others wait for it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cdpr.model.deferred import Deferred
from cdpr.model.jit import kernel, threaded_kernel
from cdpr.model.kinds import CUBE, INDICES, NUMBER, ROW, TABLE, WHOLE, Block, Group
from cdpr.model.lanes import WIDTH
from cdpr.model.robot import Array
from cdpr.simulation.proceed import ACT, ALWAYS, DUE, LAST, LAST_ACT, REACHED, SAMPLE, call_entry

# Columns of the table of acts: what is done; with what is called; when; and how many acts follow, this one included,
# before cases that were not served join the others again.
DOES, CALLED, GIVEN, WHEN, TOGETHER = range(5)
# What is done: nothing but Python's; lanes, which return the bits of those that are not served, or of those that are;
# each case by its own program; the desired motion; the ends of samples.
PYTHON, SIDE_BY_SIDE, ANSWERING, ALONE, MOTION, COMPLETE, NEXT = range(7)

# Where they stand: sample, act, the sample before which they stop, the one at which something is due, which of the
# lanes count, and which were left to Python.
AT_SAMPLE, AT_ACT, STOP, DUE_AT, ALIVE, LEFT = range(6)

# Words of an array of one case: its address, its size, and its first row in `block`.
ADDRESS, SIZE, FIRST = range(3)
WORD = 8  # bytes

take_numbers: Callable[[int], tuple[Array]] = Deferred("taker", (ROW,), 0)
take_wholes: Callable[[int], tuple[NDArray[np.int64]]] = Deferred("taker", (INDICES,), 0)


class Cases(NamedTuple):
    """The programs of eight cases."""

    programs: NDArray[np.int64]  # (8, 6): entry and arguments of `proceed`; address and size of `place` and of `time`
    arrays: NDArray[np.int64]  # (8, R, 3): the arrays that their steps change, as ADDRESS says
    motions: NDArray[np.int64]  # (n, 2): entries and arguments of what writes the desired motion, one for all or eight
    desired: NDArray[np.int64]  # (8, 3): where that is written, likewise


class Kept(NamedTuple):
    """What is kept of the rows."""

    counting: NDArray[np.int64]  # (2,): entry and arguments of what looks at each complete sample
    places: NDArray[np.int64]  # (W,): columns that are kept, as rows of `block`
    every: int  # samples from one that is kept to the next
    rows: Array  # (8, K, W), written


INT_TABLE, INT_CUBE = Block(WHOLE, 2), Block(WHOLE, 3)
CASES = Group((INT_TABLE, INT_CUBE, INT_TABLE, INT_TABLE), Cases)
KEPT = Group((INDICES, INDICES, WHOLE, CUBE), Kept)


@kernel
def move(arrays: NDArray[np.int64], place: int, block: Array, lane: int, gathering: bool) -> None:
    """Copy arrays (R, 3), whose words stand at `place`, into a lane of the block (M, 8), or from there."""
    for r in range(arrays.shape[0]):
        one = take_numbers(place + 3 * WORD * r)[0]
        first = arrays[r, FIRST]
        if gathering:
            for i in range(one.shape[0]):
                block[first + i, lane] = one[i]
        else:
            for i in range(one.shape[0]):
                one[i] = block[first + i, lane]


@kernel
def alone(program: NDArray[np.int64], place: int, sample: int, act: int, until: int, time: float) -> bool:
    """Let a program, whose words stand at `place`, do the acts of a sample up to `until`; whether it came there."""
    standing = take_wholes(place + 2 * WORD)[0]
    standing[SAMPLE], standing[ACT] = sample, act
    standing[LAST], standing[LAST_ACT] = sample, until
    take_numbers(place + 4 * WORD)[0][0] = time
    if call_entry(program[0], program[1], 0.0) == REACHED:
        return True
    standing[SAMPLE], standing[ACT] = sample, act
    return False


@kernel
def follow(cases: Cases, words: int, block: Array, time: float) -> None:
    """Write the desired motion of all lanes, each by its own program's, or by the first one's where all are alike."""
    motions, desired = cases.motions, cases.desired
    for lane in range(motions.shape[0]):
        call_entry(motions[lane, 0], motions[lane, 1], time)
        one = take_numbers(words + 3 * WORD * lane)[0]
        first = desired[lane, FIRST]
        for i in range(one.shape[0]):
            if motions.shape[0] > 1:
                block[first + i, lane] = one[i]
            else:
                for other in range(WIDTH):
                    block[first + i, other] = one[i]


@threaded_kernel(WHOLE(INT_TABLE, INDICES, ROW, CASES, INDICES, KEPT, TABLE, NUMBER))
def advance(
    table: NDArray[np.int64],
    place: NDArray[np.int64],
    time: Array,
    cases: Cases,
    words: NDArray[np.int64],
    kept: Kept,
    block: Array,
    period: float,
) -> int:
    """Go on from where they stand until STOP, or until Python has to go on: return REACHED or 0.

    `words` are the addresses of `programs`, `arrays` and `desired` in `cases`. Cases that are LEFT to Python stand by
    themselves at the act that has not served them, their arrays written; the others where `place` says, in the block.
    """
    sample, act, alive = place[AT_SAMPLE], place[AT_ACT], place[ALIVE]
    count, size = table.shape[0], cases.arrays.shape[1]
    waiting, left, join, code = 0, 0, -1, 0
    while True:
        if act == join:
            for lane in range(WIDTH):
                if waiting >> lane & 1:
                    move(cases.arrays[lane], words[1] + 3 * WORD * size * lane, block, lane, True)
            waiting, join = 0, -1
            if left != 0:
                break
        if act == count:
            act = 0
        if act == 0 and sample == place[STOP]:
            code = REACHED
            break
        does, when = table[act, DOES], table[act, WHEN]
        if when == ALWAYS or (when == DUE and sample == place[DUE_AT]):
            missing = 0
            if does == SIDE_BY_SIDE:
                missing = call_entry(table[act, CALLED], table[act, GIVEN], time[0])
            elif does == ANSWERING:
                missing = ~call_entry(table[act, CALLED], table[act, GIVEN], time[0])
            elif does == ALONE:
                missing = -1
            elif does == MOTION:
                follow(cases, words[2], block, time[0])
            elif does == COMPLETE:
                call_entry(kept.counting[0], kept.counting[1], 0.0)
                if sample % kept.every == 0:
                    for lane in range(WIDTH):
                        if alive >> lane & 1:
                            for i in range(kept.places.shape[0]):
                                kept.rows[lane, sample // kept.every, i] = block[kept.places[i], lane]
                sample += 1
            elif does == NEXT:
                time[0] = sample * period
            else:
                break
            missing &= alive & ~waiting & ~left
            if missing != 0:
                if join < 0:
                    join = act + table[act, TOGETHER]
                for lane in range(WIDTH):
                    if missing >> lane & 1:
                        arrays, at = cases.arrays[lane], words[1] + 3 * WORD * size * lane
                        move(arrays, at, block, lane, False)
                        program = cases.programs[lane]
                        if alone(program, words[0] + 6 * WORD * lane, sample, act, join % count, time[0]):
                            waiting |= 1 << lane
                        else:
                            move(arrays, at, block, lane, False)
                            left |= 1 << lane
        act += 1
    place[AT_SAMPLE], place[AT_ACT], place[LEFT] = sample, act, left
    return code
