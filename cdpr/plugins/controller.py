"""The interface of a controller."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any, Literal, NamedTuple

from cdpr.errors import PluginError
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.own import Own

# What a controller may declare as `PluginInfo.properties["output"]`; "wrench" where it declares nothing.
Output = Literal["wrench", "command"]


class Tunable(NamedTuple):
    """Option of a controller that its compiled operation reads in an array.

    Attributes:
        array: The array, or a view of the part of it that holds the option.
        value: The option, of the array's shape.
        per_step: Whether the array holds the option times the control step.
    """

    array: Array
    value: Array
    per_step: bool = False


class Controller(ABC):
    """Decides what the cables must do: the wrench that they exert on the platform, or the command of each.

    Its `PluginInfo` says which, as `properties={"output": "wrench"}` or `{"output": "command"}`. A wrench is
    distributed among the cables by the tension stage. Commands go to the cables directly, clipped to their limits:
    no solver takes part. Where that depends on its options, the attribute `output` of the controller says it.

    `gravity` is (3,), m/s^2, world; `control_step` is the time between two calls, s.
    """

    output: Output | None = None
    source: Own | None = None  # of its compiled operation, if that is not in the kernel library

    def __init__(self, robot: Robot, gravity: Array, control_step: float, options: Any) -> None:
        self.robot = robot
        self.gravity = gravity
        self.control_step = control_step
        self.options = options

    @abstractmethod
    def control(self, time: float, state: Array, desired: Array, out: Array) -> None:
        """Write the output for this control step into `out`, all of it.

        With output "wrench", `out` is (6,): force, N, and moment about the platform's origin, N m, world axes. With
        "command" it is (m,): the command of each cable, N. `state` is (13,) and `desired` (19,), laid out as
        `cdpr.model` says; neither may be changed. `out` holds no particular values at the call.
        """

    def compiled(self, state: Array, desired: Array, out: Array) -> Callable[[], object] | None:
        """Return what `control` does with these arrays, whatever the time, as a compiled operation; None without one.

        The loop then calls it without Python. It is what `cdpr.native.bind.bind` returns, or a
        `cdpr.native.foreign.Foreign`. A code other than 0 ends the run with PluginError.
        """
        return None

    def tunable(self) -> Mapping[str, Tunable]:
        """Return the options that stay parameters of an exported FMU, by name; the others are constant there."""
        return {}

    def connect(self, report: Array) -> None:  # noqa: B027 - an optional hook
        """Take a live view of what became of the previous output; called once, before the first `control`.

        `report` is (4,): a `cdpr.tension.Status`, the residual of the wrench (N), the distance of the tensions from
        their limits (N) and the number of cables at one; zeros before the first step. Where the status is not OK, the
        cables did not do what was asked: an integral must not wind up then.
        """

    def sense(self, cables: Array) -> None:  # noqa: B027 - an optional hook
        """Take a live view of what is measured at the cables; called once, before the first `control`.

        `cables` is (2, m): lengths, m, and rates, m/s, of the robot as it is. `self.robot`, which is the robot as it is
        believed to be, may have others at the same state.
        """

    def log(self, columns: Mapping[str, Array]) -> None:
        """Take the arrays (width,) of the columns that its `PluginInfo` declares, by name, to write into.

        Called as soon as it is made, with arrays that nobody reads, and again by a simulation with those that it
        records: what stands in them after `control`, and NaN until something is written.
        """
        raise PluginError(f"{type(self).__name__} declares columns and has no method `log` to take them")

    def change(self, options: Any) -> None:
        """Take other options between two steps; only those differ that its `PluginInfo` declares as `changeable`.

        Nothing else changes: what is remembered of earlier calls stays. Raises CdprError, having changed nothing, where
        they do not fit the robot.
        """
        raise PluginError(f"{type(self).__name__} declares changeable options and has no method `change` to take them")

    def reset(self) -> None:  # noqa: B027 - an optional hook
        """Forget what was kept from earlier calls."""

    def snapshot(self) -> object:
        """Return all that its future answers depend on, beside the arguments of `control`, for `restore`.

        `cdpr.plugins.SnapshotOfArrays` does it for what is kept in arrays, or nowhere.
        """
        raise PluginError(f"{type(self).__name__} cannot take snapshots")

    def restore(self, snapshot: object) -> None:
        """Go back to a snapshot of this controller: what follows is the same to the bit."""
        raise PluginError(f"{type(self).__name__} cannot restore snapshots")

    def describe(self) -> dict[str, Any]:
        """Return what the record of a run should say of it beyond its options: plain data, as JSON holds it."""
        return {}

    def close(self) -> None:  # noqa: B027 - an optional hook
        """Free what the controller holds; it is not used afterwards."""
