"""Computed-torque control with an inner loop on measured cable tensions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.plugins.controller import Tunable
from cdpr.plugins.inputs import ControllerInputs
from cdpr.sensing import Sensor
from cdpr.sensing.tension import Tension
from cdpr_controllers.computed_torque import ComputedTorque

INNER = ("gain", "integral_gain", "integral_limit")  # options of the inner loop, in the order of its rows of gains


class TensionFeedback(ComputedTorque):
    """Cascade of computed torque, the tension distribution and one PI law per cable on its measured tension.

    The outer loop is `computed_torque`. The tension solver distributes its wrench to tensions t_d, with the limits of
    the cables. The inner loop then sends to each winch

        t = t_d + gain (t_d - t_m) + z,   z' = integral_gain (t_d - t_m),

    within the limits, where t_m is the latest measurement of a sensor of tensions. So the tensions at the sensor follow
    the distributed ones in spite of what lies between winch and sensor, such as friction on pulleys. Load cells at the
    platform show the whole loss; those at the winch (`at: winch`) show no friction of the pulleys.

    z stays within integral_limit, and does not grow while its tension is at a limit. A broken or jammed cable that is
    known to be so keeps its imposed tension. The outer wrench and its report are those of the distribution; the column
    `distributed_tension` contains t_d. Commands of tensions from outside bypass the inner loop, wrenches do not.

    The winch, cable and sensor are in the loop: with the delay T of the measurement, integral_gain T must be well below
    1, and gain below 1. Elastic cables on drums with inertia need smaller gains, below the damping of the drum's
    vibration.

    Sources: Kraus, Schmidt, Rajendra and Pott, "System identification and cable force control for a cable-driven
    parallel robot with industrial servo drives" (ICRA 2014), such a cascade on a robot with load cells; Pott,
    Cable-Driven Parallel Robots (2018), chapter 7 on control.
    """

    def __init__(self, robot: Robot, gravity: Array, control_step: float, options: Any) -> None:
        self._inner, self._integral = np.zeros((3, robot.m)), np.zeros(robot.m)
        self._logged = np.zeros(robot.m)
        super().__init__(robot, gravity, control_step, options)
        self.arrays = (self._integral,)

    def change(self, options: Any) -> None:
        """Set new gains and limits. The integrals keep their values, within the new limits from the next step on."""
        given = {name: getattr(options, name) for name in INNER}
        for name, value in given.items():
            if np.ndim(value) and len(value) != self.robot.m:
                raise CdprError(f"tension_feedback: {name} has {len(value)} values, the robot {self.robot.m} cables")
        super().change(options)
        self._inner[:] = [np.broadcast_to(value, self.robot.m) for value in given.values()]
        self._inner[1] *= self.control_step

    def use_sensors(self, sensors: Mapping[str, Sensor]) -> None:
        """Use the sensor of tensions that the options name, by default the first one.

        Raises:
            CdprError: if there is none.
        """
        found = [title for title, sensor in sensors.items() if isinstance(sensor, Tension)]
        name = self.options.sensor
        if not found:
            named = "" if name in (None, "tension") else f", name: {name}"
            raise CdprError(f"tension_feedback: needs measured tensions: add {{type: tension{named}}} to `sensors`")
        if name is not None and name not in found:
            raise CdprError(
                f"tension_feedback: no sensor of tensions has the name '{name}': expected {' or '.join(found)}"
            )
        self._sensor = name or found[0]

    def observe(self, inputs: ControllerInputs) -> None:
        """Read the sensor and the limits."""
        self._inputs = inputs

    def log(self, columns: Mapping[str, Array]) -> None:
        """Write the distributed tensions into their column."""
        self._logged = columns["distributed_tension"]

    def inner_loop(self, distributed: Array, tension: Array) -> Callable[[float], object]:
        """Return the law of the tensions, bound to these arrays."""
        inputs, name = self._inputs, self._sensor
        return bind(
            "tension_feedback",
            gains=self._inner,
            distributed=distributed,
            measured=inputs.measurements[f"{name}_tension"],
            age=inputs.measurements[f"{name}_age"],
            limits=inputs.limits,
            integral=self._integral,
            logged=self._logged,
            tension=tension,
            first=0.5 * self.control_step,  # at time 0 no tension has acted
        )

    def tunable(self) -> Mapping[str, Tunable]:
        """Return the gains of both loops."""
        given = {name: np.broadcast_to(getattr(self.options, name), self.robot.m) for name in INNER}
        inner = {
            name: Tunable(row, value.astype(float), per_step=name == "integral_gain")
            for row, (name, value) in zip(self._inner, given.items(), strict=True)
        }
        return {**super().tunable(), **inner}

    def reset(self) -> None:
        """Reset the integrals."""
        self._integral[:] = 0.0
