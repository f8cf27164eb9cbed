"""Load cells in the cables.

Their hysteresis is a Prandtl-Ishlinskii model: the measured tension lags behind the true one by a share of the sum of
stop elements, each of which follows the tension within plus and minus its width. Loops are closed, and a larger cycle
erases the memory of smaller ones. Krasnosel'skii and Pokrovskii (1989), Systems with Hysteresis, section 34; Kuhnen
(2003), European Journal of Control 9(4), pp. 407-418.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from cdpr.base.column import CABLES
from cdpr.base.fields import Positive, unit
from cdpr.base.needs import Needs, of_sensor
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.sensing.errors import Errors
from cdpr.sensing.message import Message, quantity
from cdpr.sensing.records import Records
from cdpr.sensing.sensor import Quantity, Sensor, Sources, Truth
from cdpr.tension.operations import Operation

ELEMENTS = 4  # stop elements: kinks of a loop
WIDEST = 0.25  # of the range: all elements are at their limits from the middle of a cycle over the range on


class LoadCellErrors(Errors):
    """Errors of load cells: those of other quantities, after their hysteresis.

    Example:
        >>> from cdpr.sensing.tension import LoadCellErrors
        >>> LoadCellErrors(hysteresis=0.001, range=2000.0, noise=0.5).hysteresis
        0.001
    """

    hysteresis: Annotated[float, Field(ge=0, le=0.5)] = Field(
        0.0,
        description="largest difference between the values measured while a tension falls and while it rises, in a "
        "cycle from 0 to `range` and back, as a fraction of `range`",
    )
    range: Positive | None = Field(None, description="rated tension, for `hysteresis`", json_schema_extra=unit("N"))

    @model_validator(mode="after")
    def _rated(self) -> Self:
        if self.hysteresis > 0.0 and self.range is None:
            raise ValueError("hysteresis without range: add range, the rated tension (N)")
        return self

    def stop_elements(self) -> tuple[Array, float]:
        """Return the widths of the stop elements (e,), N, and the share of their sum by which the cell lags."""
        if not self.hysteresis or self.range is None:
            return np.zeros(0), 0.0
        widths = WIDEST * self.range * np.arange(1, ELEMENTS + 1) / ELEMENTS
        return widths, 0.5 * self.hysteresis * self.range / float(widths.sum())


class Tension(Sensor):
    """Sensor of the tension in each cable, at the platform or, with `at: winch`, behind the pulley.

    At a sample it measures the tension of the control period before; at time 0 none has acted, and it measures 0.

    Example:
        >>> import cdpr
        >>> cdpr.sensing.Tension(tension={"gain": 1.01, "bias": 3.0, "noise": 0.5}).tension.gain
        1.01
    """

    needs: ClassVar[Needs] = of_sensor()
    quantities: ClassVar[tuple[Quantity, ...]] = (Quantity("tension", CABLES, "N", "Tension in each cable"),)
    measurement: ClassVar[str] = "tension"

    type: Literal["tension"] = "tension"
    at: Literal["platform", "winch"] = Field(
        "platform", description="side of a pulley with friction on which the load cells are"
    )
    tension: LoadCellErrors = Field(LoadCellErrors(), description="errors of the tension, N")

    def truth(self, sources: Sources) -> Truth:
        """Return the tensions (m,) of the control period that ends."""
        column = "cable_tension" if sources.has("winched") else "tension"
        if self.at == "winch" and sources.has("friction"):
            column = "winch_tension"
        widths, share = self.tension.stop_elements()
        m = sources.robot.m
        values, stops, before = np.zeros(m), np.zeros((m, len(widths))), np.zeros(m)
        memory = {"truth": values, "stops": stops, "before": before}
        write = bind("last_tensions", tension=sources.view(column), widths=widths, share=share, **memory)
        return Truth(values, (Operation("sensors", write, timed=True),), (values, before, *([stops] if share else [])))

    def message(self, cables: Sequence[str]) -> Message:
        """Return the tensions as the efforts of joints."""
        constant = {"name": list(cables), "effort": [0.0] * len(cables)}
        return Message("sensor_msgs/JointState", {"effort": quantity("tension")}, constant)

    def recorded_truth(self, key: str, records: Records) -> Array | None:
        """Return the tensions of the control period before each row, without hysteresis."""
        if records.every > 1:
            return None  # that period is not in the log
        tensions = records.column("winch_tension") if self.at == "winch" else None
        if tensions is None:
            tensions = records.column("tension" if records.ideal else "cable_tension")
        return None if tensions is None else np.concatenate([np.zeros_like(tensions[:1]), tensions[:-1]])
