"""Load cells in the cables."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from cdpr.base.columns import CABLES
from cdpr.base.needs import Needs, of_sensor
from cdpr.native.bind import bind
from cdpr.sensing.errors import Errors
from cdpr.sensing.sensor import Quantity, Sensor, Sources, Truth
from cdpr.tension.operations import Operation


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

    type: Literal["tension"] = "tension"
    at: Literal["platform", "winch"] = Field(
        "platform", description="side of a pulley with friction on which the load cells are"
    )
    tension: Errors = Field(Errors(), description="errors of the tension, N")

    def truth(self, sources: Sources) -> Truth:
        """Return the tensions (m,) of the control period that ends."""
        column = "cable_tension" if sources.has("winched") else "tension"
        if self.at == "winch" and sources.has("friction"):
            column = "winch_tension"
        values = np.zeros(sources.robot.m)
        write = bind("last_tensions", tension=sources.view(column), truth=values)
        return Truth(values, (Operation("sensors", write, timed=True),), (values,))
