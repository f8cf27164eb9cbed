"""Linearisation of a sampled closed loop at rest, by differences of its simulation.

The state of the loop is what one control period passes on to the next one: the motion of the platform, the states of
the winches, and the memory of the controller. One period maps this state to the next one, with the command held, as in
a run. Nothing is modelled a second time: the map is that of the loop itself, with its controller, tension solver,
winches and cables, on the backend `reference` with the integration scheme of the scenario's backend.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import replace
from typing import Any, Self

import numpy as np

from cdpr.base.errors import CdprError, one_line
from cdpr.cables import chain_of, has_steppers
from cdpr.log.blocks import BLOCK
from cdpr.mechanics.kinematics import lengths
from cdpr.model import rotations
from cdpr.model.robot import Array
from cdpr.scenario import Scenario
from cdpr.simulation.build import build
from cdpr.simulation.columns import chosen_plugins
from cdpr.simulation.late_measurements import LateMeasurements, ignored_errors, late_measurements
from cdpr.simulation.linear_map import Linearised
from cdpr.simulation.linearised_scenario import NotLinearisedError, held_scenario
from cdpr.simulation.loop import Loop
from cdpr.simulation.renewal import renew
from cdpr.simulation.small_steps import SMALL, counted_places
from cdpr.tension.status import Status

OWN = "cdpr"  # distribution of the built-in plugins
# Differences, relative to the scale of each coordinate: with a step, half and a quarter of it, extrapolated. A step is
# reduced until these agree, because cables that become slack and friction limit the range in which the loop is linear.
STEP = 1e-5
LEAST = 1e-9
CENTRAL = 1e-6  # difference of the plant alone, whose poles are only compared with limits
ROUGH, ONE_SIDED = 3, 1e-6  # first derivatives in the search for rest, and their one-sided differences
ROUND_OFF = 1e-15  # of a difference
AGREE = 1e-8  # of two differences, relative to the derivative, and to 1 if that is larger
EXTRAPOLATED = 1e-6  # likewise, of two extrapolated differences: a third one, of both, has far smaller errors
SMOOTH = 1e-3  # likewise; above it the map has no derivative
CORNER = 1e-5  # difference of the derivatives to both sides, likewise; smaller ones are curvature
REST = 1e-9  # change in a period at rest, relative to the scales
ITERATIONS = 30  # of Newton's method for the state of rest
FARTHEST = 0.05  # change of the platform in an iteration, relative to the scales


class Linearisation:
    """Linearisations of the loop of a scenario, without its motion and events, at several poses.

    The loop is built once, if its next start differs in numbers only.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._scenario = scenario
        self._opened = ExitStack()
        self._loop: Loop | None = None
        self._held = scenario

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._opened.close()

    def at(self, pose: Array, *, response: bool = False) -> Linearised:
        """Linearise about the state of rest near a pose, with the arguments and errors of `linearise`."""
        held, late = held_scenario(self._scenario, pose), late_measurements(self._scenario)
        try:
            loop = self._loop_of(held)
            loop.warm_up(held.initial.state())
            found = _Period(loop, held, late).linearised(response)
            small = (SMALL,) if has_steppers(self._scenario.robot) else ()
            return replace(found, notes=(*found.notes, *small, *ignored_errors(self._scenario)))
        except CdprError:
            raise
        except Exception as error:
            if {chosen_plugins(held)[role].distribution for role in ("controller", "solver")} == {OWN}:
                raise
            raise NotLinearisedError(f"a plugin raised {one_line(error)}") from error

    def _loop_of(self, held: Scenario) -> Loop:
        """Return the loop of a scenario at rest: that of the pose before, or a new one."""
        before, self._held = self._held, held
        loop, self._loop = self._loop, None
        if loop is None or not renew(loop, before, held):
            self._opened.close()
            parts = build(held)
            self._opened.callback(parts.controller.close)
            self._opened.callback(parts.backend.close)
            loop = Loop(parts)
            self._opened.callback(loop.close)
        self._loop = loop
        return loop


def linearise(scenario: Scenario, pose: Array, *, response: bool = False) -> Linearised:
    """Linearise the loop of a scenario, without its motion and events, about its state of rest near a pose.

    Args:
        scenario: the scenario.
        pose: (7,), desired position and attitude, m; w, x, y, z.
        response: also compute `B`, which otherwise has no columns.

    Raises:
        NotLinearisedError: if the loop has a state that is not known, no state of rest, or no derivative there, or if a
            plugin raises an exception.
        SimulationStopped: if the loop stops at this pose.
    """
    with Linearisation(scenario) as linearisation:
        return linearisation.at(pose, response=response)


