"""Estimator of a loop: its estimate is logged, and is the state that controller and tension stage use."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from pydantic import BaseModel

from cdpr.base.column import Column
from cdpr.base.columns import ESTIMATED, INNOVATION, UNCERTAINTY
from cdpr.base.errors import CdprError, PluginError
from cdpr.base.needs import of_estimator
from cdpr.cables import commands_of
from cdpr.model import Robot
from cdpr.model.robot import Array, read_only
from cdpr.native.bind import bind
from cdpr.plugins import Estimator, EstimatorInputs, SensorModel, SnapshotOfArrays
from cdpr.plugins.compiled import speaks_for
from cdpr.plugins.registry import Registered
from cdpr.scenario import Scenario
from cdpr.sensing.sensor import measuring
from cdpr.simulation.loop_part import LoopPart, Surroundings
from cdpr.tension.operations import Operation

# Properties that an estimator declares for what it provides besides the state, with their columns.
PROVIDED: Mapping[str, tuple[Column, ...]] = {"covariance": UNCERTAINTY, "innovation": INNOVATION}


def estimator_of(scenario: Scenario) -> Registered | None:
    """Return the plugin of a scenario's estimator; None if controllers use the measured or true state directly."""
    if scenario.estimator is None:
        return None
    entry = scenario.plugins.get("estimator", scenario.estimator.type)
    return None if entry.info.properties.get("direct") else entry


def estimation_of(scenario: Scenario) -> LoopPart | None:
    """Return the part of the loop with the estimator of a scenario; None if it has none."""
    entry = estimator_of(scenario)
    return None if entry is None else Estimation(entry, scenario)


def check_estimator(scenario: Scenario) -> None:
    """Make the estimator of a scenario, and close it.

    Raises:
        CdprError: if the estimator rejects the scenario, such as for missing sensors; with its place.
        PluginError: if it cannot be made, or does not provide what it declares.
    """
    entry = estimator_of(scenario)
    if entry is None:
        return
    m, given = scenario.robot.m, scenario.sections.sensors
    models = []
    for sensor in measuring(given):
        size = sum(each.values(m) for each in sensor.quantities)
        models.append(SensorModel(sensor.nominal, np.zeros(size), np.zeros(1), np.zeros(1)))
    try:
        _check_believed(entry, scenario)
        _make(entry, scenario.nominal or scenario.robot, scenario, models).close()
    except PluginError:
        raise
    except CdprError as error:
        only = ", ".join(f"'{each.title}' ({each.type})" for each in given) if given and not models else ""
        images = f"; the images of {only} are no measurements for estimators" if only else ""
        raise CdprError(f"{scenario.place('estimator')}: {error}{images}") from error


def _check_believed(entry: Registered, scenario: Scenario) -> None:
    """Raise CdprError for believed errors that the estimator declares as unused."""
    unused = entry.info.properties.get("unused_errors", ())
    for i, sensor in enumerate(scenario.sections.sensors):
        for quantity in sensor.quantities:
            given = (sensor.believed or {}).get(quantity.key)
            for key in given if isinstance(given, dict) else ():
                if key in unused:  # type: ignore[operator]
                    raise CdprError(
                        f"sensors[{i}].believed.{quantity.key}.{key}: the estimator '{entry.info.name}' does not use "
                        "it: remove this key; `noise` and `resolution` can contain the size of unknown errors"
                    )


def _make(entry: Registered, robot: Robot, scenario: Scenario, sensors: Sequence[SensorModel]) -> Estimator:
    gravity, step = np.array(scenario.world.gravity), scenario.simulation.control_step
    estimator: Estimator = entry.make(robot, gravity, step, sensors, scenario.estimator_options)
    title = f"estimator '{entry.info.name}'"
    declared = {name: bool(entry.properties(scenario.estimator_options).get(name)) for name in PROVIDED}  # type: ignore[arg-type]
    shapes = {"covariance": (12, 12), "nis": (1,), "nis_size": (1,)}
    for name, shape in shapes.items():
        value = getattr(estimator, name, None)
        if (value is not None) != declared["covariance" if name == "covariance" else "innovation"]:
            raise PluginError(f"{title}: its attribute {name} does not agree with its declared properties")
        if value is not None and (not isinstance(value, np.ndarray) or value.shape != shape or value.dtype != float):
            raise PluginError(f"{title}: expected {name} as an array of floats with the shape {shape}")
    return estimator


