"""Base class of sensors: what they measure, how often, how late, and with which errors.

`measurement.hpp` contains the kernel. A sensor takes a measurement every `period`, the first at time 0. The measurement
arrives after `delay` and a random part of `jitter`, or is lost with the probability `dropout`. Between arrivals, the
last one is held, and its age is logged. The random numbers depend on `simulation.seed` and the name of the sensor, so
they are the same on all engines.
"""

from __future__ import annotations

import math
import re
from abc import abstractmethod
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self

from pydantic import AfterValidator, Field

from cdpr.base.column import CABLES, Column
from cdpr.base.fields import Kind, NonNegative, unit
from cdpr.base.needs import Needs, of_sensor
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.model.shapes import Obstacle
from cdpr.sensing.disturbance import Mount
from cdpr.sensing.errors import AttitudeErrors
from cdpr.sensing.message import Message
from cdpr.sensing.records import Records
from cdpr.tension.operations import Operation

if TYPE_CHECKING:
    from cdpr.scene.sensors import SensorDrawing

LONGEST = 10.0  # s: delay, jitter and period
LONGEST_NAME = 12  # letters: its columns have names of at most 31

# Arrays of the loop that the controller uses, to which a sensor provides values.
Used = Literal["pose", "twist", "cables", ""]
Time = Annotated[NonNegative, Field(le=LONGEST)]


def _short(value: str) -> str:
    if not re.fullmatch(rf"[a-z][a-z0-9_]{{0,{LONGEST_NAME - 1}}}", value):
        raise ValueError(
            f"expected a name of at most {LONGEST_NAME} lower-case letters, digits and '_', with a letter first, got "
            f"{value[:40]!r}"
        )
    return value


def _merged(base: Any, given: Any) -> Any:
    if not (isinstance(base, dict) and isinstance(given, dict)):
        return given
    return {**base, **{key: _merged(base.get(key), value) for key, value in given.items()}}


@dataclass(frozen=True)
class Quantity:
    """Measured quantity.

    Attributes:
        key: key of its errors in the section of the sensor; its column is NAME_KEY.
        width: number of values, `CABLES` for one of each cable; 4 with a frame is an attitude.
        unit: SI.
        text: short description, as the beginning of a sentence.
        frame: axes, as of a `Column`.
        seen: key of the quantity that is 1 where these values are measured, else 0; "" if they always are.
    """

    key: str
    width: int
    unit: str
    text: str
    frame: str = ""
    seen: str = ""

    @property
    def attitude(self) -> bool:
        """True if it is an attitude quaternion, whose errors are rotations."""
        return self.width == 4 and self.frame != ""

    def values(self, cables: int) -> int:
        """Return the number of its values for a robot with this number of cables."""
        return cables if self.width == CABLES else self.width

    def components(self, cables: int) -> int:
        """Return the number of its values with errors of their own."""
        return 3 if self.attitude else self.values(cables)


@dataclass(frozen=True, eq=False)
class Sources:
    """Arrays of the loop from which sensors take true values.

    Attributes:
        robot: simulated robot.
        state: (13,), true state, live.
        gravity: (3,), m/s^2.
        step: control period, s.
        obstacles: obstacles of the world.
        view: function that returns the columns of the present row from one field to another, live.
        has: function that returns True if rows have a group of columns.
        read_winches: function that returns the operations which write the unwound lengths of the winches (m,), m, and
            their rates (m,), m/s, where the plant has winches.
    """

    robot: Robot
    state: Array
    gravity: Array
    step: float
    obstacles: tuple[Obstacle, ...]
    view: Callable[..., Array]
    has: Callable[[str], bool]
    read_winches: Callable[[Array, Array], Sequence[Operation]]


@dataclass(frozen=True)
class Truth:
    """True values of a sensor.

    Attributes:
        values: (n,), live.
        write: operations that write them at each control step.
        arrays: memory of these operations.
        mount: mount of the sensor, read by these operations; None without one.
    """

    values: Array
    write: Sequence[Operation] = ()
    arrays: Sequence[Array] = ()
    mount: Mount | None = None


def measuring(sensors: Iterable[Sensor]) -> list[Sensor]:
    """Return the sensors that measure in the loop; cameras, whose images are rendered outside it, do not."""
    return [sensor for sensor in sensors if sensor.quantities]


