"""Further inputs of controllers that look ahead or react to limits and faults."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cdpr.model.robot import Array


@dataclass(frozen=True, eq=False)
class ControllerInputs:
    """Live, read-only inputs of a controller, beyond the arguments of `control`.

    All are what a real controller knows: limits and cables change when the tension distribution is informed, which an
    event's `detected_after` delays.

    Attributes:
        preview: function of times (K,), s, that returns the desired motion there, (K, 19), in the layout of
            `cdpr.model`. It contains the effects of past events, not those of later ones, such as an emergency stop.
        limits: (2, m), lowest and highest tensions, N.
        held: (m,), True for cables known to be broken or jammed; their two limits equal the tension.
        command: (m,), tensions as sent in the previous control step, N; 0 before the first one. Without power, those
            that were sent last. For winches that take lengths or rates, the tensions of the nominal cables at rest.
        measurements: columns of the sensors by name, such as `mocap_position` and `mocap_age` of the sensor `mocap`:
            measured values, which are held between arrivals, and their age, s (see `Controller.use_sensors`).

    Example:
        >>> import numpy as np
        >>> import cdpr
        >>> class Ahead(cdpr.plugins.Controller):
        ...     def observe(self, inputs):
        ...         self.inputs = inputs
        ...     def control(self, time, state, desired, out):
        ...         soon = self.inputs.preview(np.array([time + 0.1]))[0]
        ...         out[:] = 0.0
        ...         out[:3] = 500.0 * (soon[:3] - state[:3]) - self.robot.platform.mass * self.gravity
        >>> cdpr.simulate("caroca", controller=Ahead, overrides={"simulation.duration": 0.1}).status
        'finished'
    """

    preview: Callable[[Array], Array]
    limits: Array
    held: NDArray[np.bool_]
    command: Array
    measurements: Mapping[str, Array]
