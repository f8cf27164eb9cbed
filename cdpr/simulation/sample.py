"""Present sample of a loop: its row, and the operations beside controller and solver that fill it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from cdpr.base.errors import Diverged, LimitViolation, PluginError
from cdpr.cables import bends, commands_of
from cdpr.cables.drums import emptied
from cdpr.cables.motor import motor_table
from cdpr.log.layout import Layout
from cdpr.log.limit_violations import beyond
from cdpr.mechanics.energy import energy
from cdpr.mechanics.reach import bounds_of
from cdpr.model import Robot
from cdpr.model.robot import Array, read_only
from cdpr.native.bind import bind
from cdpr.plugins import Backend
from cdpr.plugins.compiled import speaks_for
from cdpr.scenario.events import ScenarioEvent, broken, guarding
from cdpr.scenario.events.limit_changes import limit_changes
from cdpr.simulation.columns import hand_out
from cdpr.simulation.loop_part import LoopPart, Surroundings, writes
from cdpr.simulation.moving_anchors import LoopAnchors
from cdpr.simulation.observe import Body, Observation, PlantOutputs, acceleration_bounds, observing, observing_nominal
from cdpr.simulation.parts import Parts
from cdpr.tension.current_sample import Cables, Present
from cdpr.tension.operations import Operation

MOTOR_INPUTS = {"torque": "motor_torque", "speed": "drum_speed"}  # fields of motor.hpp and their columns
MOTOR_OUTPUTS = {"current": "motor_current", "voltage": "motor_voltage", "power": "electrical_power"}

Do = Callable[[], object]
Refuse = Callable[[int], None]  # reaction to impossible states, by a key of `cdpr.simulation.faults.FAULTS`


class Sample:
    """Present sample.

    Attributes:
        layout: columns of `row`.
        row: all recorded values; the parts work on views of it.
        state, desired: views of it.
        seen: (13,), state that controller and tension stage use; `state` itself if no part writes it.
        seen_cables: (2, m), cable lengths, m, and rates, m/s, that the controller measures; likewise views of `row`.
        drive: (m,), commands of the plant; the tensions, if no winch takes a length or a rate and drives are ideal.
        issued: (m,), m, unwound lengths at the end of the control period that stepper drives count.
        sent: (m,), N, tensions as sent in the previous control step, if something reads them.
        locked: (m,), True for cables that the distribution has locked.
        live: arrays of the tension stage; W is that of the perceived robot at the state `seen`.
        cables: limits and imposed tensions.
        true_W: (6, m) wrench matrix of the simulated robot.
    """

    def __init__(self, parts: Parts) -> None:
        self._parts = parts
        robot = parts.robot
        self.layout = layout = Layout(robot.m, parts.columns)
        self.row = np.zeros(layout.width)
        hand_out(layout, self.row, {"backend": parts.backend, "controller": parts.controller, "solver": parts.solver})
        view = self.view
        self.state = view("position", "angular_velocity")
        self.desired = view("desired_position", "desired_angular_acceleration")
        W = np.zeros((6, robot.m))
        self.live = Present(W, view("wrench"), view("tension"), view("status", "at_limit"))
        self.cables = Cables.of(parts.controlled_robot, None if parts.nominal is None else robot)
        bounds = acceleration_bounds(robot, parts.backend.gravity)
        self.drive = view("drive_command") if self.layout.has("driven") else self.live.tension
        if self.layout.has("drums"):
            self.drive = np.zeros(robot.m)
        self.issued = np.zeros(robot.m)
        self.sent, self.locked = np.zeros(robot.m), np.zeros(robot.m, dtype=bool)
        self._anchors = anchors = LoopAnchors(parts)
        self._body = Body(anchors.lines(robot), robot.inertial.copy(), parts.backend.gravity, bounds)
        self._readings = ([], []) if parts.ideal_cables else self._reading()
        self.true_W = np.zeros((6, robot.m)) if parts.perceived_differs else W
        cables = view("length", "rate")
        self.seen = np.zeros(13) if writes(parts.more, "seen") else self.state
        seen_cables = np.zeros(2 * robot.m) if writes(parts.more, "seen_cables") else cables
        self.seen_cables = seen_cables.reshape(2, robot.m)
        pairs = (self.state, self.seen), (cables, seen_cables)
        self._perceived = [(truth, own) for truth, own in pairs if own is not truth]
        for part in parts.more:
            part.connect(self._surroundings(part))
        parts.controller.connect(self.live.report)
        parts.controller.sense(read_only(self.seen_cables))

    def _surroundings(self, part: LoopPart) -> Surroundings:
        parts, own = self._parts, {column.name: self.view(column.name) for column in part.columns}
        arrays = {"seen": self.seen, "seen_cables": self.seen_cables}
        seen, cables = (array if name in part.writes else read_only(array) for name, array in arrays.items())
        about = parts.robot, parts.backend, parts.control_step, self.view, self.layout.has, own
        held, sent, limits = map(read_only, (self.cables.held, self.sent, self.cables.limits))
        return Surroundings(*about, read_only(self.state), seen, cables, held, sent, limits, read_only(self.locked))

    @property
    def perceived(self) -> tuple[Array, ...]:
        """Arrays of the perceived sample that are not views of the row."""
        return tuple(own for _, own in self._perceived)

    @property
    def anchors(self) -> tuple[Array, ...]:
        """Arrays of anchors that move."""
        return self._anchors.arrays

    def placed_lines(self, robot: Robot) -> tuple[Array, list[Operation]]:
        """Return the lines of a robot (m, w), and the operations that write the present anchors into them."""
        lines = self._anchors.lines(robot)
        return lines, self._anchors.placing(lines, robot)

    def renew(self, robot: Robot) -> None:
        """Observe a robot with another platform."""
        self._body.inertial[:] = robot.inertial
        self._body.bounds[:] = acceleration_bounds(robot, self._body.gravity)

    @property
    def weighed(self) -> tuple[Array, ...]:
        """Columns that `weigh` writes, live."""
        loaded = (self.view("load_energy"),) if self.layout.has("loaded") else ()
        return self.view("kinetic", "potential"), *loaded

    def weigh(self) -> None:
        """Write the energies of the present sample for the present mass properties; add the gain to its column."""
        energies = self.view("kinetic", "potential")
        before = float(energies.sum())
        energies[:] = energy(self._body.inertial, self._body.gravity, self.state)
        if self.layout.has("loaded"):  # not if only live events change the mass
            self.view("load_energy")[0] += float(energies.sum()) - before

    def view(self, first: str, last: str | None = None) -> Array:
        """Return the columns from the field `first` to `last`, live."""
        return self.row[self.layout.span(first, last or first)]

    def observing(self, period: float, refuse: Refuse) -> list[Operation]:
        """Return the operation that observes the plant a control `period` (s) after the last time, or at once (0)."""
        parts, backend = self._parts, self._parts.backend
        energies = self.view("kinetic", "external_work")
        seen = Observation(self.state, self.true_W, self.view("length"), self.view("rate"), energies)
        observe = observing(self._body, PlantOutputs(backend.state, backend.external, backend.highest), seen, period)
        operations = [
            *self._anchors.placing(self._body.lines, parts.robot),
            Operation("geometry", observe, refuse),
            *self._anchors.effects(seen, backend.highest, period),
        ]
        if not parts.ideal_cables and period:
            operations += self._readings[1]
        operations += [Operation("seen", bind("copy", source=truth, target=own)) for truth, own in self._perceived]
        operations += [each for part in parts.more for each in part.observed(period)]
        operations += [Operation("seen", bind("not_finite", values=own), self._refuse_seen) for own in self.perceived]
        if parts.perceived_differs:
            lines, placing = self.placed_lines(parts.perceived_robot)
            operations += placing
            perceived = observing_nominal(lines, self.seen, self.live.W)
            operations.append(Operation("geometry", perceived, refuse))
        return operations

    def completing(self, distributing: Sequence[Operation], events: Sequence[ScenarioEvent]) -> list[Operation]:
        """Return the operations that distribute, and then write the values that only plant and true robot provide.

        They raise LimitViolation and CollisionDetected if the scenario stops then.
        """
        operations = [*distributing, *(each for part in self._parts.more for each in part.distributed())]
        if not self._parts.ideal_cables:
            operations += self._readings[0]
        if self._parts.perceived_differs:
            operations += self._exerting()
        if self._parts.limits == "stop":
            operations += self._within(events)
        guards = [guard for _, guard in guarding(events, self._parts.control_step) if guard.stops]
        if guards:
            from cdpr.simulation.contact import keeping_distance  # few scenarios need this import

            unwound = self.view("unstretched_length") if self.layout.has("sagging") else None
            operations += keeping_distance(self._parts, events, guards, self.state, unwound)
        return operations

    def _reading(self) -> tuple[list[Operation], list[Operation]]:
        """Return the operation that reads tensions and work from the plant if cables are not ideal."""
        backend, tension = self._parts.backend, self.view("cable_tension")
        work = self.view("cable_work")
        if self._parts.immediate:
            return [Operation("backend", bind("copy", source=self.drive, target=tension))], []

        def read_work() -> None:
            work[0] = backend.cable_work()

        readings = None
        if isinstance(backend, Backend) and all(
            speaks_for(backend.readings, does) for does in (backend.read_tension, backend.cable_work)
        ):
            readings = backend.readings(tension, work)
        tensions, works = readings or ([partial(backend.read_tension, tension)], [read_work])
        command: Do = bind("copy", source=self.drive, target=backend.command)
        more = (*self._rubbing(backend), *self._sagging(backend), *self._turning(backend))
        reading = [Operation("backend", do) for do in (command, *tensions, *more)]
        reading.append(Operation("backend", bind("not_finite", values=tension), self._refuse_tension))
        return reading, [Operation("backend", do) for do in works]

    def _rubbing(self, backend: Backend) -> Sequence[Do]:
        """Return the operations that read the tensions on the other side of pulleys with friction."""
        return backend.winch_tensions(self.view("winch_tension")) if self.layout.has("friction") else ()

    def _sagging(self, backend: Backend) -> Sequence[Do]:
        """Return the operations that read cables which sag."""
        if not self.layout.has("sagging"):
            return ()
        found = backend.bent_readings(self.view("unstretched_length"), self.view("bending_wrench"))
        if found is None:
            raise PluginError(f"{type(backend).__name__} does not support cables that sag: choose another backend")
        return found

    def _turning(self, backend: Backend) -> Sequence[Do]:
        """Return the operations that read the motion of the drums."""
        if not self.layout.has("motors"):
            return ()
        names = "drum_angle", "drum_speed", "motor_torque", "motor_power"
        return [*backend.drum_readings(*map(self.view, names)), *self._electrical()]

    def _electrical(self) -> Sequence[Do]:
        """Return the operation that computes currents and voltages of the motors from torques and speeds."""
        if not self.layout.has("electrical"):
            return ()
        inputs = {name: self.view(column)[None] for name, column in MOTOR_INPUTS.items()}
        outputs = {name: self.view(column)[None] for name, column in MOTOR_OUTPUTS.items()}
        return [bind("read_motors", motors=motor_table(self._parts.robot), **inputs, **outputs)]

    def _refuse_seen(self, _: int) -> None:
        names = ", ".join(repr(part.name) for part in self._parts.more if part.writes)
        raise Diverged(f"the state that the controller sees is not finite; written by {names}: check their options")

    def _refuse_tension(self, _: int) -> None:
        robot, state, command = self._parts.robot, self.state, self.live.tension
        if bends(robot):
            from cdpr.mechanics.sag import too_loose  # few robots need this import

            if text := too_loose(robot, state[:3], state[3:7], self._parts.backend.gravity, command):
                raise Diverged(text)
        if self.layout.has("motors") and (text := emptied(robot, self.view("length"))):
            raise Diverged(text)
        if self.layout.has("drums") and (text := self._nothing_unwound()):
            raise Diverged(text)
        values = ", ".join(f"{value:.4g}" for value in self.view("cable_tension"))
        raise Diverged(f"the backend's cable tensions are not finite: [{values}]")

    def _nothing_unwound(self) -> str:
        """Return a message on the first cable without an unwound length; "" if all have one."""
        robot = self._parts.robot
        applied = self.view("drive_command") if self.layout.has("driven") else self.view("winch_command")
        lengths = np.array([each == "length" for each in commands_of(robot)])
        unwound = np.where(lengths & ~(applied > 0.0), applied, self.view("unstretched_length"))
        if self.layout.has("steppers"):  # whose plant has not started before their first steps
            unwound = np.where(np.isfinite(unwound), unwound, self.view("counted_length"))
        for i in np.flatnonzero(unwound <= 0.0)[:1].tolist():
            return (
                f"cable '{robot.cables[i].name}': its unwound length is {unwound[i]:.4g} m, expected more than 0: "
                "check the commands, and the resolution and steps of its drive"
            )
        return ""

    def _exerting(self) -> list[Operation]:
        """Return the operation that writes the true wrench of the cables and the margins to the true limits."""
        command, cables = self.live.tension, self.cables
        tension = command if self._parts.ideal_cables else self.view("cable_tension")
        given = {"matrix": self.true_W, "tension": tension, "wrench": self.view("true_wrench")}
        sags = self.layout.has("sagging")
        exerted = bind("exert_bent", **given, bending=self.view("bending_wrench")) if sags else bind("exert", **given)
        room = self.view("true_margin")
        measured = bind("room_within_limits", limits=cables.true_limits, tension=command, held=cables.held, room=room)
        # A sample without valid tensions contains these, too.
        return [Operation("geometry", exerted, telling=True), Operation("geometry", measured, telling=True)]

    def _within(self, events: Sequence[ScenarioEvent]) -> list[Operation]:
        """Return the operation that ends the run at the first sample with a limit violation of a cable."""
        robot, row = self._parts.robot, self.row[None]
        names = [cable.name for cable in robot.cables]
        limits, step = np.array([robot.tension_min, robot.tension_max]), self._parts.control_step
        changes = limit_changes(events, robot, step)
        about = self.layout, bounds_of(robot), limits, broken(events, names, step), changes
        reach = beyond(*about)

        def stop(_: int) -> None:
            here = beyond(*about)
            here.add(row)
            left = "; ".join(one.text(names) for one in here.exceeded())
            raise LimitViolation(f"{left}; stopped by limits: stop")

        return [Operation("cables", reach.leaving(self.row), stop)] if reach.any else []
