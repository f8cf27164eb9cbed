"""How fast to go along a path: compiled, for a path has as many sections as its program lines, and more."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cdpr.model.jit import kernel
from cdpr.model.robot import Array

Indices = NDArray[np.int64]

# What an entry of the stack is: a stretch to be planned, one passed at a constant speed, or a change of speed.
STRETCH, CRUISE, RAMP = 0.0, 1.0, 2.0

HALVINGS = 200  # of an interval of speeds: more than floats have digits


@kernel
def ramp_way(slow: float, fast: float, acceleration: float, jerk: float) -> float:
    """Return the way, m, on which the speed changes between two values, m/s, without acceleration at both."""
    change = fast - slow
    if change <= 0.0:
        return 0.0
    if change * jerk >= acceleration * acceleration:
        time = change / acceleration + acceleration / jerk
    else:
        time = 2.0 * math.sqrt(change / jerk)
    return 0.5 * (slow + fast) * time


@kernel
def grow(tree: Indices, values: Array, base: int, count: int) -> None:
    """Fill a tree in which the sections of the least values of a chain are found."""
    for i in range(count):
        tree[2 * base + count + i] = i
    for i in range(count - 1, 0, -1):
        one, other = tree[2 * base + 2 * i], tree[2 * base + 2 * i + 1]
        tree[2 * base + i] = other if values[base + other] < values[base + one] else one


@kernel
def lowest(tree: Indices, caps: Array, base: int, count: int, first: int, last: int) -> int:
    """Return the section of the least value among those from `first` to `last`, counted within the chain."""
    best = first
    left, right = first + count, last + count + 1
    while left < right:
        if left & 1:
            other = tree[2 * base + left]
            if caps[base + other] < caps[base + best] or (caps[base + other] == caps[base + best] and other < best):
                best = other
            left += 1
        if right & 1:
            right -= 1
            other = tree[2 * base + right]
            if caps[base + other] < caps[base + best] or (caps[base + other] == caps[base + best] and other < best):
                best = other
        left //= 2
        right //= 2
    return best


@kernel
def change_way(
    slow: float,
    fast: float,
    place: float,
    onward: bool,
    starts: Array,
    accelerations: Array,
    jerks: Array,
    tree: Indices,
    base: int,
    count: int,
    first: int,
    last: int,
) -> tuple[float, float, float]:
    """Return the way of a change of speed, and the acceleration and jerk that all sections which it touches allow.

    It begins at `place`, where section `first` does, or ends there, where section `last` does.
    """
    near, far = first, last
    if onward:
        far = first
    else:
        near = last
    while True:
        strictest = base + lowest(tree, jerks, base, count, near, far)
        acceleration, jerk = accelerations[strictest], jerks[strictest]
        way = ramp_way(slow, fast, acceleration, jerk)
        if onward:
            if far == last or place + way <= starts[base + far + 1]:
                break
            low, high = far + 1, last  # the last section that begins before the change ends
            while low < high:
                middle = (low + high + 1) // 2
                if starts[base + middle] < place + way:
                    low = middle
                else:
                    high = middle - 1
            far = low
        else:
            if near == first or place - way >= starts[base + near]:
                break
            low, high = first, near - 1  # the first section that ends behind where the change begins
            while low < high:
                middle = (low + high) // 2
                if starts[base + middle + 1] > place - way:
                    high = middle
                else:
                    low = middle + 1
            near = low
    return way, acceleration, jerk


@kernel
def put(phases: Array, row: int, time: float, s: float, v: float, a: float, jerk: float) -> int:
    """Append a phase: duration, s, speed, acceleration at its beginning, jerk; return the next row."""
    if time <= 0.0:
        return row
    if row > 0 and jerk == 0.0 and a == 0.0 and phases[row - 1, 4] == 0.0 and phases[row - 1, 3] == 0.0:
        before = phases[row - 1]
        if before[2] == v and v > 0.0 and s > before[1]:  # goes on at the same speed, and in the same chain
            before[0] = (s - before[1]) / v + time
            return row
    phases[row, 0], phases[row, 1], phases[row, 2], phases[row, 3], phases[row, 4] = time, s, v, a, jerk
    return row + 1


@kernel
def ramp(phases: Array, row: int, s: float, begin: float, end: float, acceleration: float, jerk: float) -> int:
    """Append a change of speed from `begin` to `end`, m/s, which begins at s; return the next row."""
    change = abs(end - begin)
    sign = 1.0 if end > begin else -1.0
    if change == 0.0:
        return row
    steady = 0.0
    if change * jerk >= acceleration * acceleration:
        rise = acceleration / jerk
        steady = max(change / acceleration - rise, 0.0)
    else:
        rise = math.sqrt(change / jerk)
    a, j, v = sign * jerk * rise, sign * jerk, begin
    row = put(phases, row, rise, s, v, 0.0, j)
    s += rise * (v + j * rise * rise / 6.0)
    v += 0.5 * a * rise
    row = put(phases, row, steady, s, v, a, 0.0)
    s += steady * (v + 0.5 * a * steady)
    v += a * steady
    return put(phases, row, rise, s, v, a, -j)


@kernel
def pace(
    starts: Array,
    caps: Array,
    accelerations: Array,
    jerks: Array,
    chains: Indices,
    trees: Indices,
    stack: Array,
    phases: Array,
    rows: Indices,
) -> None:
    """Plan each chain of sections from rest to rest, with jerk limited and no section passed faster than its cap.

    A stretch is planned at the least cap of its sections. Where that is reached, the section that it belongs to is
    passed at it, and what lies before and after is planned anew, without this section: its caps are higher. So no
    speed is above a cap by construction, and each step ends with one section less.

    Args:
        starts: (N + 1,) where the sections begin, and the last one ends, m; increasing.
        caps: (N,) largest speed in each, m/s.
        accelerations: (N,) largest along the path in each, m/s^2.
        jerks: (N,) likewise, m/s^3; both are least in the same section.
        chains: (C + 1,) first section of each chain, and N.
        trees: (2, 2 N) to work in.
        stack: (2 N + 8, 9) likewise.
        phases: (8 N + 7 C, 5) for the result: duration, s, and speed, acceleration at the beginning, jerk.
        rows: (C + 1,) for the first phase of each chain, and how many there are.
    """
    row = 0
    for chain in range(chains.shape[0] - 1):
        rows[chain] = row
        base, count = chains[chain], chains[chain + 1] - chains[chain]
        grow(trees[0], caps, base, count)
        grow(trees[1], jerks, base, count)
        stack[0, 0], stack[0, 1], stack[0, 2] = STRETCH, starts[base], starts[base + count]
        stack[0, 3], stack[0, 4], stack[0, 5], stack[0, 6] = 0.0, 0.0, 0.0, float(count - 1)
        top = 1
        while top > 0:
            top -= 1
            kind, begin, end, v0, v1 = stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3], stack[top, 4]
            if kind == CRUISE:
                row = put(phases, row, (end - begin) / v0, begin, v0, 0.0, 0.0)
                continue
            if kind == RAMP:
                row = ramp(phases, row, begin, v0, v1, stack[top, 7], stack[top, 8])
                continue
            first, last = int(stack[top, 5]), int(stack[top, 6])
            section = lowest(trees[0], caps, base, count, first, last)
            cap, way = max(caps[base + section], v0, v1), end - begin
            rise, a0, j0 = change_way(
                v0, cap, begin, True, starts, accelerations, jerks, trees[1], base, count, first, last
            )
            fall, a1, j1 = change_way(
                v1, cap, end, False, starts, accelerations, jerks, trees[1], base, count, first, last
            )
            if rise + fall >= way:  # the cap is not reached
                low, high = max(v0, v1), cap
                for _ in range(HALVINGS):
                    middle = 0.5 * (low + high)
                    if middle <= low or middle >= high:
                        break
                    up, _, _ = change_way(
                        v0, middle, begin, True, starts, accelerations, jerks, trees[1], base, count, first, last
                    )
                    down, _, _ = change_way(
                        v1, middle, end, False, starts, accelerations, jerks, trees[1], base, count, first, last
                    )
                    if up + down > way:
                        high = middle
                    else:
                        low = middle
                rise, a0, j0 = change_way(
                    v0, low, begin, True, starts, accelerations, jerks, trees[1], base, count, first, last
                )
                fall, a1, j1 = change_way(
                    v1, low, end, False, starts, accelerations, jerks, trees[1], base, count, first, last
                )
                row = ramp(phases, row, begin, v0, low, a0, j0)
                if low > 0.0:
                    row = put(phases, row, (way - rise - fall) / low, begin + rise, low, 0.0, 0.0)
                row = ramp(phases, row, end - fall, low, v1, a1, j1)
                continue
            there, back = begin + rise, end - fall
            x = min(max(starts[base + section], there), back)
            y = min(max(starts[base + section + 1], there), back)
            # On a stack: what comes last is done first.
            stack[top, 0] = STRETCH if y < back and section < last else RAMP
            stack[top, 1], stack[top, 2], stack[top, 3], stack[top, 4] = y, end, cap, v1
            stack[top, 5], stack[top, 6] = float(section + 1), float(last)
            stack[top, 7], stack[top, 8] = a1, j1
            stack[top + 1, 0], stack[top + 1, 1], stack[top + 1, 2] = CRUISE, x, y
            stack[top + 1, 3], stack[top + 1, 4] = cap, cap
            top += 2
            stack[top, 0] = STRETCH if x > there and section > first else RAMP
            stack[top, 1], stack[top, 2], stack[top, 3], stack[top, 4] = begin, x, v0, cap
            stack[top, 5], stack[top, 6] = float(first), float(section - 1)
            stack[top, 7], stack[top, 8] = a0, j0
            top += 1
    rows[chains.shape[0] - 1] = row