def decay_rate(scenario: Scenario, pose: Array) -> float:
    """Return the decay rate (1/s) of the slowest mode at a pose; negative for a growing mode. Errors as `linearise`."""
    found = linearise(scenario, pose)
    largest = float(np.abs(np.linalg.eigvals(found.A)).max())
    return -math.log(max(largest, np.finfo(float).tiny)) / found.period


class _Period:
    """One control period as a function of the state of the loop.

    The state is (position, rotation from the desired attitude, velocity, angular velocity) of the platform, in world
    axes, the states of the winches, and the memory of the controller and of the drives. The states of spans, which
    creep slowly, start each period with the same values.
    """

    def __init__(self, loop: Loop, scenario: Scenario, late: LateMeasurements | None) -> None:
        self._late = late
        parts, robot = loop.parts, scenario.robot
        self._loop, self._robot, self._backend = loop, robot, parts.backend
        self._winches = getattr(parts.backend, "winches", None)
        if loop.memory is None:
            raise NotLinearisedError(f"the states of the controller '{scenario.controller.type}' are not known")
        own_arrays = (*parts.controller.arrays, *(each for part in parts.more for each in part.linear_states))  # type: ignore[attr-defined]
        self._memory = [array.reshape(-1) for array in own_arrays]
        self._calls = loop.calls.period
        self._used: dict[str, float] = {}  # steps of differences, by the name of the coordinate
        self._pose = scenario.initial.state()[:7]
        loop.begin(np.zeros((BLOCK, len(loop.row))), BLOCK)
        self._advance()
        self._place = loop.pipeline.place
        rotors = [] if self._winches is None else counted_places(robot, self._winches.places)
        turned = np.zeros(0) if self._winches is None else self._winches.state
        self._counted = [(i, turned[at : at + 1], loop.present.issued[i] - turned[at]) for i, at in rotors]
        winches = () if self._winches is None else self._winches.arrays
        kept = {id(array) for array in (parts.backend.command, parts.backend.external, *winches)}
        motion = {id(array) for array in parts.backend.arrays} - kept  # type: ignore[attr-defined]
        self._kept = [(array.copy(), array) for array in loop.memory if id(array) not in motion]
        self._back = rotations.conjugate(self._pose[3:]).tolist()
        self._step = scenario.simulation.physics_step
        self._period = self._calls * parts.control_step
        size = float(lengths(robot, scenario.initial.state()).max())
        pose = np.where(np.arange(6) < 3, size, 1.0)
        self._free = [*robot.rows, *(6 + row for row in robot.rows)]
        states, kinds = self._winch_coordinates(size)
        memory = [np.maximum(np.abs(array), 1.0) for array in self._memory]
        own = sum(map(len, memory))
        self.scale = np.concatenate([pose[[*robot.rows]], pose[[*robot.rows]] / self._period, states, *memory])
        self.names = (*robot.dof, *(f"{name}'" for name in robot.dof), *kinds, *["controller"] * own)
        self._plant = len(self._free) + len(states)
        self._still, self._start = [*self._pose[:3].tolist(), *[0.0] * 9], np.zeros(13)
        ends = np.cumsum([len(self._free), *map(len, (states, *self._memory))]).tolist()
        arrays: list[tuple[Array, Any]] = [(array, slice(None)) for array in self._memory]
        arrays.insert(0, (np.zeros(0) if self._winches is None else self._winches.state, self._winding))
        pairs = zip(map(slice, ends[:-1], ends[1:]), arrays, strict=True)
        self._others = [(span, array, where) for span, (array, where) in pairs if span.stop > span.start]

    def _winch_coordinates(self, size: float) -> tuple[Array, list[str]]:
        """Return scales and names of the states of the winches; `size` is that of the cables, m."""
        whole = np.zeros(0) if self._winches is None else self._winches.state
        scales, names, self._winding = np.maximum(np.abs(whole), 1.0), ["servo"] * len(whole), np.arange(0)
        if self._winches is not None:
            places = self._winches.places
            spans = [chain_of(self._robot, cable).span.states for cable in self._robot.cables]
            ends = places[1:] - spans
            self._winding = np.concatenate([np.arange(*each) for each in zip(places[:-1], ends, strict=True)])
            turns = np.where(self._winches.per_turn > 0.0, self._winches.per_turn, 1.0)
            for first, end, turn in zip(places[:-1], places[1:], turns, strict=True):
                if end > first:
                    scales[first], names[first] = size, "winches"
                if end > first + 1:
                    scales[first + 1], names[first + 1] = size / turn / self._period, "winches'"
        return scales[self._winding], [names[j] for j in self._winding]

    def linearised(self, response: bool) -> Linearised:
        """Find the state of rest, and linearise about it."""
        x, A, before, rough = self._state() / self.scale, np.zeros((0, 0)), np.inf, ROUGH
        for _ in range(ITERATIONS):
            here = self._after(x)
            moved = here - x
            now = float(np.abs(moved).max())
            if now <= REST:
                break
            if now > 0.1 * before or not len(A):  # a derivative serves several iterations
                rough -= 1
                if rough >= 0:
                    A = np.array([self._after(x + side) - here for side in ONE_SIDED * np.eye(len(x))]).T / ONE_SIDED
                else:
                    A, _ = self._derivative(self._after, x, here)
            before = now
            change = np.linalg.lstsq(np.eye(len(x)) - A, moved, rcond=1e-11)[0]
            n = self._robot.n
            x = x + change * min(1.0, FARTHEST / max(float(np.abs(change[:n]).max()), FARTHEST))
        else:
            self._check_status()
            raise NotLinearisedError("no state of rest was found near this pose")
        notes = self._notes()
        A, corners = self._derivative(self._after, x, here)
        none = np.zeros(self._robot.n)
        B = np.zeros((len(x), 0))
        if response:
            B, _ = self._derivative(lambda w: self._after(x, w), none, here)
        seen, error = np.zeros((len(x), 0)), np.zeros(2 * self._robot.n)
        if (late := self._late) is not None:
            size = self.scale[: len(error)]
            seen, _ = self._derivative(lambda w: late.after(self._loop, w * size, self._after, x), error, here)
        plant, count = np.zeros((0, 0)), self._plant
        if self._winches is not None:
            sides = [self._slope(self._after_plant, x, here[:count], j, CENTRAL)[0] for j in range(count)]
            plant = np.array(sides).reshape(-1, count).T
        rest = x * self.scale
        rest[: self._robot.n] -= np.concatenate([self._pose[:3], np.zeros(3)])[list(self._robot.rows)]
        period, step = self._period, self._step
        # a memory that the loop never changes, such as an integral with the gain 0, is no mode
        own = [j for j, name in enumerate(self.names) if name in ("servo", "controller")]
        constant = [j for j in own if not corners[j].any() and np.allclose(A[j], np.eye(len(x))[j], 0.0, AGREE)]
        kept = np.array([j for j in range(len(x)) if j not in constant], dtype=int)
        both, first = np.ix_(kept, kept), kept[kept < len(plant)]
        names = tuple(self.names[j] for j in kept)
        plant = plant[np.ix_(first, first)]
        found = Linearised(
            A[both], corners[both], B[kept], plant, names, self.scale[kept], rest[kept], period, step, notes
        )
        return found if late is None else late.included(found, seen[kept])

    def _derivative(self, function: Any, x: Array, here: Array) -> tuple[Array, Array]:
        """Return the derivative of a function at x by extrapolated central differences, and its corners.

        The derivatives to both sides are the first plus and minus the second.

        Raises:
            NotLinearisedError: if there is none.
        """
        self._used = {name: min(STEP, 10.0 * used) for name, used in self._used.items()}
        columns = [self._column(function, x, here, j) for j in range(len(x))]
        slopes, corners = (np.array(each).reshape(len(x), len(here)).T for each in zip(*columns, strict=True))
        return slopes, corners

    def _column(self, function: Any, x: Array, here: Array, j: int) -> tuple[Array, Array]:
        """Return the mean derivative by coordinate j, and half the difference of those to both sides."""
        best, found, corner = np.inf, here, here
        used = step = self._used.get(self.names[j], STEP)  # the ranges of equal parts are similar
        while step >= LEAST:
            (whole, bend), (half, half_bend) = (self._slope(function, x, here, j, part * step) for part in (1.0, 0.5))
            size = max(1.0, float(np.abs(half).max()))
            slope, apart, enough = (4.0 * half - whole) / 3.0, float(np.abs(whole - half).max()) / size, AGREE
            if apart > AGREE:  # extrapolate once more
                enough = EXTRAPOLATED
                finer = (4.0 * self._slope(function, x, here, j, 0.25 * step)[0] - half) / 3.0
                slope, apart = (16.0 * finer - slope) / 15.0, float(np.abs(finer - slope).max()) / size
            if apart + ROUND_OFF / step < best:
                best, used, found = apart + ROUND_OFF / step, step, slope
                corner = 2.0 * half_bend - bend  # without curvature, which halves with the step
            if apart <= enough:
                break
            step *= 0.1
        self._used[self.names[j]] = used
        if best > SMOOTH:
            raise NotLinearisedError(
                "the loop is not linear at rest: a cable becomes slack there, a limit is reached, or friction or a "
                "resolution acts"
            )
        return found, np.where(np.abs(corner) > CORNER * size, 0.5 * corner, 0.0)

    @staticmethod
    def _slope(function: Any, x: Array, here: Array, j: int, step: float) -> tuple[Array, Array]:
        """Return the mean derivative along coordinate j, and the difference of those to both sides."""
        unit = np.zeros(len(x))
        unit[j] = step
        up, down = function(x + unit), function(x - unit)
        return (up - down) / (2.0 * step), (up + down - 2.0 * here) / step

    def _after(self, x: Array, shift: Array | None = None) -> Array:
        """Return the state after a period, in the scales; `shift` (n,) is that of the desired pose."""
        self._put(x * self.scale)
        self._loop.observe()
        if shift is not None:
            full = np.zeros(6)
            full[list(self._robot.rows)] = shift
            self._loop.desired[:3] = self._pose[:3] + full[:3]
            self._loop.desired[3:7] = _product(_turn(full[3:].tolist()), self._pose[3:].tolist())
        self._advance()
        return np.asarray(self._state() / self.scale)

    def _after_plant(self, x: Array) -> Array:
        """Return the state of the plant after a physics step with the commands at rest, in the scales."""
        self._put(x * self.scale)
        self._backend.step(1)
        return np.asarray((self._state() / self.scale)[: self._plant])

    def _advance(self) -> None:
        for _ in range(self._calls):
            self._loop.decide()
            self._loop.advance()

    def _state(self) -> Array:
        state, found = self._backend.state.tolist(), np.empty(len(self.scale))  # a list is faster than small arrays
        motion = [*state[:3], *_rotation_vector(_product(state[3:7], self._back)), *state[7:]]
        found[: len(self._free)] = [motion[j] for j in self._free]
        for span, array, where in self._others:
            found[span] = array[where]
        return found

    def _put(self, x: Array) -> None:
        """Set the state of the loop; all else is as after the first period."""
        motion = self._still.copy()
        for j, value in zip(self._free, x[: len(self._free)].tolist(), strict=True):
            motion[j] = value
        self._start[:] = [*motion[:3], *_product(_turn(motion[3:6]), self._pose[3:].tolist()), *motion[6:]]
        self._backend.reset(self._start)
        for copy, array in self._kept:
            array[:] = copy
        self._loop.pipeline.place = self._place
        for span, array, where in self._others:
            array[where] = x[span]
        for cable, unwound, ahead in self._counted:  # a drive counts its steps from the start, under load
            self._loop.present.issued[cable] = unwound[0] + ahead

    def _check_status(self) -> None:
        self._loop.decide()
        if Status(int(self._loop.stage.live.report[0])) is not Status.OK:
            raise NotLinearisedError("no tensions within their limits exert the commanded wrench at rest at this pose")

    def _notes(self) -> tuple[str, ...]:
        """Return facts about cables and commands at rest, of the last period."""
        loop, robot = self._loop, self._robot
        self._check_status()
        report, notes = loop.stage.live.report, []
        highest = float(robot.tension_max[np.isfinite(robot.tension_max)].max(initial=1.0))
        if self._winches is not None and robot.unilateral:
            slack = self._winches.tension <= 1e-9 * highest
            names = [cable.name for cable, is_slack in zip(robot.cables, slack, strict=True) if is_slack]
            if names:
                notes.append(f"slack at rest, without stiffness: {', '.join(names)}")
        if any(chain_of(robot, cable).span.states for cable in robot.cables):
            notes.append("the creep of the cables is held at its value at the start of a run")
        if loop.parts.output == "command" and int(report[3]):
            notes.append(f"commands at a limit of the tension at rest, without feedback: {int(report[3])}")
        return tuple(notes)


def _product(p: Sequence[float], q: Sequence[float]) -> list[float]:
    """Return the product of two quaternions w, x, y, z."""
    (a, b, c, d), (w, x, y, z) = p, q
    return [
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    ]


def _rotation_vector(q: Sequence[float]) -> list[float]:
    """Return the rotation vector (3), rad, of a quaternion w, x, y, z of a rotation below half a turn."""
    w, x, y, z = q
    sine = math.sqrt(x * x + y * y + z * z)
    share = 2.0 * math.atan2(sine, w) / sine if sine > 0.0 else 2.0
    return [share * x, share * y, share * z]


def _turn(vector: Sequence[float]) -> list[float]:
    """Return the quaternion of a rotation vector (3), rad."""
    x, y, z = vector
    half = 0.5 * math.sqrt(x * x + y * y + z * z)
    share = 0.5 * math.sin(half) / half if half > 0.0 else 0.5
    return [math.cos(half), share * x, share * y, share * z]
