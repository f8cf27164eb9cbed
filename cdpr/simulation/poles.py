"""Poles, damping and bandwidth of a closed loop at rest, and their problems.

A mode of the sampled loop changes by a factor z in each control period T; its pole is s = log(z) / T. A pole
s = -zeta w + i w sqrt(1 - zeta^2) is a vibration with the natural frequency w and the damping ratio zeta; a real one
is a decay without vibration, with zeta = 1. Modes that grow have zeta < 0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr.base.errors import CdprError
from cdpr.base.problems import Path
from cdpr.mechanics.limiting_part import limiting_part
from cdpr.mechanics.stability import oscillator, supports_oscillator
from cdpr.model.robot import Array
from cdpr.scenario import Scenario
from cdpr.simulation.columns import chosen_plugins
from cdpr.simulation.linear_map import Linearised
from cdpr.simulation.linearised import linearise
from cdpr.simulation.resting_start import has_feedback
from cdpr.simulation.sensors import seen_sensors

# Multiple eigenvalues, as those of critical damping, are known only to the root of the error of the derivatives.
RESOLVED = 1e-5  # of |z|: smaller growth and decay are not resolved
ENDED = 1e-4  # of z: smaller ones, as those of held commands, end within a period
REPEATED = 0.02  # relative difference of poles that are printed as one
MOVES = 0.5  # share of the largest motion in a mode from which a coordinate is named
FEWEST = 2.0 * math.pi  # samples in the period of a vibration: w T <= 1
LASTS = 0.3  # factor of a mode in a period from which its vibration matters
GRID = 200  # frequencies in the search of a bandwidth

CONTROL_STEP: Path = ("simulation", "control_step")
PHYSICS_STEP: Path = ("simulation", "physics_step")

UNSTABLE, UNDAMPED, STABLE, UNDECIDED = "unstable", "undamped", "stable", "undecided"


@dataclass(frozen=True)
class Pole:
    """Pole of a closed loop.

    Attributes:
        value: pole [1/s, rad/s].
        z: factor of the mode in a control period.
        moves: what moves most: degrees of freedom, "winches", or the "memory" of controller or servos alone.
    """

    value: complex
    z: complex
    moves: tuple[str, ...]

    @property
    def frequency(self) -> float:
        """Natural frequency [Hz]."""
        return abs(self.value) / (2.0 * math.pi)

    @property
    def damping(self) -> float:
        """Damping ratio, negative for a mode that grows."""
        return -self.value.real / abs(self.value) if self.value else 0.0


def poles(loop: Linearised) -> list[Pole]:
    """Return the poles of a loop, the slowest decay first; modes that end within a control period have none.

    Of a conjugate pair the pole with the positive imaginary part comes first.
    """
    z, modes = np.linalg.eig(loop.A)
    lasting = np.flatnonzero(np.abs(z) > ENDED)
    values = (np.log(z[lasting].astype(complex)) / loop.period).tolist()
    moves = _moves(loop, np.abs(modes[:, lasting]))
    found = [Pole(s, complex(z[k]), each) for s, k, each in zip(values, lasting.tolist(), moves, strict=True)]
    return sorted(found, key=_order)


def _order(pole: Pole) -> tuple[float, float, float]:
    """Return numbers that sort poles; a conjugate pair, whose numbers differ by round-off, has the same first two."""
    decay, size = (float(f"{value:.6e}") for value in (-pole.value.real, abs(pole.value)))
    return decay, size, -pole.value.imag


def _moves(loop: Linearised, modes: Array) -> list[tuple[str, ...]]:
    """Return the coordinates with a large share in each mode; `modes` (k, j) are magnitudes."""
    names = [name for name in dict.fromkeys(loop.names) if not name.endswith("'")]
    rows = [[i for i, each in enumerate(loop.names) if each == name] for name in names]
    shares = np.array([modes[each].max(axis=0) for each in rows]).reshape(len(names), modes.shape[1])
    memory = np.isin(names, ("controller", "servo"))
    own, moved = shares[memory].max(axis=0, initial=0.0), shares[~memory]
    most = moved.max(axis=0, initial=0.0)
    large = moved >= MOVES * most
    moving = [name for name, is_memory in zip(names, memory.tolist(), strict=True) if not is_memory]
    return [
        ("memory",) if only else tuple(name for name, is_large in zip(moving, column, strict=True) if is_large)
        for only, column in zip((most < 1e-6 * own).tolist(), large.T.tolist(), strict=True)
    ]


def verdict(loop: Linearised) -> str:
    """Return `STABLE`, `UNSTABLE`, `UNDAMPED` (a mode neither grows nor decays) or `UNDECIDED`.

    Where the derivatives to both sides differ, a verdict other than `UNDECIDED` holds for both and for their mean.
    """
    sides = [loop.A, loop.A + loop.corners, loop.A - loop.corners] if loop.corners.any() else [loop.A]
    found = {_verdict(A) for A in sides}
    return found.pop() if len(found) == 1 else UNDECIDED


def _verdict(A: Array) -> str:
    largest = float(np.abs(np.linalg.eigvals(A)).max(initial=0.0))
    return UNSTABLE if largest > 1.0 + RESOLVED else STABLE if largest < 1.0 - RESOLVED else UNDAMPED


def bandwidths(loop: Linearised) -> list[float | None]:
    """Return the bandwidth [Hz] of each degree of freedom, from the desired to the actual coordinate.

    It is the lowest frequency at which the response to a change of the desired pose, with desired velocity and
    acceleration of zero, is 3 dB below that at rest. It is None if the loop does not follow, or follows up to half of
    the rate of control.
    """
    n = loop.B.shape[1]
    z = np.linalg.eigvals(loop.A).astype(complex)
    decaying = np.log(z[(np.abs(z) > ENDED) & (np.abs(z) < 1.0)]) / loop.period
    slowest = float(np.abs(decaying).min(initial=np.inf)) if len(decaying) else 0.0
    top = math.pi / loop.period
    if not slowest:
        return [None] * n
    grid = np.geomspace(min(1e-3 * slowest, 1e-2 * top), top, GRID)

    own, source, late = _without_delays(loop)
    reduced = (source[:, None] == own).astype(complex)

    def gains(frequencies: Array) -> Array:
        z = np.exp(1j * frequencies * loop.period)[:, None, None]
        mapped = (loop.A[own] * z ** -late[None, None, :]) @ reduced
        found = np.linalg.solve(z * np.eye(len(own)) - mapped, loop.B[own][None].astype(complex))
        return np.abs(found[:, np.arange(n), np.arange(n)]) * loop.scale[:n]

    found: list[float | None] = []
    coarse = gains(grid)
    for i in range(n):
        least = coarse[0, i] / math.sqrt(2.0)
        below = np.flatnonzero(coarse[:, i] < least)
        if coarse[0, i] < 1e-3 or not len(below):
            found.append(None)
            continue
        low, high = grid[below[0] - 1], grid[below[0]]
        for _ in range(20):
            middle = math.sqrt(low * high)
            low, high = (low, middle) if gains(np.array([middle]))[0, i] < least else (middle, high)
        found.append(low / (2.0 * math.pi))
    return found


def _without_delays(loop: Linearised) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Return the coordinates that are no delayed copies, and for each coordinate its source and its delay in periods.

    A row of zeros with a single 1 copies another coordinate, as those of measurements and commands that wait.
    """
    A, n = loop.A, loop.B.shape[1]
    source, late = np.arange(len(A)), np.zeros(len(A), dtype=int)
    single = (np.count_nonzero(A, axis=1) == 1) & (A.max(axis=1) == 1.0) & ~loop.B.any(axis=1)
    copies = n + np.flatnonzero(single[n:])  # the first ones are those of the response
    before = dict(zip(copies.tolist(), A[copies].argmax(axis=1).tolist(), strict=True))
    for start in before:
        at, passed = start, 0
        while at in before and passed <= len(before):
            at, passed = before[at], passed + 1
        if passed <= len(before):  # else a cycle
            source[start], late[start] = at, passed
    return np.flatnonzero(late == 0), source, late


