"""Interface of controllers."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, NamedTuple

from cdpr.base.errors import PluginError
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.own import Own
from cdpr.plugins.inputs import ControllerInputs
from cdpr.plugins.plugin import Plugin
from cdpr.sensing.sensor import Sensor

# Stages of outputs: a wrench is distributed; tensions go to the cables, by a map to winches that take lengths or rates;
# "winch": each command is the quantity that its winch takes.
Output = Literal["wrench", "command", "winch"]

# Values of `PluginInfo.properties["output"]`, "wrench" by default.
OUTPUTS = ("wrench", "command", "tension", "length", "rate")
COMMANDS = OUTPUTS[1:]  # a value for each cable


def stage_of_output(output: str, commands: Sequence[str]) -> Output | None:
    """Return the stage of an output.

    Args:
        output: one of `OUTPUTS`.
        commands: quantity that each winch takes, see `cdpr.cables.commands_of`.

    Returns:
        The stage; None if some winch does not take the output.
    """
    if output == "wrench":
        return "wrench"
    native = any(each != "tension" for each in commands)
    if output == "tension" or (output == "command" and not native):
        return "command"
    return "winch" if output == "command" or set(commands) == {output} else None


def listed(commands: Sequence[str]) -> str:
    """Return the quantities that winches take, for messages: "a tension or a length"."""
    return " or ".join(f"a {each}" for each in dict.fromkeys(commands))


class Tunable(NamedTuple):
    """Option of a controller that its compiled operation reads from an array.

    Attributes:
        array: array, or a view of its part, with the option.
        value: option in the array's shape.
        per_step: True if the array holds the option times the control step.
    """

    array: Array
    value: Array
    per_step: bool = False


class Controller(Plugin):
    """Controller that computes the wrench of the cables on the platform, or the command of each cable.

    Its `PluginInfo` declares the output, such as `properties={"output": "wrench"}`. The tension stage distributes a
    wrench among the cables. Other outputs have a value for each cable and need no solver:

    - "tension": tensions, N, clipped to their limits. A winch that takes a length or a rate receives those that produce
      the tension.
    - "length", "rate": unwound lengths, m, or their rates, m/s; all winches must take them.
    - "command": the quantity that the winch of the cable takes (`cdpr.cables.commands_of`).

    If the output depends on its options, the controller has an attribute `output`.

    Attributes:
        output: its output; None if the `PluginInfo` declares it.
        period: number of control steps between two calls of `control`; the output is held in between. A controller with
            a longer period runs in Python, and cannot be exported.

    Args:
        robot: geometry, limits and degrees of freedom; the nominal robot, if the scenario has one.
        gravity: (3,), m/s^2, world.
        control_step: time between two calls, s.
        options: instance of the plugin's options model; None if it has none.

    Example:
        >>> import cdpr
        >>> class Weight(cdpr.plugins.Controller):
        ...     def control(self, time, state, desired, out):
        ...         out[:] = 0.0
        ...         out[:3] = -self.robot.platform.mass * self.gravity
        >>> run = cdpr.simulate("caroca", controller=Weight, overrides={"simulation.duration": 0.1})
        >>> run.wrench[0].round(1)
        array([  -0. ,   -0. , 1471.5,    0. ,    0. ,    0. ])
    """

    output: str | None = None
    period: int = 1
    source: Own | None = None  # source of its compiled operation, if it is not in the kernel library

    def __init__(self, robot: Robot, gravity: Array, control_step: float, options: Any) -> None:
        self.robot = robot
        self.gravity = gravity
        self.control_step = control_step
        self.options = options

    @abstractmethod
    def control(self, time: float, state: Array, desired: Array, out: Array) -> None:
        """Write the complete output of this control step into `out`.

        Args:
            time: time since the start of the run, s.
            state: (13,), layout of `cdpr.model`, read-only.
            desired: (19,), desired state and accelerations, likewise.
            out: written; its initial content is undefined. With output "wrench", (6,): force, N, and moment about the
                platform's origin, N m, world axes. With others, (m,): a value for each cable, in N, m or m/s.
        """

    def compiled(self, state: Array, desired: Array, out: Array) -> Callable[[], object] | None:
        """Return the compiled equivalent of `control` on these arrays, independent of time; None if there is none.

        The loop then calls it without Python. It is a result of `cdpr.native.bind.bind` or a
        `cdpr.native.foreign.Foreign`.

        Args:
            state: (13,), layout of `cdpr.model`, read-only.
            desired: (19,), likewise.
            out: (6,) or (m,), as in `control`; written.

        Returns:
            The operation, or None.
        """
        return None

    def tunable(self) -> Mapping[str, Tunable]:
        """Return the options that remain parameters of an exported FMU, by name; others are constant there."""
        return {}

    def connect(self, report: Array) -> None:
        """Store a live view of the result of the previous output; called once, before the first `control`.

        `report` is (4,): a `cdpr.tension.Status`, the residual of the wrench (N), the distance of the tensions from
        their limits (N) and the number of cables at a limit; zeros before the first step. If the status is not OK, the
        cables did not provide the output, so integrators must not wind up.

        Args:
            report: (4,), live and read-only.
        """

    def sense(self, cables: Array) -> None:
        """Store a live view of the measurements at the cables; called once, before the first `control`.

        `cables` is (2, m): measured lengths, m, and rates, m/s; the true ones without sensors. `self.robot` is the
        nominal model, whose lengths may differ at the same state.

        Args:
            cables: (2, m), live and read-only.
        """

    def inner_loop(self, distributed: Array, tension: Array) -> Callable[[float], object] | None:
        """Return the function of time that turns distributed tensions into the tensions to send; None without one.

        It is called in each control step after the distribution of a wrench, also of one from outside, and is compiled
        if it is a result of `cdpr.native.bind.bind` that takes a time. Events then impose the tensions of broken and
        jammed cables. The log contains the sent tensions; wrench and report are those of the distribution. Only an FMU
        of the plant with its controller can contain a controller with this method, and only if the function is
        compiled. It is called once for each stage, after `observe`; all results share the memory of the controller.

        Args:
            distributed: (m,), N, live and read-only.
            tension: (m,), N; written, within the limits.
        """
        return None

    def use_sensors(self, sensors: Mapping[str, Sensor]) -> None:
        """Store the sensors whose measurements it observes; called once, before `observe`.

        A controller that needs sensors of some types declares them, such as `properties={"sensors": ("markers",)}`. The
        conformance kit then provides them.

        Args:
            sensors: sensors of the scenario by name, in their order. Their columns are in
                `ControllerInputs.measurements`.

        Raises:
            CdprError: if a sensor that it needs is missing or unsuitable.
        """

    def observe(self, inputs: ControllerInputs) -> None:
        """Store further live inputs: preview, limits, held cables, previous command, measurements.

        Called once, before the first `control`. Only an FMU of the plant with its controller can contain a controller
        with this method: other FMUs and real-time programs do not have these inputs. An FMU has no preview.

        Args:
            inputs: live and read-only.
        """

    def renew(self, robot: Robot) -> bool:
        """Continue with a robot that has another platform; return False if that needs a new controller.

        The robots differ in mass, centre of mass and inertia, and in what does not affect the motion. Rollouts call
        this in place of the constructor, and then `reset`.

        Args:
            robot: robot with the other platform.

        Returns:
            True if the object continues with the robot.
        """
        return False

    def change(self, options: Any) -> None:
        """Change the options between two steps; only options declared as `changeable` differ.

        The memory of earlier calls is kept.

        Args:
            options: instance of the plugin's options model.

        Raises:
            CdprError: if they do not fit the robot; nothing is changed then.
        """
        raise PluginError(f"{type(self).__name__} declares changeable options but has no method `change`")

    def reset(self) -> None:
        """Clear the memory of earlier calls."""
