"""Requests that act on the robot of a simulation: they become events and commands of its session."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from itertools import count
from typing import Any

from cdpr.base.errors import CdprError
from cdpr.model.arrays import checked
from cdpr.scenario.events.loads import Wrench
from cdpr.scenario.events.payload import Payload
from cdpr.simulation.manual import CableRequest, ManualControl, cable_requests
from cdpr.simulation.requests import CommandWarning, Level, Request
from cdpr.simulation.session import acting_span
from cdpr.simulation.simulation import Simulation

MOVE = 2.0  # s, default duration of a move to a target
NOT_SIMULATED = "not simulated: correct the errors and apply, or reset"


class RobotRequests:
    """Requests to the robot of a simulation, which a driver executes between two steps.

    Attributes:
        pushes: wrenches and attached bodies added by requests, by number.
    """

    def __init__(self) -> None:
        self._numbers = count(1)
        self.act_on(None)

    def act_on(self, simulation: Simulation | None) -> None:
        """Act on another simulation, or on none."""
        self._simulation = simulation
        self.pushes: dict[int, Wrench | Payload] = {}
        self._wrench: Wrench | None = None
        self._payload: tuple[Payload | None, tuple[float, ...]] = None, ()
        self._target_warned = False  # if the last target was doubtful
        self._manual: ManualControl | None = None
        if simulation is not None:
            self._manual = ManualControl(simulation, partial(self.report, Request("jog"), "warning"))

    @property
    def simulation(self) -> Simulation:
        """Return the simulation.

        Raises:
            CdprError: if there is none.
        """
        if self._simulation is None:
            raise CdprError(NOT_SIMULATED)
        return self._simulation

    @property
    def manual(self) -> ManualControl:
        """Return the manual control of the simulation.

        Raises:
            CdprError: if there is no simulation.
        """
        if self._manual is None:
            raise CdprError(NOT_SIMULATED)
        return self._manual

    def report(self, request: Request, level: Level, text: str) -> None:
        """Report the result of a request."""
        if request.reply is not None:
            request.reply(level, text)

    def changed(self, parameters: Mapping[str, Any]) -> None:
        """Show changed parameters."""

    def acting(self) -> Iterator[tuple[int, Wrench | Payload]]:
        """Yield the pushes and bodies that can be released, with their numbers."""
        simulation = self.simulation
        for key, push in self.pushes.items():
            span = acting_span(push, simulation.scenario.simulation.control_step)
            if span is not None and span.end > simulation.samples and not simulation.done:
                yield key, push

    def request_target(
        self, position: Any = None, orientation: Any = None, rpy: Any = None, duration: Any = None
    ) -> Any:
        """Move the desired pose to a target, as `Simulation.target`; the first doubtful target causes a warning."""
        simulation, attitude = self.simulation, orientation if rpy is None else {"rpy": rpy}
        simulation.target(position, attitude, duration=MOVE if duration is None else duration)
        doubts, warned = [*simulation.scenario.doubts(simulation.events)], self._target_warned
        if self.manual.active:
            doubts.append("has no effect until the controller has control of the cables again")
        self._target_warned = bool(doubts)
        return CommandWarning(f"target: {'; '.join(doubts)}") if doubts and not warned else None

    def request_push(self, force: Any = (0.0,) * 3, moment: Any = (0.0,) * 3, duration: float | None = None) -> None:
        """Add a wrench, N and N m."""
        self.pushes[next(self._numbers)] = self.simulation.push(force, moment, duration=duration)

    def request_attach(
        self,
        mass: float,
        center: Any = (0.0,) * 3,
        inertia: Any = (0.0,) * 6,
        duration: float | None = None,
        known: bool = False,
    ) -> None:
        """Attach a rigid body to the platform, as `Simulation.attach`."""
        body = self.simulation.attach(mass, center, inertia, duration=duration, known=known)
        self.pushes[next(self._numbers)] = body

    def request_release(self, id: int) -> None:
        """End a push or detach a body, given by its number."""
        push = next((push for key, push in self.acting() if key == id), None)
        if push is None:
            raise CdprError("release: that push has ended, or that body is released")
        self.simulation.release(push)
        del self.pushes[id]

    def request_wrench(self, force: list[float], moment: list[float]) -> None:
        """Apply this wrench from now on instead of the previous one of such a request; zero ends it."""
        before, simulation = self._wrench, self.simulation
        force, moment = (
            checked(values, (3,), f"wrench: {name}", finite=True).tolist()
            for name, values in (("force", force), ("moment", moment))
        )
        if before is not None and (list(before.force), list(before.moment)) == (force, moment):
            return
        keys = {"force": force, "moment": moment}
        wrench = simulation._do("wrench", Wrench, keys) if any(force + moment) else None
        if before is not None:
            simulation.release(before)
        self._wrench = wrench

    def request_payload(self, mass: float, center: list[float], inertia: list[float]) -> None:
        """Attach this body instead of the previous one of such a request; the mass 0 releases it."""
        simulation, given = self.simulation, (mass, *center, *inertia)
        before, values = self._payload
        if given == values:
            return
        if before is not None:
            simulation.check_release(before)  # a refusal must not leave two bodies
        body = simulation.attach(mass, center, inertia) if mass else None
        if before is not None:
            simulation.release(before)
        self._payload = body, given

    def request_tension(self, tension: list[float], names: list[str] | None = None) -> None:
        """Command these tensions, N, from now on; an empty list returns control to the controller.

        The order is that of the cables, or of `names`.
        """
        self.manual.tensions(tension, names)

    def request_winch_command(self, names: list[str], length: list[Any], rate: list[Any], tension: list[Any]) -> None:
        """Command lengths (m), rates (m/s) and tensions (N) of single cables; without any, the controller has control.

        `names` may be empty for all cables in order. Each list is empty, or as long as `names`, with None for a cable
        without such a value.
        """
        if not (length or rate or tension):
            self.manual.release()
            return
        cables = [each.name for each in self.simulation.scenario.robot.cables]
        self.manual.command("winch_command", cable_requests(names, length, rate, tension, cables))

    def request_jog(self, cable: str | int, rate: Any = None, length: Any = None) -> None:
        """Wind a cable at a rate, m/s, until the next request or up to a length, m; all others hold."""
        self.manual.command("jog", [(cable, CableRequest(length, rate))])

    def request_hold(self) -> None:
        """Stop all winches that take lengths or rates."""
        self.manual.hold()

    def request_control(self) -> None:
        """Return control of the winches to the controller."""
        self.manual.release()

    def request_stop(self, category: int | None = None, stopping_time: float | None = None) -> None:
        """Stop the robot, as `Simulation.stop`; requested tensions end, and further ones are rejected."""
        self.simulation.stop(category, stopping_time=stopping_time)

    def request_limits(self, tension_min: float | None = None, tension_max: float | None = None) -> None:
        """Change the tension limits of all cables, N."""
        self.simulation.limits(tension_min, tension_max)

    def request_set(self, key: str, value: Any) -> None:
        """Set an option of the controller or solver."""
        self.simulation.set(key, value)
        self.changed({key: value})
