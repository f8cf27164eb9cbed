"""Interface of estimators, which compute the state that controller and tension stage use."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from cdpr.base.errors import CdprError
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins.plugin import Plugin
from cdpr.sensing.sensor import Sensor

S = TypeVar("S", bound=Sensor)


@dataclass(frozen=True, eq=False)
class SensorModel:
    """Sensor as an estimator knows it, with its live measurements.

    Attributes:
        sensor: the sensor with its nominal mount and errors; its `quantities` define the order of `measured`.
        measured: (n,), the last measurement that has arrived, held; live and read-only.
        age: (1,), s, time since it was taken; likewise.
        fresh: (1,), 1 at the control step in which it arrived, else 0; likewise.

    Example:
        >>> import numpy as np
        >>> import cdpr
        >>> arrays = np.zeros(16), np.zeros(1), np.ones(1)  # lengths and rates of eight cables, age, fresh
        >>> cdpr.plugins.SensorModel(cdpr.sensing.Encoders(name="drums"), *arrays).title
        'drums'
    """

    sensor: Sensor
    measured: Array
    age: Array
    fresh: Array

    @property
    def title(self) -> str:
        """Name of the sensor."""
        return self.sensor.title


@dataclass(frozen=True, eq=False)
class EstimatorInputs:
    """Live, read-only inputs of an estimator besides the measurements.

    Attributes:
        time: (1,), s, time of the present sample.
        start: (13,), state from which the estimate begins, in the layout of `cdpr.model`; fixed.
        command: (m,), command of each cable as sent in the previous control period, before faults act on it; 0 before
            the first one.
        commands: its quantity: "tension", N, "length", m, or "rate", m/s.
        tension: (m,), N, the tensions as sent; for winches that take lengths or rates, those of the nominal cables at
            rest. Equal to `command` for tensions.
        limits: (2, m), N, lowest and highest tensions that the tension distribution knows.
        held: (m,), True for cables known to be broken or jammed.

    Example:
        >>> import cdpr
        >>> class Motionless(cdpr.plugins.Estimator):
        ...     def connect(self, inputs):
        ...         self.inputs = inputs
        ...     def estimate(self, time, out):
        ...         out[:] = self.inputs.start
        >>> [name for name in ("start", "command") if name in cdpr.plugins.EstimatorInputs.__annotations__]
        ['start', 'command']
    """

    time: Array
    start: Array
    command: Array
    commands: tuple[str, ...]
    tension: Array
    limits: Array
    held: NDArray[np.bool_]


class Estimator(Plugin):
    """Estimator of the platform's state from measurements and commands.

    Attributes:
        covariance: (12, 12), live covariance of the error of the estimate; None if it provides none. The error consists
            of the position, m, the attitude as the rotation vector e, rad, in platform axes with q_true = q_estimate *
            exp(e / 2), the velocity, m/s, and the angular velocity, rad/s; true minus estimated values, world axes.
        nis: (1,), live: normalised innovation squared of the measurements that arrived at the present sample; NaN if
            none arrived. None if it provides none.
        nis_size: (1,), live: number of values in it, 0 if none arrived; given together with `nis`.

    Args:
        robot: geometry, limits and degrees of freedom; the nominal robot, if the scenario has one.
        gravity: (3,), m/s^2, world.
        control_step: time between two calls, s.
        sensors: sensors of the scenario.
        options: instance of the plugin's options model; None if it has none.

    Example:
        >>> import cdpr
        >>> class Motionless(cdpr.plugins.Estimator):
        ...     def connect(self, inputs):
        ...         self.inputs = inputs
        ...     def estimate(self, time, out):
        ...         out[:] = self.inputs.start
        >>> Motionless.covariance is None
        True
    """

    covariance: Array | None = None
    nis: Array | None = None
    nis_size: Array | None = None

    def __init__(
        self, robot: Robot, gravity: Array, control_step: float, sensors: Sequence[SensorModel], options: Any
    ) -> None:
        self.robot = robot
        self.gravity = gravity
        self.control_step = control_step
        self.sensors = tuple(sensors)
        self.options = options

    @abstractmethod
    def estimate(self, time: float, out: Array) -> None:
        """Write the estimated state at this control step, from its measurements and the commands before it.

        Args:
            time: time since the start of the run, s; 0 at the first sample, where the estimate begins anew.
            out: (13,), layout of `cdpr.model`; it contains the estimate of the previous control step, and at time 0
                undefined values.
        """

    def compiled(self, out: Array) -> Sequence[Callable[..., object]] | None:
        """Return the compiled operations that `estimate` performs on this array; None if there are none.

        The loop then calls them without Python. Each is a result of `cdpr.native.bind.bind`, which receives the time,
        s, as its argument.

        Args:
            out: (13,), as in `estimate`.

        Returns:
            The operations, or None.
        """
        return None

    def connect(self, inputs: EstimatorInputs) -> None:
        """Store further live inputs; called once, before the first `estimate`."""

    def reset(self) -> None:
        """Clear the memory of earlier calls."""

    def of_type(self, kind: type[S]) -> list[SensorModel]:
        """Return the sensors of a type, in their order."""
        return [each for each in self.sensors if isinstance(each.sensor, kind)]

    def first(self, kind: type[S]) -> SensorModel:
        """Return the first sensor of a type.

        Raises:
            CdprError: if there is none, with what to add.
        """
        found = self.of_type(kind)
        if not found:
            name = str(kind.model_fields["type"].default)
            present = ", ".join(each.sensor.type for each in self.sensors) or "none"
            raise CdprError(
                f"the estimator needs a sensor of the type {name}; the scenario has {present}: add `- type: {name}` to "
                "sensors, or choose another estimator"
            )
        return found[0]
