"""Sensors of a loop: what they measure is logged, and is what the controller sees."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np

from cdpr.base.column import Column
from cdpr.base.needs import of_sensor
from cdpr.cables import chain_of
from cdpr.model.robot import Array
from cdpr.model.shapes import Obstacle
from cdpr.native.bind import bind
from cdpr.native.random_numbers import Stream
from cdpr.scenario import Scenario
from cdpr.sensing.disturbance import Disturbance, Mount
from cdpr.sensing.measurement import kernel_arguments
from cdpr.sensing.sensor import Sensor, Sources, Used, measuring
from cdpr.simulation.estimation import estimator_of
from cdpr.simulation.loop_part import LoopPart, Surroundings
from cdpr.tension.operations import Operation

# Parts of the seen state that a sensor provides.
SEEN: Mapping[Used, slice] = {"pose": slice(0, 7), "twist": slice(7, 13)}

RESOLUTION = 4  # place in a row of errors
LOST = 3  # place in `count` of measurement.hpp


def sensors_of(scenario: Scenario) -> LoopPart | None:
    """Return the part of the loop with the sensors of a scenario; None if it has none."""
    sensors = measuring(scenario.sections.sensors)
    about = {"stretch": _stretch(scenario), "estimated": estimator_of(scenario) is not None}
    return Sensors(sensors, scenario.simulation.seed, scenario.obstacles, **about) if sensors else None


def used_sensors(scenario: Scenario) -> dict[Used, Sensor]:
    """Return the sensors that the controller uses, by what they provide."""
    return _first_ones(scenario.sections.sensors, _stretch(scenario), estimator_of(scenario) is not None)


def seen_sensors(scenario: Scenario) -> dict[Used, Sensor]:
    """Return the sensors of the state that the controller sees, in the order of `SEEN`."""
    used = used_sensors(scenario)
    return {key: used[key] for key in SEEN if key in used}


def stream_name(sensor: Sensor) -> str:
    """Return the name of the random stream of a sensor."""
    return f"sensors.{sensor.title}"


def _stretch(scenario: Scenario) -> bool:
    own = scenario.robot.cables if scenario.actuators is None else ()  # actuators replace the winches
    return any(chain_of(scenario.robot, cable).stretches for cable in own)


def _first_ones(sensors: Sequence[Sensor], stretch: bool, estimated: bool) -> dict[Used, Sensor]:
    used: dict[Used, Sensor] = {}
    for sensor in sensors:
        if sensor.used and not (stretch if sensor.used == "cables" else estimated):
            used.setdefault(sensor.used, sensor)
    return used


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
    measures = True
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
        self.streams = tuple(Stream(seed, stream_name(sensor)) for sensor in sensors)
        self._used = _first_ones(sensors, stretch, estimated)
        seen = frozenset({"seen"}) if self._used.keys() & SEEN.keys() else frozenset()
        self.writes = seen | (frozenset({"seen_cables"}) if "cables" in self._used else frozenset())

    @property
    def nonlinear(self) -> str:
        """Return why the loop cannot be linearised: encoders that the controller uses, or rounded values.

        `cdpr.simulation.late_measurements` contains periods and delays.
        """
        if "cables" in self._used:
            return "the rates that encoders measure are differences, which are not linearised"
        rounded = (each.title for each in self._used.values() if any(row[RESOLUTION] for row in each.errors(1)))
        return next((f"the resolution of the sensor '{name}' is not linear" for name in rounded), "")

    @property
    def linear_states(self) -> tuple[Array, ...]:
        """Return no array: `cdpr.simulation.late_measurements` contains periods and delays."""
        return ()

    def errors_of(self, used: Used) -> Array:
        """Return gain, bias, noise, drift and resolution (k, 5) of the sensor that the controller uses, live."""
        return self._errors[used]

    def connect(self, surroundings: Surroundings) -> None:
        """Bind the operations of all sensors."""
        backend, m = surroundings.backend, surroundings.robot.m
        torque, self._cables = np.zeros(m), m

        def read_winches(unwound: Array, unwinding: Array) -> list[Operation]:
            if not self._stretch:
                return []
            return [Operation("backend", do) for do in backend.winch_readings(unwound, unwinding, torque)]

        about = surroundings.step, self._obstacles, surroundings.view, surroundings.has, read_winches
        sources = Sources(surroundings.robot, surroundings.state, backend.gravity, *about)
        self._operations: list[Operation] = []
        seen: list[Operation] = []
        self._memory: dict[str, Mapping[str, Array]] = {}
        self._mounts: dict[str, Mount] = {}
        self._errors: dict[Used, Array] = {}
        self.arrays = (torque,)
        for sensor, stream in zip(self._sensors, self.streams, strict=True):
            truth = sensor.truth(sources)
            names = [column.name for column in sensor.columns]
            measured, age = surroundings.view(names[0], names[-2]), surroundings.view(names[-1])
            settings, memory = kernel_arguments(sensor, m, surroundings.step)
            given = {"truth": truth.values, "stream": stream.state, "measured": measured, "age": age}
            given["time"] = surroundings.view("time")
            measure = bind("measure", **given, **settings, **memory)
            self._operations += [*truth.write, Operation(self.name, measure)]
            self.arrays += (*truth.arrays, *memory.values())
            self._memory[sensor.title] = memory
            self._errors[sensor.used] = self._errors.get(sensor.used, settings["errors"])
            if truth.mount is not None:
                self._mounts[sensor.title] = truth.mount
            if self._used.get(sensor.used) is sensor:
                cables = surroundings.seen_cables.reshape(-1)
                target = cables if sensor.used == "cables" else surroundings.seen[SEEN[sensor.used]]
                seen.append(Operation(self.name, bind("copy", source=measured, target=target)))
        self._operations += seen  # after all measurements, which cases of a rollout make alone

        moved = {id(array): array for mount in self._mounts.values() for array in mount.arrays}
        self._at_start = [(array, array.copy()) for array in moved.values()]
        self.arrays += tuple(moved.values())

    def reset(self) -> None:
        """Return to the state before the first sample, also of the mounts."""
        super().reset()
        for array, start in self._at_start:
            array[:] = start

    def disturb(self, name: str, change: Disturbance) -> None:
        """Disturb the later measurements of the sensor with this name."""
        sensor = next(each for each in self._sensors if each.title == name)
        memory, first = self._memory[name], 0
        memory["count"][LOST] += change.lost
        if name in self._mounts:
            self._mounts[name].move(change.position, change.rotation)
        for quantity in sensor.with_errors if change.bias else ():
            end = first + quantity.components(self._cables)
            if quantity.key == (change.quantity or sensor.quantities[0].key):
                memory["walk"][first:end] += change.bias
            first = end

    def observed(self, period: float) -> Sequence[Operation]:
        """Return the operations that measure, and write what the controller sees."""
        return self._operations


def disturb_of(parts: Iterable[LoopPart]) -> Callable[[str, Disturbance], None] | None:
    """Return the function that disturbs a sensor; None if no part has sensors."""
    return next((part.disturb for part in parts if isinstance(part, Sensors)), None)
