"""The loop: state, desired, wrench, tension, one row, one step of the plant; again."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from time import monotonic, sleep
from typing import Literal

import numpy as np

from cdpr.columns import LATER, Column
from cdpr.errors import BackendDied, BeyondLimits, Diverged, Infeasible, PluginError, SimulationStopped
from cdpr.log.layout import Layout
from cdpr.log.recorder import BLOCK, BLOCK_SECONDS
from cdpr.model import Robot
from cdpr.model.reach import Reach, bounds_of
from cdpr.model.robot import Array, read_only
from cdpr.plugins import Backend, Controller, TensionSolver
from cdpr.plugins.controller import Output
from cdpr.scenario.events import ScenarioEvent, broken
from cdpr.simulation.columns import hand_out
from cdpr.simulation.observe import FAULTS, acceleration_bounds, observe
from cdpr.simulation.schedule import Schedule
from cdpr.tension.command import CommandStage
from cdpr.tension.policy import Policy
from cdpr.tension.stage import TensionStage
from cdpr.tension.status import Status
from cdpr.trajectory import Trajectory

# An engine's clock is a sum of steps: after 1e8 of them it may be off by this share. A reset is off by much more.
CLOCK_TOLERANCE = 1e-6

# After these a solver need not have written any tensions.
ANSWERS = (Status.OK, Status.INFEASIBLE, Status.UNSUPPORTED)


@dataclass(frozen=True, eq=False)
class Parts:
    """What a closed loop is made of."""

    robot: Robot
    controlled: Robot  # the same for the distribution: its dof are the directions in which it has to balance the wrench
    trajectory: Trajectory
    controller: Controller
    solver: TensionSolver
    solver_name: str
    respects_bounds: bool
    policy: Policy
    backend: Backend
    control_step: float  # s
    substeps: int  # physics steps in a control step
    output: Output = "wrench"  # what the controller puts out
    events: tuple[ScenarioEvent, ...] = ()  # what happens during the run
    limits: Literal["warn", "stop"] = "warn"  # where a cable leaves its length or speed_max
    ideal_cables: bool = True  # otherwise tensions and work of the cables are read from the backend
    columns: tuple[Column, ...] = LATER  # what a row holds beyond `cdpr.columns.FIRST`


class Loop:
    """A closed loop, ready to run.

    Attributes:
        row: the present sample, columns as `cdpr.log.layout` says; the parts work on views of it.
        out: where the controller writes: the wrench (6,) or the commands (m,).
        count: how many samples the last run made.
    """

    def __init__(self, parts: Parts) -> None:
        self.parts = parts
        self.count = 0
        robot, backend = parts.robot, parts.backend
        layout = Layout(robot.m, parts.ideal_cables, parts.columns)
        self.row = row = np.zeros(layout.width)
        self.added = row[layout.added]
        hand_out(layout, row, {"backend": backend, "controller": parts.controller, "solver": parts.solver})

        def view(first: str, last: str | None = None) -> Array:
            return row[layout.span(first, last or first)]

        self.state = view("position", "angular_velocity")
        self.desired = view("desired_position", "desired_angular_acceleration")
        # What the controller sees of them it cannot change.
        self.given_state, self.given_desired = read_only(self.state), read_only(self.desired)
        self.status = layout.columns["status"].start
        self.wrench = view("wrench")
        self.tension = view("tension")
        self.W = np.zeros((6, robot.m))
        self.sample = parts.trajectory.sampler(self.desired)
        report = view("status", "at_limit")
        parts.controller.connect(report)
        self.stage: TensionStage | CommandStage
        if parts.output == "command":
            self.stage = CommandStage(robot, parts.policy, self.W, self.wrench, self.tension, report)
            self.out = self.stage.command
        else:
            self.stage = TensionStage(
                parts.controlled,
                parts.solver.solve,
                parts.solver_name,
                parts.respects_bounds,
                parts.policy,
                self.W,
                self.wrench,
                self.tension,
                report,
            )
            self.out = self.wrench
        self.schedule = Schedule(
            parts.events,
            parts.control_step,
            robot,
            self.stage,
            self.tension,
            self.wrench,
            view("status"),
            view("external"),
            backend.external,
        )
        bounds = acceleration_bounds(robot, backend.gravity)
        plant = (bounds, backend.highest, backend.external, backend.state)
        energies = view("kinetic", "external_work")
        results = (self.state, self.W, view("length"), view("rate"), energies)
        body = (robot.anchors, robot.inertial, backend.gravity)
        self.observe: Callable[[], int] = partial(observe, *body, parts.control_step, *plant, *results)
        self.observe_start = partial(observe, *body, 0.0, *plant, *results)  # no time has passed
        self.distribute = self.schedule.distribute
        if not parts.ideal_cables:
            self._add_winches(view("cable_tension"), energies[2:3])
        if parts.limits == "stop" and bounds_of(robot):
            self._stop_beyond(view("length")[None], view("rate")[None])

    def warm_up(self, start: Array, real_time: bool = False) -> None:
        """Call every part once and put all back to `start` (13,).

        What a first call costs (compiling, loading from disk) is then over before a clock runs; in real time also that
        of the infeasible policy. Raises PluginError where controller or solver write nothing.
        """
        parts = self.parts
        try:
            self._first()
            self.sample(0.0)
            self.out[:] = np.nan
            parts.controller.control(0.0, self.given_state, self.given_desired, self.out)
            if np.isnan(self.out).all():
                raise PluginError(
                    f"the controller wrote no {parts.output}: `control` must write into the array it is given"
                )
            self.stage.distribute()
            if self.row[self.status] not in ANSWERS and not self.stage.answered:
                raise PluginError(
                    f"solver '{parts.solver_name}' wrote no tensions, or NaN: `solve` must write "
                    "into the array it is given"
                )
            if real_time:
                self.stage.warm_up_policy()
            self.schedule.warm_up()
            parts.backend.command[...] = self.tension
            parts.backend.read_tension(self.tension)
            parts.backend.step(parts.substeps)
            self.observe()
        except BackendDied:
            raise  # it would only die again, or hang as long again
        except SimulationStopped:
            pass  # the run itself will say so, at its proper time
        self.row[:] = 0.0
        self.added[:] = np.nan  # until somebody writes
        self.stage.forget()
        parts.controller.reset()
        parts.solver.reset()
        parts.backend.command[...] = 0.0
        parts.backend.reset(start)

    def run(
        self,
        rows: Array,
        flush: Callable[[int], None],
        *,
        steps: int | None = None,
        real_time: bool = False,
    ) -> int:
        """Fill `rows` (steps + 1, width) from the backend's present state; return the number of samples made.

        Fewer rows, a multiple of 256, are filled again and again, where `steps` says how many there are to make.
        `flush(k)` is called when the first k samples are final, every 256 of them or half second of wall time; it may
        end the run by raising SimulationStopped. Raises that, with the time in its text, where the run stops early;
        `count` then tells how many samples are final.
        """
        parts, row = self.parts, self.row
        backend, substeps, period = parts.backend, parts.substeps, parts.control_step
        state, desired, out = self.given_state, self.given_desired, self.out
        tension, command, advance = self.tension, backend.command, backend.step
        sample, control, look = self.sample, parts.controller.control, self.observe
        act, distribute = self.schedule.act, self.distribute
        clock = backend.engine_time
        size = len(rows)
        last = size - 1 if steps is None else steps
        self.count = 0
        k, flush_at, flush_time = 0, BLOCK, monotonic() + BLOCK_SECONDS
        started = monotonic()
        time = 0.0
        try:
            self._first()
            due = self.schedule.begin()
            while True:
                row[0] = time
                if k == due:
                    due = act(k)
                sample(time)
                control(time, state, desired, out)
                try:
                    distribute()
                except Infeasible:
                    rows[k % size] = row  # this sample tells why
                    k += 1
                    raise
                rows[k % size] = row
                if k == last:
                    k += 1
                    return k
                command[...] = tension
                k += 1
                time = k * period
                advance(substeps)
                fault = look()
                if fault:
                    self._check(fault)
                reading = clock()
                if reading is not None and not abs(reading - time) <= CLOCK_TOLERANCE * time:
                    raise Diverged(f"the engine's clock reads {reading:.6g} s: it reset itself")
                if k >= flush_at or monotonic() > flush_time:
                    flush(k)
                    flush_at, flush_time = k - k % BLOCK + BLOCK, monotonic() + BLOCK_SECONDS
                if real_time:
                    while (ahead := time - (monotonic() - started)) > 0.0:
                        if monotonic() > flush_time:
                            flush(k)
                            flush_time = monotonic() + BLOCK_SECONDS
                        sleep(min(ahead, BLOCK_SECONDS))
        except (SimulationStopped, PluginError) as stop:
            raise type(stop)(f"t = {time:.6g} s: {stop}") from stop
        finally:
            self.count = k

    def _add_winches(self, cable_tension: Array, cable_work: Array) -> None:
        """Read what only the plant knows where cables are not ideal: their tensions (m,) and their work (1,)."""
        backend, tension = self.parts.backend, self.tension
        distribute, look = self.distribute, self.observe

        def distribute_and_read() -> None:
            distribute()
            backend.command[...] = tension
            backend.read_tension(cable_tension)

        def look_and_read() -> int:
            fault = look()
            cable_work[0] = backend.cable_work()
            return fault

        self.distribute, self.observe = distribute_and_read, look_and_read

    def _stop_beyond(self, length: Array, rate: Array) -> None:
        """End the run at the first sample at which a cable leaves its limits; length and rate are (1, m), live."""
        distribute, robot = self.distribute, self.parts.robot
        bounds, names = bounds_of(robot), [cable.name for cable in robot.cables]
        limited = bounds, robot.m, broken(self.parts.events, names, self.parts.control_step)
        reach, time = Reach(*limited), self.row[:1]

        def distribute_within() -> None:
            distribute()
            if reach.add(time, length, rate):
                here = Reach(*limited)
                here.add(time, length, rate)
                told = "; ".join(one.text(names) for one in here.told())
                raise BeyondLimits(f"{told}; the scenario says limits: stop")

        self.distribute = distribute_within

    def _first(self) -> None:
        self.state[:] = self.parts.backend.state
        self._check(self.observe_start())

    def _check(self, fault: int) -> None:
        if fault:
            state = self.parts.backend.state
            raise Diverged(
                f"{FAULTS[fault]} (position {_brief(state[:3])} m, velocity {_brief(state[7:10])} m/s, "
                f"angular velocity {_brief(state[10:])} rad/s)"
            )


def _brief(values: Array) -> str:
    return "[" + ", ".join(f"{value:.4g}" if math.isfinite(value) else str(value) for value in values) + "]"
