"""Live events: changes of a simulation between two steps, recorded as events of its scenario."""

from __future__ import annotations

import os
from _thread import LockType
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, TypeVar

from numpy.typing import ArrayLike

from cdpr.base.errors import CdprError
from cdpr.base.problems import shown
from cdpr.log.files import is_name
from cdpr.model.arrays import checked
from cdpr.scenario.events import ScenarioEvent
from cdpr.scenario.events.faults import CableBreak, CableJam
from cdpr.scenario.events.limits import TensionLimits
from cdpr.scenario.events.loads import Wrench
from cdpr.scenario.events.options import SetOption
from cdpr.scenario.events.payload import Payload
from cdpr.scenario.events.sensor_bump import SensorBump
from cdpr.scenario.events.sensor_failure import SensorFailure
from cdpr.scenario.events.sensor_occlusion import SensorOcclusion
from cdpr.scenario.events.stop import EmergencyStop
from cdpr.scenario.events.target import Target
from cdpr.simulation.attached_checks import check_known_mass
from cdpr.simulation.columns import chosen_plugins
from cdpr.simulation.loop import Loop
from cdpr.simulation.runner import Runner

E = TypeVar("E", bound=ScenarioEvent)

Cable = str | int


class ExclusiveAccess:
    """Context manager that holds `lock`; it raises CdprError, naming the request `what`, if the lock is taken."""

    __slots__ = ("_lock", "_what")

    def __init__(self, lock: LockType, what: str) -> None:
        self._lock, self._what = lock, what

    def __enter__(self) -> None:
        if not self._lock.acquire(blocking=False):
            raise CdprError(
                f"{self._what}: the simulation is executing a step or another call; observers must not call it, and "
                "threads must wait for each other"
            )

    def __exit__(self, *_: object) -> None:
        self._lock.release()


