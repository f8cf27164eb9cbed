"""Winches of one plant: compiled tensions and winch states around the arrays of a backend."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr.cables import chain_of
from cdpr.cables.tables import WINCH, chain_table, places_of_states
from cdpr.mechanics.anchors import PlantAnchors
from cdpr.mechanics.body_frame import BodyFrame
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import bind

EXIT = 6  # column of `line_table`

RUN = 10  # numbers of a `CableRun`

POWERED = -1.0  # brake torque of a winch with power


class Winches:
    """Tensions of cables on winches, computed from the commands of a backend.

    Attributes:
        body: (13,) live state of the body frame.
        offset: (7,) offset of `BodyFrame`.
        given: arguments of the operations of `plant.hpp` by name.
        free: (6,) 1 for each row of a twist in which the platform moves, 0 if a guide blocks it.
        stretching: indices of the elastic cables.
        per_turn: (m,) cable length per unit of the winch coordinate at the home pose without reeving [m/rad], 0
            without a drum.
        state: (s,) states of the winches, cable by cable (`Chain.states`): of an elastic cable unwound length [m] and
            drum speed [rad/s], then the own states of the winch; NaN before the start.
        places: (m + 1,) index in `state` of the first state of each winch, and s.
        tension: (m,) tensions [N].
        brakes: (m,) torque of the brake of each winch without power [N m], negative for winches with power; written by
            the caller.
        highest: (m,) largest magnitude of each tension since the start [N].
        work: (1,) work of the cables on the platform since the start [J].
        step: operation before each step of a semi-implicit engine, which writes `applied` and advances the winches.
        settle: operation that evaluates tensions and work at `body` without advancing the winches.
    """

    def __init__(
        self,
        robot: Robot,
        frame: BodyFrame,
        gravity: Array,
        command: Array,
        external: Array,
        body: Array,
        applied: Array,
        physics_step: float,
    ) -> None:
        m, chains = robot.m, chain_table(robot)
        self.body, self.offset = body, frame.offset
        self.free = np.zeros(6)
        self.free[robot.rows] = 1.0
        self.stretching = np.flatnonzero([chain_of(robot, cable).stretches for cable in robot.cables])
        self.per_turn = chains[:, WINCH]
        self.places = places_of_states(robot)
        self.state, self.work = np.full(self.places[-1], np.nan), np.zeros(1)
        self.tension, self.highest = np.zeros(m), np.zeros(m)
        self.brakes = np.full(m, POWERED)
        self._length, self._beside, self._place = np.zeros(m), np.zeros(6), np.zeros(7)
        self.given: dict[str, Any] = {
            "chains": chains,
            "lines": frame.line_table,
            "kinds": _kinds(chains, frame.line_table),
            "places": self.places,
            "offset": frame.offset,
            "inertial": _inertial(robot, frame),
            "free": self.free,
            "gravity": np.array(gravity, dtype=np.float64),
            "command": command,
            "external": external,
            "body": body,
            "winch": self.state,
            "tension": self.tension,
            "highest": self.highest,
            "length": self._length,
            "cable_work": self.work,
            "beside": self._beside,
            "place": self._place,
            "applied": applied,
            "rate": np.zeros(m),
            "matrix": np.zeros((6, m)),
            "at_winch": np.ones(m),
            "brakes": self.brakes,
            "runs": np.zeros((m, RUN)),
            "seen": np.full(13, np.nan),
        }
        self.step: Callable[[], object] = bind("step_winches", **self.given, step=physics_step)
        self.settle: Callable[[], object] = bind("settle_winches", **self.given)

    def follow(self, anchors: PlantAnchors) -> None:
        """Evaluate the cables with anchors that move; their memory is that of the plant."""
        given = {**self.given, **anchors.given}
        self.step = bind("step_winches_anchored", **given, step=anchors.given["every"])
        self.settle = bind("settle_winches_anchored", **given)

    def reset(self) -> None:
        """Reset all states, so that the next evaluation starts a new run."""
        for array in self.arrays:
            array[:] = 0.0
        self.state[:] = self.given["seen"][:] = np.nan
        self.brakes[:] = POWERED

    def settle_before_change(self) -> None:
        """Add the work up to the present `body`, before its frame changes."""
        if self._length.any():  # otherwise not yet started
            self.settle()

    def change_body(self, robot: Robot, frame: BodyFrame) -> None:
        """Take mass properties and frame of another platform; `body` is already in that frame."""
        self.given["inertial"][:] = _inertial(robot, frame)
        self.given["seen"][:] = np.nan  # the lines are others
        self._place[:] = self.body[:7]

    def readings(self, tension: Array, work: Array) -> tuple[list[Callable[[], object]], list[Callable[[], object]]]:
        """Return operations that write the tensions (m,) [N] at `body`, and operations that write the work (1,) [J]."""
        return [self.settle, bind("copy", source=self.tension, target=tension)], [
            self.settle,
            bind("copy", source=self.work, target=work),
        ]

    def reading(self, unwound: Array, unwinding: Array, torque: Array) -> list[Callable[[], object]]:
        """Return operations that write the state of the winches, see `Backend.winch_readings`."""
        return [bind("read_winches", **self.given, unwound=unwound, unwinding=unwinding, torque=torque)]

    def winch_tensions(self, tension: Array) -> list[Callable[[], object]]:
        """Return operations that write the tensions at the winches (m,) [N]; they follow those of `readings`."""
        return [bind("read_winch_tensions", **self.given, pulled=tension)]

    def drum_readings(self, angle: Array, speed: Array, torque: Array, power: Array) -> list[Callable[[], object]]:
        """Return operations that write the state of the drums after `readings`, see `Backend.drum_readings`."""
        return [bind("read_drums", **self.given, angle=angle, speed=speed, torque=torque, power=power)]

    def bent_readings(self, unstretched: Array, bending: Array) -> list[Callable[[], object]]:
        """Return operations that write the unstretched lengths (m,) [m] and the wrench of bending (6,) [N, N m].

        They follow the operations of `readings`.
        """
        return [bind("read_bent_cables", **self.given, unstretched=unstretched, bending=bending)]

    @property
    def arrays(self) -> tuple[Array, ...]:
        """All arrays that determine the future, besides the arrays of the backend."""
        own = self.state, self.tension, self.highest, self._length, self.work, self._beside, self._place
        return (*own, self.brakes)


def _kinds(chains: Array, lines: Array) -> NDArray[np.int64]:
    """Return the kinds of winches, spans and exits (m, 3). Cases of a batch share lanes if these are equal."""
    exits = lines[:, EXIT] if lines.shape[1] > EXIT else np.zeros(len(lines))
    return np.column_stack([chains[:, :2], exits]).astype(np.int64)


def _inertial(robot: Robot, frame: BodyFrame) -> Array:
    """Return the mass, centre of mass and inertia of the body (13,), with the layout of `Robot.inertial`."""
    if frame.guide is None:
        return np.concatenate([[frame.mass, 0.0, 0.0, 0.0], np.diag(frame.moments).ravel()])
    return robot.inertial.copy()
