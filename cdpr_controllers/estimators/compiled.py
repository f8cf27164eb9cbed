"""Base class of estimators whose operations are all compiled."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import Estimator, EstimatorInputs, SensorModel, SnapshotOfArrays


class CompiledEstimator(SnapshotOfArrays, Estimator):
    """Estimator that begins at the assumed initial state, and whose `estimate` calls its compiled operations."""

    def __init__(
        self, robot: Robot, gravity: Array, control_step: float, sensors: Sequence[SensorModel], options: Any
    ) -> None:
        super().__init__(robot, gravity, control_step, sensors, options)
        self._start = np.zeros(13)
        self._own: tuple[Array, Sequence[Callable[..., object]]] | None = None

    def connect(self, inputs: EstimatorInputs) -> None:
        """Begin at the assumed initial state."""
        self._start = inputs.start

    def estimate(self, time: float, out: Array) -> None:
        """Write the state (13,)."""
        if self._own is None or self._own[0] is not out:
            self._own = out, self.compiled(out)
        for operation in self._own[1]:
            operation(time)

    @abstractmethod
    def compiled(self, out: Array) -> Sequence[Callable[..., object]]:
        """Return the operations, which receive the time, s."""
