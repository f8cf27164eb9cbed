"""Sensors of a loop: what they measure is logged, and is what the controller sees."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from cdpr.base.columns import Column
from cdpr.base.needs import of_sensor
from cdpr.cables import chain_of
from cdpr.model.robot import Array
from cdpr.model.shapes import Obstacle
from cdpr.native.bind import bind
from cdpr.native.random_numbers import Stream
from cdpr.scenario import Scenario
from cdpr.sensing.measurement import kernel_arguments
from cdpr.sensing.sensor import Sensor, Sources, Used
from cdpr.simulation.estimation import estimator_of
from cdpr.simulation.loop_part import LoopPart, Surroundings
from cdpr.tension.operations import Operation

# Parts of the seen state that a sensor provides.
SEEN: Mapping[Used, slice] = {"pose": slice(0, 7), "twist": slice(7, 13)}


def sensors_of(scenario: Scenario) -> LoopPart | None:
    """Return the part of the loop with the sensors of a scenario; None if it has none."""
    sensors = scenario.sections.sensors
    own = scenario.robot.cables if scenario.actuators is None else ()  # actuators replace the winches
    stretch = any(chain_of(scenario.robot, cable).stretches for cable in own)
    about = {"stretch": stretch, "estimated": estimator_of(scenario) is not None}
    return Sensors(sensors, scenario.simulation.seed, scenario.obstacles, **about) if sensors else None


class Sensors(LoopPart):
    """Sensors of a loop.

    The first sensor of a pose, of a twist and of the cables replaces the true values for controller and tension stage;
    that of cables which stretch does not, because controllers use the lengths of the cables, not the unwound ones.

    Args:
        sensors: sensors of the scenario, with unique names.
        seed: seed of the simulation.
        obstacles: obstacles of the world.
        stretch: True if a cable stretches, so that its unwound length differs from its length.
        estimated: True if an estimator provides the state that the controller sees.
    """

    name = "sensors"
    needs = of_sensor()

    def __init__(
        self,
        sensors: Sequence[Sensor],
        seed: int,
        obstacles: tuple[Obstacle, ...] = (),
        *,
        stretch: bool = False,
        estimated: bool = False,
    ) -> None:
        self._sensors, self._obstacles, self._stretch = sensors, obstacles, stretch
        self.columns: tuple[Column, ...] = tuple(column for sensor in sensors for column in sensor.columns)
        self.streams = tuple(Stream(seed, f"sensors.{sensor.title}") for sensor in sensors)
        self._used: dict[Used, Sensor] = {}
        for sensor in sensors:
            unused = stretch if sensor.used == "cables" else estimated
            if sensor.used and not unused:
                self._used.setdefault(sensor.used, sensor)
        seen = frozenset({"seen"}) if self._used.keys() & SEEN.keys() else frozenset()
        self.writes = seen | (frozenset({"seen_cables"}) if "cables" in self._used else frozenset())

    @property
    def nonlinear(self) -> str:
        """Return why the loop cannot be linearised."""
        return "measurements of sensors are not linear"

    def connect(self, surroundings: Surroundings) -> None:
        """Bind the operations of all sensors."""
        backend, m = surroundings.backend, surroundings.robot.m
        torque = np.zeros(m)

        def read_winches(unwound: Array, unwinding: Array) -> list[Operation]:
            if not self._stretch:
                return []
            return [Operation("backend", do) for do in backend.winch_readings(unwound, unwinding, torque)]

        about = surroundings.step, self._obstacles, surroundings.view, surroundings.has, read_winches
        sources = Sources(surroundings.robot, surroundings.state, backend.gravity, *about)
        self._operations: list[Operation] = []
        self.arrays = (torque,)
        for sensor, stream in zip(self._sensors, self.streams, strict=True):
            truth = sensor.truth(sources)
            names = [column.name for column in sensor.columns]
            measured, age = surroundings.view(names[0], names[-2]), surroundings.view(names[-1])
            settings, memory = kernel_arguments(sensor, m, surroundings.step)
            given = {"truth": truth.values, "stream": stream.state, "measured": measured, "age": age}
            measure = bind("measure", **given, **settings, **memory)
            self._operations += [*truth.write, Operation(self.name, measure, timed=True)]
            self.arrays += (*truth.arrays, *memory.values())
            if self._used.get(sensor.used) is sensor:
                cables = surroundings.seen_cables.reshape(-1)
                target = cables if sensor.used == "cables" else surroundings.seen[SEEN[sensor.used]]
                self._operations.append(Operation(self.name, bind("copy", source=measured, target=target)))

    def observed(self, period: float) -> Sequence[Operation]:
        """Return the operations that measure, and write what the controller sees."""
        return self._operations
