"""What may be done to a simulation between two steps: each is an event of its scenario from then on."""

from __future__ import annotations

import os
from _thread import LockType
from abc import ABC, abstractmethod
from collections.abc import Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, TypeVar

from numpy.typing import ArrayLike

from cdpr.errors import CdprError
from cdpr.log.files import is_name
from cdpr.model.arrays import checked
from cdpr.scenario.events import ScenarioEvent
from cdpr.scenario.events.faults import CableBreak, CableJam
from cdpr.scenario.events.limits import TensionLimits
from cdpr.scenario.events.loads import Wrench
from cdpr.scenario.events.options import SetOption
from cdpr.scenario.events.stop import EmergencyStop
from cdpr.scenario.events.target import Target
from cdpr.simulation.attempt import Attempt
from cdpr.simulation.loop import Loop

E = TypeVar("E", bound=ScenarioEvent)

Cable = str | int


class Alone:
    """Keeps `lock` for a `with` statement; CdprError, saying `what` was asked for, where somebody has it."""

    __slots__ = ("_lock", "_what")

    def __init__(self, lock: LockType, what: str) -> None:
        self._lock, self._what = lock, what

    def __enter__(self) -> None:
        if not self._lock.acquire(blocking=False):
            raise CdprError(
                f"{self._what}: the simulation is in the midst of a step, or of another call; observers only look on, "
                "and threads must wait for each other"
            )

    def __exit__(self, *_: object) -> None:
        self._lock.release()


class Interventions(ABC):
    """Does to a simulation what events of a scenario do, at its present time, and keeps it as such events.

    All raise CdprError, and nothing has happened, where a scenario could not hold such an event: what is unknown, out
    of range, no more possible (a cable that broke), would make a later event of the scenario impossible, or cannot
    happen to this plant. What begins with the present sample acts from the next step on.
    """

    _attempt: Attempt
    _loop: Loop

    @abstractmethod
    def _alone(self, what: str) -> AbstractContextManager[None]:
        """Refuse what comes in the midst of something else."""

    @abstractmethod
    def _ready(self, *, also_done: bool = False) -> None:
        """Refuse what comes after the end."""

    @abstractmethod
    def _kept(self) -> AbstractContextManager[None]:
        """Whatever ends it, end the run with it."""

    def push(
        self,
        force: ArrayLike = (0.0, 0.0, 0.0),
        moment: ArrayLike = (0.0, 0.0, 0.0),
        *,
        duration: float | None = None,
    ) -> Wrench:
        """Let a wrench act on the platform from now on, beside those that do.

        Args:
            force: (3,) N, at the platform's origin, world axes.
            moment: (3,) N m, likewise.
            duration: how long, s, at least a control step; until it is released unless given.

        Returns what `release` takes.
        """
        keys = {"force": _vector(force, "push: force"), "moment": _vector(moment, "push: moment")}
        return self._do("push", Wrench, {**keys, "duration": duration})

    def release(self, push: Wrench) -> None:
        """End what `push` returned, now."""
        with self._alone("release"):
            self._ready()
            session, loop = self._attempt.session, self._loop
            released = session.released(push, loop.count)
            live = [released if one is push else one for one in session.live]
            session.live = tuple(one for one in live if one is not None)
            with self._kept():
                self._attempt.revise()
                loop.push()

    def target(
        self,
        position: ArrayLike | None = None,
        orientation: ArrayLike | Mapping[str, Any] | None = None,
        *,
        duration: float | None = None,
        limits: Mapping[str, float] | None = None,
        angular_limits: Mapping[str, float] | None = None,
    ) -> Target:
        """Let the desired motion leave what it was going to do, and go to another pose and stay there.

        One quintic from the present desired state, whose velocity and acceleration go on without a jump.

        Args:
            position: (3,) m, world; where the motion is now unless given.
            orientation: (4,) quaternion w, x, y, z, or a mapping as in a scenario, such as {"rpy": [0, 0, 0.1]}; that
                of the motion now unless given.
            duration: of the move, s; or else
            limits: {"velocity": m/s, "acceleration": m/s^2, "jerk": m/s^3}; the move is as short as they allow.
            angular_limits: likewise, in rad, needed with limits where the attitude changes.
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
        """Break a cable, given by its name or its number from 1; the distribution knows `detected_after` s later."""
        return self._do("cut", CableBreak, {"cable": cable, "detected_after": detected_after})

    def jam(self, cable: Cable, *, detected_after: float | None = None) -> CableJam:
        """Freeze a cable's tension at that of the last sample; arguments as for `cut`."""
        return self._do("jam", CableJam, {"cable": cable, "detected_after": detected_after})

    def limits(
        self, min: float | None = None, max: float | None = None, *, cable: Cable | None = None
    ) -> TensionLimits:
        """Change the tension limits, N, of one cable or of all; one that is not given stays."""
        return self._do("limits", TensionLimits, {"min": min, "max": max, "cable": cable})

    def stop(self, category: int | None = None, *, stopping_time: float | None = None) -> EmergencyStop:
        """Stop the robot, as the event `emergency_stop` does: by category 2 within 0.5 s unless said."""
        return self._do("stop", EmergencyStop, {"category": category, "stopping_time": stopping_time})

    def set(self, key: str, value: Any) -> SetOption:
        """Give an option of controller or solver, such as `controller.kp`, another value, if its plugin lets it."""
        return self._do("set", SetOption, {"key": key, "value": value})

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a scenario that repeats what has happened so far, to the bit; at any time, also after the end.

        It holds the robot and all that was done as events, and lasts until the last complete sample. What was given by
        `wrench=` and `tension=` goes to NAME_outside.csv beside it. A file of the name `path` is written over, but not
        the scenario that is simulated; a NAME_outside.csv only where that file names it, as one that was saved does.
        Raises OutputError where it cannot be written.
        """
        if not isinstance(path, str | os.PathLike) or not is_name(path):
            raise CdprError(f"save: the name of a file is expected, got {path!r}")
        with self._alone("save"):
            self._attempt.session.save(Path(path), self._attempt.samples)

    def _do(self, title: str, kind: type[E], keys: Mapping[str, Any]) -> E:
        """Let an event happen now."""
        with self._alone(title):
            self._ready()
            attempt = self._attempt
            session = attempt.session
            before = session.live
            event = session.make(title, kind, self._loop.count, keys)
            session.live = (*before, event)
            failed: CdprError | None = None
            with self._kept():
                try:
                    attempt.revise()
                    self._loop.join(event)
                except CdprError as error:  # as where a plugin refuses an option: it has changed nothing
                    failed, session.live = error, before
                    attempt.revise()
            if failed is not None:
                raise type(failed)(f"{title}: {failed}") from failed
            return event


def _vector(values: ArrayLike, name: str) -> list[float]:
    return [float(value) for value in checked(values, (3,), name, finite=True)]
