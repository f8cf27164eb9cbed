"""Image-based visual servoing on the markers in the image of a camera."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.plugins import ControllerInputs
from cdpr.sensing import Sensor
from cdpr.sensing.markers import Markers
from cdpr_controllers.law import GainLaw

# Share of the interaction matrix at the desired pose, by the option `interaction`.
SHARES = {"current": 0.0, "mean": 0.5, "desired": 1.0}


class VisualServo(GainLaw):
    """Image-based visual servoing with computed torque.

    The controller uses the first sensor of the type `markers`, and no other measurement. The desired pose and the
    model of the camera give the desired image points s_d. The displacement of the platform from the desired pose
    follows from the measured ones s: e = L^+ (s_d - s), with the interaction matrix L of all seen markers in the
    degrees of freedom of the platform (Chaumette and Hutchinson, Visual Servo Control, Part I, IEEE Robotics and
    Automation Magazine 13 (2006), eq. 11 and 12). L is computed at the desired pose, at the estimated pose, or as the
    mean of both, which is exact to the second order (Malis 2004; `interaction`). The depths in it come from the model.

    wrench = M a + C(omega) - G with a = a_d + kd e' + kp e. A filter of fading memory estimates e, e' and an unknown
    acceleration d (Brookner, Tracking and Kalman Filtering Made Easy (1998), section 1.3): it predicts
    e'' = d - kd e' - kp e, and each image corrects the prediction. `smoothing` is its time constant, a few periods of
    the camera. An image that arrives late corrects the estimate of the time when it was taken. d only serves the
    prediction: the error under a constant load is that of a PD law.

    If too few markers are seen, the estimate is only predicted: the feedback fades within the settling time of the
    error, and the feed-forward of the desired motion remains. `servo_age` is the time since the last image that was
    used. The platform can drift meanwhile; the next such image corrects it.

    Region of convergence: see docs/sensors.md#visual-servoing. For the camera in scenarios/visual_servo.yaml, the
    default options converge from all poses at rest within 0.4 m and 0.6 rad of the desired one, if the first image
    contains all markers.
    """

    operation = "visual_servo"

    def __init__(self, robot: Robot, gravity: Array, control_step: float, options: Any) -> None:
        memory = {name: np.zeros(6) for name in ("error", "rate", "offset", "feedback", "clock")}
        self.arrays = tuple(memory.values())
        super().__init__(robot, gravity, control_step, options, **memory)
        rotations = np.array([name.startswith("r") for name in robot.dof])
        self._model: dict[str, Any] = {
            "rows": np.array(robot.rows, dtype=np.int64),
            "scale": np.where(rotations, robot.characteristic_length, 1.0),
            "step": control_step,
            "smoothing": options.smoothing,
            "share": SHARES[options.interaction],
        }

    def use_sensors(self, sensors: Mapping[str, Sensor]) -> None:
        """Use the model of the first camera.

        Raises:
            CdprError: if there is none, or if its markers do not determine the pose.
        """
        found = next((sensor for sensor in sensors.values() if isinstance(sensor, Markers)), None)
        if found is None:
            raise CdprError("visual_servo: needs the image points of markers: add a sensor of the type markers")
        self._name, count, n = found.title, len(found.markers), self.robot.n
        if 2 * count < n:
            raise CdprError(
                f"visual_servo: the sensor '{self._name}' has {count} markers, which determine at most {2 * count} of "
                f"{n} degrees of freedom: add markers, at least {-(-n // 2)}, better more"
            )
        places = np.array(found.markers)
        if n == 6 and np.linalg.matrix_rank(places - places[0], tol=1e-6) < 2:  # m, below what images resolve
            raise CdprError(f"visual_servo: all markers of the sensor '{self._name}' are on one line: move one of them")
        self._model |= found.model()

    def observe(self, inputs: ControllerInputs) -> None:
        """Use the measurements of the camera."""
        measured = {key: inputs.measurements[f"{self._name}_{key}"] for key in ("pixel", "seen", "age")}
        self._model |= {"pixels": measured["pixel"].reshape(-1, 2), "seen": measured["seen"], "age": measured["age"]}
        vars(self).pop("_law", None)

    def log(self, columns: Mapping[str, Array]) -> None:
        """Write the error in the image, the number of seen markers, and the age of the last image."""
        self._columns = dict(columns)
        vars(self).pop("_law", None)

    def compiled(self, state: Array, desired: Array, out: Array) -> Callable[[], object]:
        """Return the law bound to these arrays."""
        return bind(self.operation, **self._given, **self._model, **self._columns, desired=desired, wrench=out)

    def reset(self) -> None:
        """Forget all images."""
        for array in self.arrays:
            array[:] = 0.0