class Estimation(LoopPart):
    """Estimator of a loop.

    Args:
        entry: plugin of the estimator.
        scenario: scenario.

    Attributes:
        estimator: the estimator, after `connect`.
    """

    name = "estimation"
    section = "estimator"
    needs = of_estimator()
    writes = frozenset({"seen"})
    reads_commands = True
    estimator: Estimator

    def __init__(self, entry: Registered, scenario: Scenario) -> None:
        self._entry, self._scenario = entry, scenario
        self._options: BaseModel | None = scenario.estimator_options
        declared = entry.properties(self._options)  # type: ignore[arg-type]
        self.columns = ESTIMATED + tuple(
            column for name, columns in PROVIDED.items() if declared.get(name) for column in columns
        )

    @property
    def nonlinear(self) -> str:
        """Return why the loop cannot be linearised."""
        return "the states of the estimator are not known"

    @property
    def in_arrays(self) -> bool:
        """True if `saved_arrays` contain the whole memory."""
        return isinstance(self.estimator, SnapshotOfArrays)

    def connect(self, surroundings: Surroundings) -> None:
        """Make the estimator, and its operations."""
        scenario, view = self._scenario, surroundings.view
        models, arrivals = [], []
        time = view("time")
        self.arrays = ()
        for sensor in measuring(scenario.sections.sensors):
            names = [column.name for column in sensor.columns]
            measured, age = view(names[0], names[-2]), view(names[-1])
            before, fresh = np.zeros(1), np.zeros(1)
            models.append(SensorModel(sensor.nominal, read_only(measured), read_only(age), read_only(fresh)))
            about = {"age": age, "time": time, "step": surroundings.step}
            arrivals.append(Operation("estimator", bind("arrived", **about, before=before, fresh=fresh)))
            self.arrays += (before, fresh)
        nominal = scenario.nominal or scenario.robot
        self.estimator = estimator = _make(self._entry, nominal, scenario, models)
        owned = {column.name: view(column.name) for column in self._entry.info.columns}
        if owned:
            estimator.log(owned)
        start = np.zeros(13)
        command = view("winch_command") if surroundings.has("drums") else surroundings.sent
        known = read_only(time), read_only(start), read_only(command), tuple(commands_of(scenario.robot))
        limits, locked = read_only(surroundings.limits), read_only(surroundings.locked)
        estimator.connect(EstimatorInputs(*known, read_only(surroundings.sent), limits, locked))
        given = np.full(7, np.nan)
        if scenario.estimator is not None and (assumed := scenario.estimator.start) is not None:
            if assumed.position is not None:
                given[:3] = assumed.position
            if assumed.orientation is not None:
                given[3:] = assumed.orientation.quaternion()
        begin = bind("start_estimate", state=surroundings.state, given=given, time=time, start=start)
        self.arrays += (start,)
        out = view("estimated_position", "estimated_angular_velocity")
        self._operations = [
            *arrivals,
            Operation("estimator", begin),
            *self._estimating(out),
            Operation("estimator", bind("not_unit", estimate=out), self._refuse_attitude(out[3:7])),
            Operation("estimator", bind("copy", source=out, target=surroundings.seen)),
            *self._judging(surroundings, out),
        ]

    def _estimating(self, out: Array) -> list[Operation]:
        estimator = self.estimator
        known = isinstance(estimator, Estimator) and speaks_for(estimator.compiled, estimator.estimate)
        compiled = estimator.compiled(out) if known else None
        if compiled is None:
            return [Operation("estimator", partial(_estimate, estimator, out), timed=True)]
        return [Operation("estimator", each, self._refuse_code, timed=True) for each in compiled]

    def _refuse_code(self, code: int) -> None:
        raise PluginError(
            f"the estimator '{self._entry.info.name}' failed: its compiled operation returned {code}, expected 0"
        )

    def _refuse_attitude(self, quaternion: Array) -> Callable[[int], None]:
        def refuse(_: int) -> None:
            text = f"the estimator '{self._entry.info.name}' wrote the quaternion {quaternion.tolist()}"
            raise PluginError(f"{text}: expected the norm 1")

        return refuse

    def _judging(self, surroundings: Surroundings, out: Array) -> list[Operation]:
        """Return the operations that write the columns about the uncertainty of the estimate."""
        found, estimator, own = [], self.estimator, surroundings.columns
        if estimator.covariance is not None:
            given = {"state": surroundings.state, "estimate": out, "covariance": estimator.covariance}
            judge = bind("judge_estimate", **given, sigma=own["estimate_sigma"], nees=own["nees"])
            found.append(Operation("estimator", judge))
        if estimator.nis is not None:
            for name in ("nis", "nis_size"):
                copy = bind("copy", source=getattr(estimator, name), target=own[name])
                found.append(Operation("estimator", copy))
        return found

    def observed(self, period: float) -> Sequence[Operation]:
        """Return the operations that estimate, and write what the controller sees."""
        return self._operations

    @property
    def saved_arrays(self) -> tuple[Array, ...]:
        """Return the memory, with that of an estimator which has it in arrays."""
        estimator = self.estimator
        return (*self.arrays, *(estimator.arrays if isinstance(estimator, SnapshotOfArrays) else ()))

    def snapshot(self) -> object:
        """Return a copy of the memory."""
        return super().snapshot(), None if self.in_arrays else self.estimator.snapshot()

    def restore(self, snapshot: Any) -> None:
        """Restore a snapshot.

        Args:
            snapshot: result of `snapshot` of the same object.
        """
        arrays, own = snapshot
        super().restore(arrays)
        if not self.in_arrays:
            self.estimator.restore(own)

    def reset(self) -> None:
        """Forget all measurements and the estimate."""
        super().reset()
        self.estimator.reset()

    def describe(self) -> dict[str, Any]:
        """Return metadata for `run.json`."""
        return self.estimator.describe()

    def close(self) -> None:
        """Close the estimator; may be called again."""
        self.estimator.close()


def _estimate(estimator: Estimator, out: Array, time: float) -> None:
    estimator.estimate(time, out)
