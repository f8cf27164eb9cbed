"""Base class of rigid-body engines: cables, external wrench, and body frames."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np

from cdpr.base.errors import PluginError
from cdpr.cables import immediate
from cdpr.mechanics.anchors import Anchors, PlantAnchors
from cdpr.mechanics.body_frame import BodyFrame
from cdpr.mechanics.winches import Winches
from cdpr.model import Robot
from cdpr.model.arrays import checked
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.plugins.backend import Backend, Operations, Phases, check_operations, checked_phases
from cdpr.plugins.compiled import speaks_for
from cdpr.plugins.inertia import Inertia, check_held, check_range


class RigidBodyBackend(Backend):
    """Backend on an engine that integrates a rigid body under an applied wrench.

    The engine's file implements `build`, `write`, `read` and `advance`, and `push` if `applied` is no array of the
    engine. This class evaluates the cable geometry and the
    tensions once per physics step, for all cable models (declared as the property `cable_models`). `frame` describes
    the body to build. The frame of a free platform is at the centre of mass along the principal axes. A guided platform
    (`frame.guide`) has its frame at the origin; it moves by slides along world axes and then a hinge, or rotates on a
    ball joint at its origin (`frame.guide.spherical`).

    An engine that stores mass and inertia returns them in `held`: a difference ends a run before its first step. An
    engine that does not support very light bodies declares `smallest` or `slimmest`, and `title`, its name in messages.

    Attributes:
        frame: mass, centre, principal moments and axes, anchors and guide of the body.
        body: (13,), its state: position of the body frame's origin (world), attitude w, x, y, z, velocity of that
            origin (world), angular velocity (world).
        winches: winches that convert commands into tensions; None if cables are ideal.
        applied: (6,), wrench for the next step in addition to gravity: force, moment about the body frame's origin,
            world axes. The operation `guide_forces` writes those along slides and hinge.

    Example:
        >>> import cdpr
        >>> class PointMass(cdpr.plugins.RigidBodyBackend):
        ...     def build(self):
        ...         pass
        ...     def write(self):
        ...         pass
        ...     def read(self):
        ...         pass
        ...     def advance(self):
        ...         self.body[7:10] += self.physics_step * (self.applied[:3] / self.frame.mass + self.gravity)
        ...         self.body[:3] += self.physics_step * self.body[7:10]
        >>> run = cdpr.simulate("caroca", backend=PointMass, overrides={"simulation.duration": 0.1})
        >>> run.status
        'finished'
    """

    smallest: ClassVar[float] = 0.0  # smallest supported mass, kg, and principal moment, kg m^2
    slimmest: ClassVar[float] = 0.0  # smallest supported radius of gyration, m, limited by round-off
    title: ClassVar[str] = ""  # name of the engine in messages; by default that of the class

    def __init__(self, robot: Robot, gravity: Array, physics_step: float, options: Any) -> None:
        super().__init__(robot, gravity, physics_step, options)
        self.frame = BodyFrame(robot)
        check_range(self.frame, self._title, self.smallest, self.slimmest)
        self.body = np.zeros(13)
        self.assemble()

    def assemble(self) -> None:
        """Build the world, and bind the operations to its arrays.

        An engine calls it again if `build` depends on something that changed, such as the environment in `surround`.
        """
        robot, frame = self.robot, self.frame
        self.applied = np.zeros(6)
        self.build()
        self._wanted = np.zeros(13)
        self._place = bind("body_state", offset=frame.offset, state=self._wanted, body=self.body)
        self._pull: Callable[[], object] = bind(
            "applied_wrench",
            lines=frame.line_table,
            offset=frame.offset,
            tension=self.command,
            external=self.external,
            body=self.body,
            applied=self.applied,
        )
        self._publish = bind("platform_state", offset=frame.offset, body=self.body, state=self.state)
        self._anchors: PlantAnchors | None = None
        self._placing: Operations = []  # of anchors that move, before a step
        self.winches: Winches | None = None
        if not immediate(robot):
            self.winches = winches = Winches(
                robot, frame, self.gravity, self.command, self.external, self.body, self.applied, self.physics_step
            )
            self._pull, self.highest, self.brakes = winches.step, winches.highest, winches.brakes

    @abstractmethod
    def build(self) -> None:
        """Create the world. An engine with its own wrench array (C-contiguous) sets `applied` to it here."""

    @abstractmethod
    def write(self) -> None:
        """Set the engine's body to `body` and its clock to zero, and clear all earlier forces."""

    @abstractmethod
    def read(self) -> None:
        """Read the engine's body into `body`."""

    def push(self) -> None:
        """Write `applied` into the engine, for its next step; by default `advance` does that."""

    @abstractmethod
    def advance(self) -> None:
        """Advance the engine's world by one physics step under gravity and what `push` wrote."""

    def load_body(self) -> None:
        """Give the engine the mass properties of `frame` and, for a free platform, the state `body`.

        The clock does not change. Engines that implement this declare the property `load: True`.

        Raises:
            PluginError: if the engine does not implement it.
        """
        raise PluginError(f"{self._title} cannot change the mass of the platform during a run")

    def held(self) -> Inertia | None:
        """Return the inertia that the engine stores after `write`, read back from it; None if it stores none."""
        return None

    def reset(self, state: Array) -> None:
        """Set the platform to `state` (13,).

        Raises:
            PluginError: if the engine's body differs from `frame`.
        """
        self._wanted[:] = checked(state, (13,), "state")
        self._place()
        self.write()
        if (held := self.held()) is not None:  # checked here, because some engines are rebuilt by `write`
            check_held(self.frame, held, self._title)
        self.read()
        self._publish()
        if self._anchors is not None:
            self._anchors.reset()
        if self.winches is not None:
            self.winches.reset()

    def follow(self, anchors: Anchors) -> None:
        """Evaluate the cables with anchors that move, at the start of each physics step."""
        self._anchors = own = PlantAnchors(anchors, self.frame.line_table, self.physics_step)
        if self.winches is None:
            self._placing = [own.before_step()]
        else:
            self.winches.follow(own)
            self._pull = self.winches.step

    def load(self, robot: Robot) -> None:
        """Change mass, centre of mass and inertia; pose and twist of the platform's origin do not change.

        Raises:
            PluginError: if the engine does not support it, or its body differs from `frame`.
        """
        if self.winches is not None:
            self.winches.settle_before_change()
        self.robot = robot
        self.frame.refill(robot)
        check_range(self.frame, self._title, self.smallest, self.slimmest)
        if self.frame.guide is None:  # that of a guided platform is at its origin
            self._wanted[:] = self.state
            self._place()
        if self.winches is not None:
            self.winches.change_body(robot, self.frame)
        self.load_body()
        if (held := self.held()) is not None:
            check_held(self.frame, held, self._title)
        self.read()

    def step(self, n: int) -> None:
        """Advance by n physics steps."""
        for _ in range(n):
            for place in self._placing:
                place()
            self._pull()
            self.push()
            self.advance()
            self.read()
        self._publish()

    def operations(self, n: int) -> Operations:
        """Return the operations of n physics steps; all but those of the engine are compiled."""
        does = self.push, self.advance, self.read, self.engine_phases
        if all(speaks_for(self.engine_operations, each) for each in does):
            own = self.engine_operations()
            check_operations(own, f"{type(self).__name__}.engine_operations")
            return [*self._placing, self._pull, *own] * n + [self._publish]
        return checked_phases(self.phases(), f"{type(self).__name__}.phases").several(n)

    def phases(self) -> Phases:
        """Return the operations of a physics step by phase; all but those of the engine are compiled."""
        does = self.push, self.advance, self.read
        known = all(speaks_for(self.engine_phases, each) for each in does)
        given = self.engine_phases() if known else RigidBodyBackend.engine_phases(self)
        load, step, read, _ = checked_phases(given, f"{type(self).__name__}.engine_phases")
        return Phases([*self._placing, self._pull, *load], step, read, [self._publish])

    def engine_phases(self) -> Phases:
        """Return the operations of `push`, `advance` and `read`, as in `operations`; kernels may replace them."""
        return Phases([self.push], [self.advance], [self.read])

    def engine_operations(self) -> Operations:
        """Return the operations of `push`, `advance` and `read` in one list, which may join operations of Python."""
        load, step, read, _ = checked_phases(self.engine_phases(), f"{type(self).__name__}.engine_phases")
        return [*load, *step, *read]

    def read_tension(self, tension: Array) -> None:
        """Write the tensions (m,)."""
        if self.winches is None:
            super().read_tension(tension)
        else:
            self.winches.settle()
            tension[:] = self.winches.tension

    def readings(self, tension: Array, work: Array) -> tuple[Operations, Operations] | None:
        """Return the operations that evaluate the winches; None if cables are ideal."""
        return None if self.winches is None else self.winches.readings(tension, work)

    def winch_readings(self, unwound: Array, unwinding: Array, torque: Array) -> Operations:
        """Return the operation that writes the state of the winches."""
        if self.winches is None:
            return super().winch_readings(unwound, unwinding, torque)
        return self.winches.reading(unwound, unwinding, torque)

    def winch_tensions(self, tension: Array) -> Operations:
        """Return the operation that writes the tensions at the winches."""
        return super().winch_tensions(tension) if self.winches is None else self.winches.winch_tensions(tension)

    def drum_readings(self, angle: Array, speed: Array, torque: Array, power: Array) -> Operations:
        """Return the operation that writes the motion of the drums; none if cables are ideal."""
        return [] if self.winches is None else self.winches.drum_readings(angle, speed, torque, power)

    def bent_readings(self, unstretched: Array, bending: Array) -> Operations | None:
        """Return the operations that read cables which sag; None if cables are ideal."""
        return None if self.winches is None else self.winches.bent_readings(unstretched, bending)

    def cable_work(self) -> float:
        """Return the work of the cables on the platform, J."""
        if self.winches is None:
            return super().cable_work()
        self.winches.settle()
        return float(self.winches.work[0])

    @property
    def _title(self) -> str:
        return self.title or type(self).__name__

    @property
    def arrays(self) -> tuple[Array, ...]:
        """Arrays of a snapshot besides the engine's own state."""
        own: tuple[Array, ...] = self.command, self.external, self.body, self.state
        own += () if self._anchors is None else self._anchors.arrays
        return own if self.winches is None else (*own, *self.winches.arrays)
