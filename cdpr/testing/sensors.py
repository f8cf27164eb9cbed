"""Sensors that the conformance kit provides to controllers, and their measurements."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np

from cdpr.model import Robot
from cdpr.model.robot import Array, read_only
from cdpr.sensing import Markers, Sensor, Tension
from cdpr.sensing.sensor import Sources
from cdpr.tension.operations import perform
from cdpr.testing.check import NotApplicable


def _camera() -> Markers:
    """Return a camera above the cube that looks down on markers in all directions of the platform."""
    corners = tuple((x, y, z) for x in (-0.3, 0.3) for y in (-0.3, 0.3) for z in (-0.2, 0.2))
    return Markers(position=(0.0, 0.0, 8.0), attitude=(0.0, 1.0, 0.0, 0.0), size=(2000, 2000), markers=corners)


# Sample of each type of sensor that a controller can declare, see `Controller.use_sensors`. Estimators can also declare
# the other types: their samples have the default values.
SAMPLES: Mapping[str, Callable[[], Sensor]] = MappingProxyType({"markers": _camera, "tension": Tension})
MOUNTED = {"markers"}  # those with a place in the world


class SampleSensors:
    """Exact sensors without delay, on a robot in a given state.

    Args:
        kinds: types of the sensors.
        robot: robot.
        gravity: (3,), m/s^2.
        step: control period, s.

    Attributes:
        sensors: sensors by name.
        state: (13,), state of the last measurement.
        tension: (m,), N, tensions of the cables, live.
        measurements: their columns by name, live and read-only.

    Raises:
        NotApplicable: if the kit has no sensor of a type.
    """

    def __init__(self, kinds: Sequence[str], robot: Robot, gravity: Array, step: float) -> None:
        if unknown := [kind for kind in kinds if kind not in SAMPLES]:
            raise NotApplicable(f"the kit has no sensors of the type {', '.join(unknown)}")
        self.state, self.tension = np.zeros(13), np.zeros(robot.m)
        self.sensors = {sensor.title: sensor for sensor in (SAMPLES[kind]() for kind in kinds)}
        self._operations: list[Any] = []
        self._values: dict[str, Array] = {}
        self._finite: list[tuple[str, int]] = []
        sources = Sources(robot, self.state, gravity, step, (), self._view, _no_columns, _no_winches)
        for title, sensor in self.sensors.items():
            truth, at = sensor.truth(sources), 0
            self._operations += truth.write
            for quantity in sensor.quantities:
                name, width = f"{title}_{quantity.key}", quantity.values(robot.m)
                self._values[name] = truth.values[at : at + width]
                at += width
                self._finite += [(name, i) for i in range(width) if quantity.unit]
            self._values[f"{title}_age"] = np.zeros(1)
        self.measurements = MappingProxyType({name: read_only(values) for name, values in self._values.items()})

    @property
    def quantities(self) -> list[tuple[str, int]]:
        """Name and index of each measured value that is no flag."""
        return self._finite

    def measure(self, state: Array, time: float, missing: tuple[str, int] | None = None) -> None:
        """Measure in a state (13,); the value `missing` becomes NaN."""
        self.state[:] = state
        perform(self._operations, time)
        if missing is not None:
            name, i = missing
            self._values[name][i] = np.nan

    def _view(self, *columns: str) -> Array:
        if columns != ("tension",):
            raise NotApplicable("the kit has no simulation with the columns of these sensors")
        return self.tension


def _no_columns(_: str) -> bool:
    return False


def _no_winches(*_: Array) -> tuple[()]:
    return ()
