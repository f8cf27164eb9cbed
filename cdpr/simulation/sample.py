"""The present sample of a loop: the row that its parts work on, and what fills it beside controller and solver."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from cdpr.cables.lines import lines
from cdpr.errors import BeyondLimits
from cdpr.log.beyond import beyond
from cdpr.log.layout import Layout
from cdpr.mechanics.reach import bounds_of
from cdpr.model import Robot
from cdpr.model.robot import Array, read_only
from cdpr.scenario.events import ScenarioEvent, broken
from cdpr.simulation.columns import hand_out
from cdpr.simulation.observe import Body, Seen, Shown, acceleration_bounds, believe, exert, observing
from cdpr.simulation.parts import Parts
from cdpr.tension.checks import true_margin
from cdpr.tension.present import Cables, Present

Act = Callable[[], None]
Look = Callable[[], int]  # 0 or what cannot be true, a key of `cdpr.simulation.faults.FAULTS`


class Sample:
    """The present sample.

    Attributes:
        layout: columns of `row`.
        row: all that is recorded; the parts work on views of it.
        state, desired: of these.
        live: what the tension stage works on; with another belief W is that of the believed robot at the true state.
        cables: what is allowed and imposed.
        true_W: (6, m) wrench matrix of the robot that is moved.
    """

    def __init__(self, parts: Parts) -> None:
        self._parts = parts
        robot = parts.robot
        self.layout = layout = Layout(robot.m, parts.ideal_cables, parts.columns)
        self.row = np.zeros(layout.width)
        hand_out(layout, self.row, {"backend": parts.backend, "controller": parts.controller, "solver": parts.solver})
        view = self.view
        self.state = view("position", "angular_velocity")
        self.desired = view("desired_position", "desired_angular_acceleration")
        W = np.zeros((6, robot.m))
        self.live = Present(W, view("wrench"), view("tension"), view("status", "at_limit"))
        self.cables = Cables.of(parts.controlled, None if parts.believed is None else robot)
        self.true_W = W if parts.believed is None else np.zeros((6, robot.m))
        parts.controller.connect(self.live.report)
        parts.controller.sense(read_only(view("length", "rate").reshape(2, robot.m)))

    def view(self, first: str, last: str | None = None) -> Array:
        """Return the columns from the field `first` to `last`, live."""
        return self.row[self.layout.span(first, last or first)]

    def looking(self, period: float) -> Look:
        """Return what looks at the plant a control `period` (s) after the last time; 0 where no time has passed."""
        parts, backend, robot = self._parts, self._parts.backend, self._parts.robot
        energies = self.view("kinetic", "external_work")
        seen = Seen(self.state, self.true_W, self.view("length"), self.view("rate"), energies)
        body = Body(lines(robot), robot.inertial, backend.gravity, acceleration_bounds(robot, backend.gravity))
        look = observing(body, Shown(backend.state, backend.external, backend.highest), seen, period)
        if not parts.ideal_cables and period:
            look = self._with_winches(look, energies[2:3])
        return look if parts.believed is None else self._with_belief(look, parts.believed)

    def completing(self, distribute: Act, events: Sequence[ScenarioEvent]) -> Act:
        """Return what distributes, and then writes what only plant and true robot know; raises BeyondLimits if told."""
        if not self._parts.ideal_cables:
            distribute = self._reading(distribute)
        if self._parts.believed is not None:
            distribute = self._exerting(distribute)
        return self._within(distribute, events) if self._parts.limits == "stop" else distribute

    def _with_winches(self, look: Look, cable_work: Array) -> Look:
        """Read the work (1,) that only the plant knows where cables are not ideal."""
        backend = self._parts.backend

        def look_and_read() -> int:
            fault = look()
            cable_work[0] = backend.cable_work()
            return fault

        return look_and_read

    def _with_belief(self, look: Look, believed: Robot) -> Look:
        """Write the W that the stage works with."""
        spare = np.zeros(believed.m), np.zeros(believed.m)
        think = partial(believe, lines(believed), self.state, self.live.W, *spare)
        return lambda: look() or think()

    def _reading(self, distribute: Act) -> Act:
        """Read the tensions (m,), too, that only the plant knows where cables are not ideal."""
        backend, tension, cable_tension = self._parts.backend, self.live.tension, self.view("cable_tension")

        def distribute_and_read() -> None:
            distribute()
            backend.command[...] = tension
            backend.read_tension(cable_tension)

        return distribute_and_read

    def _exerting(self, distribute: Act) -> Act:
        """Write what the cables exert in truth, too, and how far their commands are from their true limits."""
        command, cables = self.live.tension, self.cables
        tension = command if self._parts.ideal_cables else self.view("cable_tension")
        exerted = partial(exert, self.true_W, tension, self.view("true_wrench"))
        measured = partial(true_margin, cables.true_limits, command, cables.held, self.view("true_margin"))

        def distribute_and_exert() -> None:
            try:
                distribute()
            finally:  # a sample that tells why there are no tensions tells what they do, too
                exerted()
                measured()

        return distribute_and_exert

    def _within(self, distribute: Act, events: Sequence[ScenarioEvent]) -> Act:
        """End the run at the first sample at which a cable leaves its limits."""
        robot, row = self._parts.robot, self.row[None]
        names = [cable.name for cable in robot.cables]
        limits = np.array([robot.tension_min, robot.tension_max])
        about = self.layout, bounds_of(robot), limits, broken(events, names, self._parts.control_step)
        reach = beyond(*about)

        def distribute_within() -> None:
            distribute()
            if reach.add(row):
                here = beyond(*about)
                here.add(row)
                left = "; ".join(one.text(names) for one in here.told())
                raise BeyondLimits(f"{left}; the scenario says limits: stop")

        return distribute_within if reach.any else distribute
