"""Encoders of the winches."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from cdpr.base.column import CABLES
from cdpr.base.needs import Needs, of_sensor
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.sensing.errors import Errors
from cdpr.sensing.message import Message, quantity
from cdpr.sensing.records import Records
from cdpr.sensing.sensor import Quantity, Sensor, Sources, Truth, Used
from cdpr.tension.operations import Operation


class Encoders(Sensor):
    """Sensor of the unwound length of each cable, as the drives count it, and of its rate.

    The length is that which the drum has paid out, without the stretch of the cable; the rate is the difference of two
    measured lengths over the period. Ideal cables have no drum: it measures the true length.

    Example:
        >>> import cdpr
        >>> cdpr.sensing.Encoders(length={"resolution": 1e-4}).length.resolution
        0.0001
    """

    needs: ClassVar[Needs] = of_sensor()
    quantities: ClassVar[tuple[Quantity, ...]] = (
        Quantity("length", CABLES, "m", "Unwound length of each cable"),
        Quantity("rate", CABLES, "m/s", "Rate of the unwound length of each cable"),
    )
    rates: ClassVar[int] = 1
    used: ClassVar[Used] = "cables"
    locates: ClassVar[bool] = True
    measurement: ClassVar[str] = "encoders"

    type: Literal["encoders"] = "encoders"
    length: Errors = Field(Errors(), description="errors of the length, m")

    def truth(self, sources: Sources) -> Truth:
        """Return lengths and rates (2 m,)."""
        m = sources.robot.m
        unwound, unwinding, values = np.zeros(m), np.zeros(m), np.zeros((2, m))
        reading = sources.read_winches(unwound, unwinding)
        if not reading:
            return Truth(sources.view("length", "rate"))
        given = {"length": sources.view("length"), "rate": sources.view("rate"), "truth": values}
        write = bind("paid_out", unwound=unwound, unwinding=unwinding, **given)
        operations = (*reading, Operation("sensors", write, timed=True))
        return Truth(values.reshape(-1), operations, (unwound, unwinding, values))

    def message(self, cables: Sequence[str]) -> Message:
        """Return the unwound lengths and their rates as the state of joints."""
        zeros = [0.0] * len(cables)
        fields = {"position": quantity("length"), "velocity": quantity("rate")}
        constant = {"name": list(cables), "position": zeros, "velocity": zeros}
        return Message("sensor_msgs/JointState", fields, constant)

    def recorded_truth(self, key: str, records: Records) -> Array | None:
        """Return unwound lengths or their rates."""
        return records.column(key if records.ideal else f"unstretched_{key}")