def plant_poles(loop: Linearised) -> Array:
    """Return the poles [1/s] of platform, cables and winches with held commands."""
    z = np.linalg.eigvals(loop.plant).astype(complex)
    return np.asarray(np.log(z[np.abs(z) > ENDED])) / loop.physics_step


def closed_loop(scenario: Scenario, pose: Array) -> dict[str, Any]:
    """Return the figures of a scenario's closed loop at rest near a pose (7,), as plain data with units in their names.

    If the loop has no linearisation, `problem` is the reason, and the other figures are None.
    """
    figures: dict[str, Any] = {"controller": scenario.controller.type, "problem": None, "verdict": None}
    figures |= {"control_step_s": scenario.simulation.control_step, "notes": [], "rest_offset_m": None}
    figures |= {"rest_turn_rad": None, "poles": None, "bandwidth_Hz": None, "warnings": []}
    try:
        loop = linearise(scenario, pose, response=True)
    except CdprError as error:
        return figures | {"problem": str(error)}
    found, moved = poles(loop), np.zeros(6)
    moved[list(scenario.robot.rows)] = loop.rest[: scenario.robot.n]
    dof = scenario.robot.dof
    return figures | {
        "verdict": verdict(loop),
        "notes": list(loop.notes),
        "rest_offset_m": float(np.linalg.norm(moved[:3])),
        "rest_turn_rad": float(np.linalg.norm(moved[3:])),
        "poles": [
            {
                "real_per_s": pole.value.real,
                "imaginary_rad_per_s": pole.value.imag,
                "frequency_Hz": pole.frequency,
                "damping_ratio": pole.damping,
                "moves": list(pole.moves),
            }
            for pole in found
        ],
        "bandwidth_Hz": dict(zip(dof, bandwidths(loop), strict=True)),
        "warnings": [text for _, text in sampling(loop, scenario, found)],
    }