class Interventions(ABC):
    """Live events of a simulation, at its present time.

    Each method raises CdprError, without any effect, if a scenario could not contain the event: an unknown or invalid
    value, an impossible event (a cable that is already broken), an event that makes a later one impossible, or an event
    that the plant does not support. An event at the present sample takes effect in the next step.
    """

    _runner: Runner
    _loop: Loop

    @abstractmethod
    def _exclusive(self, what: str) -> AbstractContextManager[None]:
        """Reject a call during another one."""

    @abstractmethod
    def _ready(self, *, also_done: bool = False) -> None:
        """Reject a call after the end."""

    @abstractmethod
    def _kept(self) -> AbstractContextManager[None]:
        """End the run with any exception of the block."""

    def push(
        self,
        force: ArrayLike = (0.0, 0.0, 0.0),
        moment: ArrayLike = (0.0, 0.0, 0.0),
        *,
        duration: float | None = None,
    ) -> Wrench:
        """Add a wrench on the platform from now on.

        Args:
            force: (3,) N, at the platform's origin, world axes.
            moment: (3,) N m, likewise.
            duration: duration, s, at least a control step; by default until `release`.

        Returns:
            Handle for `release`.
        """
        keys = {"force": _vector(force, "push: force"), "moment": _vector(moment, "push: moment")}
        return self._do("push", Wrench, {**keys, "duration": duration})

    def attach(
        self,
        mass: float,
        center: ArrayLike = (0.0, 0.0, 0.0),
        inertia: ArrayLike = (0.0,) * 6,
        *,
        duration: float | None = None,
        known: bool = False,
    ) -> Payload:
        """Attach a rigid body to the platform from now on, like the event `payload`.

        The energy balance of the run is not judged afterwards, unless the scenario itself contains such an event: only
        then has the run the column `load_energy`. Otherwise the event gets `log_energy: false`, so that a saved session
        has the same columns; a repeat without this key logs the energy.

        Args:
            mass: mass, kg.
            center: (3,) its centre of mass from the platform's origin, m, platform axes.
            inertia: (6,) ixx, iyy, izz, ixy, ixz, iyz about its centre of mass, kg m^2, platform axes.
            duration: duration, s, at least a control step; by default until `release`.
            known: True if controller and nominal robot take it into account.

        Returns:
            Handle for `release`.
        """
        keys = {"mass": mass, "center": _vector(center, "attach: center"), "duration": duration, "known": known}
        tensor = checked(inertia, (6,), "attach: inertia", finite=True).tolist()
        logged = None if self._loop.layout.has("loaded") else False
        return self._do("attach", Payload, {**keys, "inertia": tensor, "log_energy": logged})

    def release(self, push: Wrench | Payload) -> None:
        """End a wrench that `push` returned, or detach a body that `attach` returned, now."""
        with self._exclusive("release"):
            session, loop = self._runner.session, self._loop
            released = self._released(push)
            live = [released if one is push else one for one in session.live]
            session.live = tuple(one for one in live if one is not None)
            with self._kept():
                self._runner.revise()
                loop.push()

    def check_release(self, push: Wrench | Payload) -> None:
        """Raise the error of `release`, without any effect."""
        with self._exclusive("release"):
            self._released(push)

    def _released(self, push: Wrench | Payload) -> ScenarioEvent | None:
        self._ready()
        return self._runner.session.released(
            push, self._loop.count, undo=self._loop.schedule.can_undo(self._loop.count)
        )

    def target(
        self,
        position: ArrayLike | None = None,
        orientation: ArrayLike | Mapping[str, Any] | None = None,
        *,
        duration: float | None = None,
        limits: Mapping[str, float] | None = None,
        angular_limits: Mapping[str, float] | None = None,
    ) -> Target:
        """Replace the desired motion from now on by a move to another pose, and stay there.

        The move is one quintic from the present desired state, without a jump of velocity or acceleration.

        Args:
            position: (3,) m, world; by default the present one of the motion.
            orientation: (4,) quaternion w, x, y, z, or a mapping as in a scenario, such as {"rpy": [0, 0, 0.1]}; by
                default the present one of the motion.
            duration: duration of the move, s; alternative to `limits`.
            limits: {"velocity": m/s, "acceleration": m/s^2, "jerk": m/s^3}; the move is as short as these allow.
            angular_limits: likewise, in rad, required with `limits` if the attitude changes.
        """
        attitude = orientation
        if orientation is not None and not isinstance(orientation, Mapping):
            attitude = {"quaternion": checked(orientation, (4,), "target: orientation", finite=True).tolist()}
        keys = {
            "position": None if position is None else _vector(position, "target: position"),
            "orientation": attitude,
        }
        fast = {"duration": duration, "limits": limits, "angular_limits": angular_limits}
        return self._do("target", Target, {**keys, **fast})

    def cut(self, cable: Cable, *, detected_after: float | None = None) -> CableBreak:
        """Break a cable, given by name or number from 1; the distribution detects it `detected_after` s later."""
        return self._do("cut", CableBreak, {"cable": cable, "detected_after": detected_after})

    def jam(self, cable: Cable, *, detected_after: float | None = None) -> CableJam:
        """Freeze a cable's tension at its value in the last sample; arguments as for `cut`."""
        return self._do("jam", CableJam, {"cable": cable, "detected_after": detected_after})

    def fail_sensor(self, sensor: str, *, duration: float | None = None) -> SensorFailure:
        """Stop the measurements of a sensor from now on, for `duration` s if given."""
        return self._do("fail_sensor", SensorFailure, {"sensor": sensor, "duration": duration})

    def occlude_sensor(self, sensor: str, duration: float) -> SensorOcclusion:
        """Lose the measurements of a sensor for `duration` s."""
        return self._do("occlude_sensor", SensorOcclusion, {"sensor": sensor, "duration": duration})

    def bump_sensor(
        self,
        sensor: str,
        position: ArrayLike | None = None,
        rotation: ArrayLike | None = None,
        *,
        bias: float | Sequence[float] | None = None,
        quantity: str | None = None,
    ) -> SensorBump:
        """Move the mount of a sensor, or change its bias, like the event `sensor_bump`.

        Args:
            sensor: name of the sensor.
            position: (3,) movement of the mount, m, axes of the body that carries it; by default none.
            rotation: (3,) rotation vector of the mount about its place, rad, likewise.
            bias: what is added to the bias of a quantity, in its unit: one value, or one for each component.
            quantity: key of this quantity, by default the first one of the sensor.
        """
        vectors = {"position": position, "rotation": rotation}
        keys = {key: _vector(each, f"bump_sensor: {key}") for key, each in vectors.items() if each is not None}
        return self._do("bump_sensor", SensorBump, {"sensor": sensor, **keys, "bias": bias, "quantity": quantity})

    def limits(
        self, min: float | None = None, max: float | None = None, *, cable: Cable | None = None
    ) -> TensionLimits:
        """Change the tension limits, N, of one cable or of all; an omitted limit stays."""
        return self._do("limits", TensionLimits, {"min": min, "max": max, "cable": cable})

    def stop(self, category: int | None = None, *, stopping_time: float | None = None) -> EmergencyStop:
        """Stop the robot like the event `emergency_stop`: by default category 2 within 0.5 s."""
        return self._do("stop", EmergencyStop, {"category": category, "stopping_time": stopping_time})

    def set(self, key: str, value: Any) -> SetOption:
        """Change an option of controller or solver, such as `controller.kp`, if its plugin allows it."""
        return self._do("set", SetOption, {"key": key, "value": value})

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a scenario that repeats the simulation up to now, with the same bits.

        This is possible at any time, also after the end. The scenario contains the robot and all live events, and ends
        at the last complete sample. Commands by `wrench=` and `tension=` go to NAME_outside.csv beside it. An existing
        file `path` is overwritten, except the simulated scenario. An existing NAME_outside.csv is overwritten only if
        that file refers to it, as saved scenarios do.

        Raises:
            OutputError: if it cannot be written.
        """
        if not isinstance(path, str | os.PathLike) or not is_name(path):
            raise CdprError(f"save: expected the name of a file, got {shown(path)}")
        with self._exclusive("save"):
            self._runner.session.save(Path(path), self._runner.samples)

    def _do(self, title: str, kind: type[E], keys: Mapping[str, Any]) -> E:
        """Apply an event now."""
        with self._exclusive(title):
            self._ready()
            attempt = self._runner
            session = attempt.session
            before = session.live
            event = session.make(title, kind, self._loop.count, keys)
            session.live = (*before, event)
            failed: CdprError | None = None
            with self._kept():
                try:
                    scenario = session.scenario
                    check_known_mass(
                        (event,), self._loop.parts.controller, chosen_plugins(scenario)["solver"], scenario
                    )
                    attempt.revise()
                    self._loop.join(event)
                except CdprError as error:  # without any effect, as if a plugin rejected an option
                    failed, session.live = error, before
                    attempt.revise()
            if failed is not None:
                raise type(failed)(f"{title}: {failed}") from failed
            return event


def _vector(values: ArrayLike, name: str) -> list[float]:
    return [float(value) for value in checked(values, (3,), name, finite=True)]
