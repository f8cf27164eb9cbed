"""Interface of physics backends."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import Any, NamedTuple, NoReturn

import numpy as np

from cdpr.base.errors import PluginError
from cdpr.base.problems import shown
from cdpr.mechanics.anchors import Anchors
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins.environment import Environment
from cdpr.plugins.plugin import Plugin

Operations = list[Callable[[], object]]  # executed in order


class Phases(NamedTuple):
    """Operations of a physics step, of the platform or of the engine's world.

    Platforms in one world do `load`, the world does one `step`, and they `read`; after the last physics step of a
    control step, they `publish`.

    Attributes:
        load: operations that write the forces on the platform into the engine.
        step: operations that advance the engine's world by one physics step.
        read: operations that read the platform's motion from the engine.
        publish: operations that write what the caller reads, such as `state`.

    Example:
        >>> from cdpr.plugins.backend import Phases
        >>> phases = Phases([lambda: print("load")], [lambda: print("step")], [lambda: print("read")])
        >>> for operation in phases.several(2):
        ...     operation()
        load
        step
        read
        load
        step
        read
    """

    load: Operations
    step: Operations
    read: Operations
    publish: Operations = []  # noqa: RUF012 - never changed

    def several(self, n: int) -> Operations:
        """Return the operations of n physics steps of a world with one platform."""
        return [*self.load, *self.step, *self.read] * n + [*self.publish]


def check_operations(given: object, place: str) -> None:
    """Raise PluginError with the place, such as "Mine.operations", unless a plugin returned a list of functions."""
    if not isinstance(given, list | tuple):
        raise PluginError(f"{place}: expected a list of functions, got {shown(given)}")
    for i, each in enumerate(given):
        if not callable(each):
            raise PluginError(f"{place}[{i}]: expected a function, got {shown(each)}")


def checked_phases(given: object, place: str) -> Phases:
    """Return the phases that a plugin returned.

    Raises:
        PluginError: with the place, such as "Mine.phases", unless they are Phases of lists of functions.
    """
    if not isinstance(given, Phases):
        raise PluginError(f"{place}: expected Phases, got {shown(given)}")
    for name, operations in given._asdict().items():
        check_operations(operations, f"{place}.{name}")
    return given


class Backend(Plugin):
    """Plant that moves the platform under the command of each cable.

    The caller writes `command` and `external`, which hold until they are written again, and reads `state`. The arrays
    are created here and never replaced, so that both sides may keep a reference.

    Args:
        robot: geometry and mass properties of the plant.
        gravity: (3,), m/s^2, world.
        physics_step: time step of the engine, s.
        options: instance of the plugin's options model; None if it has none.

    Attributes:
        command: (m,), command of each cable: a tension, N, or what its winch takes (`cdpr.cables.commands_of`): the
            unwound length, m, or its rate, m/s. The first command of the latter after `reset` is its unwound length.
        external: (6,), additional wrench on the platform at its origin, world axes: force, N, then moment, N m.
        state: (13,), state of the platform in the layout of `cdpr.model`; current after `reset` and after `step`.
        highest: (m,), largest magnitude of each tension since `reset`, N; with ideal cables the command itself.
        brakes: (m,), torque of the brake of each winch without power, N m, negative for winches with power; written by
            the caller, and negative after `reset`. None, the default, for a backend without the feature `brakes`.
        shared_world: engine's world, if it has other platforms, too: those of the backends with the same object. They
            are advanced together, by `phases`. None, the default, for a world of its own.

    Example:
        >>> import cdpr
        >>> class Still(cdpr.plugins.Backend):
        ...     def reset(self, state):
        ...         self.state[:] = state
        ...     def step(self, n):
        ...         pass
        >>> run = cdpr.simulate("caroca", backend=Still, overrides={"simulation.duration": 0.1})
        >>> bool((run.position == run.position[0]).all())
        True
    """

    shared_world: object | None = None
    brakes: Array | None = None

    def __init__(self, robot: Robot, gravity: Array, physics_step: float, options: Any) -> None:
        self.robot = robot
        self.gravity = np.array(gravity, dtype=np.float64)
        self.physics_step = physics_step
        self.options = options
        self.command = np.zeros(robot.m)
        self.external = np.zeros(6)
        self.state = np.zeros(13)
        self.highest = self.command

    @abstractmethod
    def reset(self, state: Array) -> None:
        """Set the platform to `state` (13,) and the clock to zero.

        Args:
            state: (13,), layout of `cdpr.model`.
        """

    @abstractmethod
    def step(self, n: int) -> None:
        """Advance by n physics steps without checks: the caller checks `state` after each call.

        Args:
            n: number of physics steps, at least 1.
        """

    def surround(self, environment: Environment) -> None:
        """Simulate the platform in an environment from the next `reset` on.

        It is called at most once, before the first `reset`, and only if a scenario contains parts of an environment
        that affect the motion. Backends that support this declare them in the property `surroundings`.

        Args:
            environment: environment of the platform.

        Raises:
            PluginError: if the backend does not implement it.
        """
        raise PluginError(f"{type(self).__name__} does not support an environment")

    def renew(self, robot: Robot) -> bool:
        """Continue with a robot that has another platform; return False if that needs a new backend.

        The robots differ in mass, centre of mass and inertia, and in what does not affect the motion. Rollouts call
        this in place of the constructor, and then `reset`.

        Args:
            robot: robot with the other platform.

        Returns:
            True if the object continues with the robot.
        """
        return False

    def load(self, robot: Robot) -> None:
        """Change mass, centre of mass and inertia of the platform between two steps.

        `robot` differs in its platform only. Pose and twist of the platform's origin, clock, commands and works do not
        change: the added mass moves with the platform. `reset` keeps the new platform. Snapshots need not contain the
        platform: before `restore`, the caller calls `load` with the robot of the snapshot. Backends that support this
        declare the property `load: True`.

        Args:
            robot: robot with the other platform.

        Raises:
            PluginError: if the backend does not implement it.
        """
        raise PluginError(f"{type(self).__name__} cannot change the mass of the platform during a run")

    def follow(self, anchors: Anchors) -> None:
        """Use anchors on the frame that move from now on; called at most once, before a `reset`.

        The backend evaluates `anchors` whenever it evaluates its cables, at the time of that evaluation, see
        `PlantAnchors` of `cdpr.mechanics.anchors`. Backends that support this declare `moving_anchors` in the property
        `features`.

        Args:
            anchors: live arrays of the anchors.

        Raises:
            PluginError: if the backend does not implement it.
        """
        raise PluginError(f"{type(self).__name__} does not support anchors that move")

    def operations(self, n: int) -> Operations | None:
        """Return the operations of `step` for this n in order; None if it is not made of operations.

        The loop calls compiled operations without Python: results of `cdpr.native.bind.bind` or
        `cdpr.native.foreign.Foreign`. If one returns a value other than 0, the loop calls `refuse` with it.

        Args:
            n: number of physics steps, at least 1.

        Returns:
            The operations in order, or None.
        """
        return None

    def phases(self) -> Phases | None:
        """Return the operations of a physics step, so that several platforms can share the engine's world.

        `load`, `step` and `read` n times and then `publish` equal `step(n)`. Their kinds are those of `operations`.

        Returns:
            The operations by phase; None if platform and world cannot be separated.
        """
        return None

    def refuse(self, code: int) -> NoReturn:
        """Raise the error for a nonzero return value of one of `operations`.

        Args:
            code: value that the operation returned.

        Raises:
            PluginError: always.
        """
        raise PluginError(f"{type(self).__name__} gave up a step with code {code}")

    def read_tension(self, tension: Array) -> None:
        """Write the tension of each cable (m,) at `state` under `command`, N; with ideal cables the command itself.

        Backends with other cables declare them in the property `cable_models`, see `cdpr.cables`, and provide tensions,
        `highest` and `cable_work`.

        Args:
            tension: (m,), N; written.
        """
        tension[:] = self.command

    def cable_work(self) -> float:
        """Return the work of the cables on the platform since `reset`, J; not called for ideal cables."""
        raise PluginError(f"{type(self).__name__} supports only ideal cables")

    def readings(self, tension: Array, work: Array) -> tuple[Operations, Operations] | None:
        """Return the operations of `read_tension(tension)` and of `work[0] = cable_work()`, as in `operations`.

        Args:
            tension: (m,), N; written by the first operations.
            work: (1,), J; written by the second operations.

        Returns:
            Both lists of operations; None if there are none.
        """
        return None

    def winch_readings(self, unwound: Array, unwinding: Array, torque: Array) -> Operations:
        """Return the operations that write the state of the winches; for backends with the feature `winch_commands`.

        Args:
            unwound: (m,), unwound unstretched length, m; NaN before the first command.
            unwinding: (m,), its rate, m/s.
            torque: (m,), torque of the motor about the drum's axis, N m; NaN for a winch without one.

        Returns:
            The operations, as in `operations`.

        Raises:
            PluginError: if the backend does not implement it.
        """
        raise PluginError(f"{type(self).__name__} does not support winches with a length or rate as their command")

    def winch_tensions(self, tension: Array) -> Operations:
        """Return the operations that write tensions at the winches, for backends with the feature `exit_friction`.

        Args:
            tension: (m,), N, of each cable between winch and exit. They follow the operations of `readings`.

        Returns:
            The operations, as in `operations`.

        Raises:
            PluginError: if the backend does not implement it.
        """
        raise PluginError(f"{type(self).__name__} does not support friction on pulleys")

    def drum_readings(self, angle: Array, speed: Array, torque: Array, power: Array) -> Operations:
        """Return the operations that write the motion of the drums, after those of `readings`.

        Args:
            angle: (m,), angle of the drum, rad, 0 at the home pose (`cdpr.cables.transmission`).
            speed: (m,), its speed, rad/s, positive when winding in.
            torque: (m,), torque of the motor about the drum's axis, N m.
            power: (m,), its power, W.

        Returns:
            The operations, as in `operations`; none, so that the columns are NaN, if the backend does not know them.
        """
        return []

    def bent_readings(self, unstretched: Array, bending: Array) -> Operations | None:
        """Return the operations that read cables which sag, after those of `readings`.

        Args:
            unstretched: (m,), m, unstretched lengths between winch and platform; written.
            bending: (6,), N and N m, wrench of the cables on the platform minus W t with t their tensions, about the
                platform's origin, world axes; written.

        Returns:
            The operations; None if the backend does not support cables that sag.
        """
        return None

    def engine_time(self) -> float | None:
        """Return the time since `reset` by the engine's own clock, s, or None if it has none.

        It serves to detect an engine that reset itself.
        """
        return None

    def clock_act(self, clock: Array) -> Callable[[], object]:
        """Return the operation that writes `engine_time` into `clock` (1,), as in `operations`.

        It is called only if the engine has a clock.

        Args:
            clock: (1,), s; written.

        Returns:
            The operation.
        """

        def read() -> None:
            clock[0] = self.engine_time()

        return read