def sampling(loop: Linearised, scenario: Scenario, found_poles: list[Pole]) -> list[tuple[Path, str]]:
    """Return problems of the control step, of periods of sensors, and of the physics step, with their keys.

    `found_poles` are those of the loop.
    """
    found: list[tuple[Path, str]] = []
    step, key = _sampled(loop, scenario)
    # Commands that wait in drives with a delay, and measurements that are late or held, have fast modes of their own.
    modes = [] if _delayed(scenario) or loop.seen_every else found_poles
    fast = [pole for pole in modes if abs(pole.z) > LASTS and pole.value.imag > 0.0]
    inside = plant_poles(loop)
    if has_feedback(chosen_plugins(scenario)["controller"]):
        ringing = max(fast, key=lambda pole: pole.value.imag).value if fast else 0j
        hidden = max((s for s in inside if s.real * step > math.log(LASTS)), key=lambda s: s.imag, default=0j)
        if hidden.imag * step > math.pi:  # a loop sees it at a lower frequency
            often, remedy, seen = "less than twice", "more damping of cables or drums", hidden
        else:
            often, remedy, seen = f"only {2 * math.pi / (ringing.imag * step or 1.0):.2g} times", "lower gains", ringing
        if seen.imag * step > 2.0 * math.pi / FEWEST:
            limited = "" if scenario.ideal_cables else _limiting(scenario, step)
            text = (
                f"{step:g} s samples a vibration of {seen.imag / (2.0 * math.pi):.4g} Hz ({pole_text(seen)}) {often} "
                f"in a period: expected at most {2.0 * math.pi / FEWEST / seen.imag:.2g} s, or {remedy}{limited}"
            )
            found.append((key, text))
    quickest = max(inside, key=abs, default=0.0)
    if abs(quickest) * loop.physics_step > 1.0:
        text = (
            f"{loop.physics_step:g} s does not resolve the fastest motion of winches and cables "
            f"({pole_text(quickest)}): expected at most {1.0 / abs(quickest):.2g} s, or lower gains of the servos"
            f"{_limiting(scenario, loop.physics_step)}"
        )
        found.append((PHYSICS_STEP, text))
    return found


def _sampled(loop: Linearised, scenario: Scenario) -> tuple[float, Path]:
    """Return the longest time [s] for which the controller sees or commands nothing new, and its key."""
    if not loop.seen_every:
        return loop.period, CONTROL_STEP
    step = scenario.simulation.control_step  # measurements are linearised for controllers that run in each step
    if loop.seen_every <= step:
        return step, CONTROL_STEP
    slowest = max(seen_sensors(scenario).values(), key=lambda sensor: sensor.period)
    places = [sensor.title for sensor in scenario.sections.sensors]
    return loop.seen_every, ("sensors", places.index(slowest.title), "period")


def _limiting(scenario: Scenario, step: float) -> str:
    """Return the part that limits a step [s], for the end of a message; "" if it is unknown."""
    robot = scenario.robot
    if not supports_oscillator(robot):
        return ""
    about = oscillator(robot, scenario.initial.state(), scenario.gravity)
    part = limiting_part(robot, about.M, about.parts, step)
    return part and f"; {part}"


def _delayed(scenario: Scenario) -> bool:
    """Return True if a drive applies its command later."""
    drives = scenario.sections.drives
    return drives is not None and any(drives.of_cable(cable.name).delay > 0.0 for cable in scenario.robot.cables)


def pole_text(pole: complex) -> str:
    """Return a pole, or a conjugate pair, as text."""
    if pole.imag:
        return f"pole {pole.real:.3g} +- {abs(pole.imag):.4g}i 1/s"
    return f"pole {pole.real:.4g} 1/s"