class Sensor(Kind):
    """Base class of sensors.

    A sensor declares its quantities and their true values. It may also declare how estimators model it, how viewers
    draw it, its standard message, and the true values of a recorded run for plots of its errors.

    Attributes:
        quantities: what it measures, in the order of its values.
        rates: number of last quantities that follow from differences of the measurements before them.
        used: what the controller uses of it: "pose", "twist", "cables" or "".
        mount: what a bump can move: "place", and "axes" if it has a direction or an attitude.
        locates: True if its measurements depend on the pose of the platform.
        sees_obstacles: True if the true values of a recorded run depend on the obstacles.
        measurement: model of its measurements for estimators, see `cdpr_controllers.estimators.ekf_updates`; "" if they
            do not use it.
        not_estimated: reason why estimators do not use it, without a model.
    """

    needs: ClassVar[Needs] = of_sensor()
    quantities: ClassVar[tuple[Quantity, ...]] = ()
    rates: ClassVar[int] = 0
    used: ClassVar[Used] = ""
    mount: ClassVar[tuple[str, ...]] = ()
    locates: ClassVar[bool] = False
    sees_obstacles: ClassVar[bool] = False
    measurement: ClassVar[str] = ""
    not_estimated: ClassVar[str] = "the filter has no model of its measurements"

    name: Annotated[str, AfterValidator(_short)] | None = Field(
        None, description="name, unique among the sensors, with which its columns begin; default: its type"
    )
    period: Time = Field(
        0.0,
        description="time from one measurement to the next: an integer multiple of control_step; 0: each control step",
        json_schema_extra=unit("s"),
    )
    delay: Time = Field(
        0.0,
        description="time from a measurement to its arrival: an integer multiple of control_step",
        json_schema_extra=unit("s"),
    )
    jitter: Time = Field(
        0.0,
        description="largest additional delay, uniformly distributed: an integer multiple of control_step. No "
        "measurement overtakes another",
        json_schema_extra=unit("s"),
    )
    dropout: Annotated[float, Field(ge=0, lt=1)] = Field(
        0.0, description="probability that a measurement is lost, but for the first"
    )

    believed: dict[str, Any] | None = Field(
        None,
        description="keys of this sensor with the values that estimators and controllers assume, such as another place "
        "or noise; others are the true ones",
    )

    @property
    def nominal(self) -> Self:
        """Sensor as estimators and controllers assume it: with the values of `believed`.

        Raises:
            CdprError: if `believed` is invalid; sensors of a scenario have been checked.
        """
        return type(self)(**self.nominal_data()) if self.believed else self

    def nominal_data(self) -> dict[str, Any]:
        """Return the given values with those of `believed`, as plain data: mappings by key, everything else whole."""
        data = self.to_dict()
        merged: dict[str, Any] = _merged(data, data.pop("believed", {}))
        return merged

    @property
    def title(self) -> str:
        """Name of its columns and random stream."""
        return self.name or self.type

    @property
    def columns(self) -> tuple[Column, ...]:
        """Measured values that are held, and their age."""
        name = self.title
        measured = [
            Column(f"{name}_{each.key}", each.width, each.unit, f"{each.text}, measured by {name}", each.frame)
            for each in self.quantities
        ]
        return (*measured, Column(f"{name}_age", 1, "s", f"Time since the measurement of {name}"))

    @abstractmethod
    def truth(self, sources: Sources) -> Truth:
        """Return the true values of all quantities."""

    @property
    def reach_limit(self) -> float:
        """True value without an object to measure, which has no errors; infinite if there is always one."""
        return math.inf

    def measurement_numbers(self) -> list[float]:
        """Return the numbers that its measurement model needs."""
        return []

    def drawing(self, extent: float) -> SensorDrawing | None:
        """Return its drawing; None if it has no place.

        Args:
            extent: size of the robot, m.
        """
        return None

    def message(self, cables: Sequence[str]) -> Message | None:
        """Return its standard message; None if there is no type for it.

        Args:
            cables: names of the cables.
        """
        return None

    def recorded_truth(self, key: str, records: Records) -> Array | None:
        """Return the true values of a quantity at the rows of a run (K, w); None if the log does not determine them.

        Args:
            key: key of the quantity.
            records: rows of the log.
        """
        return None

    @property
    def with_errors(self) -> tuple[Quantity, ...]:
        """Quantities that are not rates of others."""
        return self.quantities[: len(self.quantities) - self.rates]

    def errors(self, cables: int) -> list[tuple[float, ...]]:
        """Return gain, bias, noise, drift and resolution of each component (k, 5); an attitude has three."""
        rows: list[tuple[float, ...]] = []
        for each in self.with_errors:
            rows += self.errors_of(each).rows(each.components(cables))
        return rows

    def errors_of(self, quantity: Quantity) -> AttitudeErrors:
        """Return the errors of a quantity; a flag has none."""
        found: AttitudeErrors = getattr(self, quantity.key, AttitudeErrors())
        return found
