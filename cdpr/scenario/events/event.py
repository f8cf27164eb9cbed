"""Base classes of scenario events: section, checks, effects during a run, and log entries.

An event acts from the first sample at or after its time, k * control_step, with any engine; nothing happens within a
control step.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Protocol, Self

from pydantic import Field

from cdpr.base import tolerances
from cdpr.base.errors import CdprError
from cdpr.base.fields import Kind, NonNegative, unit
from cdpr.base.nearest import did_you_mean
from cdpr.base.problems import Path
from cdpr.config.problems import exact
from cdpr.log.event import Event
from cdpr.mechanics.attachments import Attachment
from cdpr.scenario.changes import Options
from cdpr.scenario.events.commands import Span
from cdpr.scenario.motions.guide import Guide, Posed
from cdpr.scenario.motions.motion import Report
from cdpr.sensing import Sensor
from cdpr.sensing.disturbance import Disturbance
from cdpr.trajectory import Trajectory


def first_sample(time: float, step: float) -> int:
    """Return the index of the first sample at or after `time` (s); `step` is the control period (s)."""
    return math.ceil(time / step - tolerances.TIME * max(1.0, time / step))


class EventActions(Protocol):
    """Receiver of event actions on cables, by name (None for all), options and sensors. Tensions in N."""

    def hold(self, cable: str, tension: float | None) -> None:
        """Set a cable's tension from now on; None keeps that of the previous sample."""

    def lock(self, cable: str) -> None:
        """Notify the distribution of the tension at which a cable is held."""

    def limit(self, cable: str | None, low: float | None, high: float | None) -> None:
        """Change tension limits, except None, of cables that the distribution does not treat as held."""

    def cut_power(self) -> None:
        """Release all cables except held ones, and stop distributing tensions."""

    def set(self, key: str, value: Any) -> None:
        """Change an option, named as in `controller.kp`, if its plugin supports it."""

    def disturb(self, sensor: str, change: Disturbance) -> None:
        """Disturb the later measurements of a sensor."""


Action = Callable[[EventActions], None]


@dataclass(frozen=True)
class WrenchProfile:
    """External wrench: amplitude times sin(angle * (k - first) + phase) at the samples `first` <= k < `end`."""

    first: int
    end: float
    angle: float  # rad per sample; 0 if constant
    phase: float  # rad
    amplitude: tuple[float, ...]  # (6,): force, N, and moment, N m, at the platform's origin, world axes


@dataclass(frozen=True, eq=False)
class AttachmentSpan:
    """Rigid body that is attached to the platform at the samples `first` <= k < `end`."""

    first: int
    end: float
    body: Attachment


@dataclass(frozen=True)
class ClearanceMonitor:
    """Condition on the cables' clearance, m, from a time on, s."""

    clearance: float
    after: float
    stops: bool  # True if a violation ends the run


@dataclass
class History:
    """Previous events, for the checks of an event.

    Attributes:
        unilateral: True if cables cannot push.
        limits: current limits, N, of each cable by name; None if unknown.
        set_at: time (s) of the last change of a cable's `min` or `max`, and its description.
        set_by: last event that changed a cable's limits.
        fate: state of cables that no longer follow commands, and since when, s.
        stopped: time of the emergency stop, s.
        cables: names of all cables.
        thin: names of cables of unknown diameter.
    """

    unilateral: bool
    limits: dict[str, tuple[float, float]] | None = None
    set_at: dict[tuple[str, str], tuple[float, str]] = field(default_factory=dict)
    set_by: dict[str, ScenarioEvent] = field(default_factory=dict)
    fate: dict[str, tuple[str, float]] = field(default_factory=dict)
    stopped: float | None = None
    cables: Sequence[str] = ()
    thin: Sequence[str] = ()


class ScenarioEvent(Kind):
    """Event at a time.

    Attributes:
        ideal_cables_only: True if it requires ideal cables.
        cuts_power: True if it cuts the power of the drives.
        overrides: True if it sets tensions that the distribution did not choose.
        changes_limits: True if it changes tension limits.
        ends_commands: True if external commands do not replace the answers of controller or solver from it on.
        changes_mass: True if it changes mass, centre of mass or inertia of the platform.
        logs_energy: True if the run logs the energy that it adds with a mass.
        wants_tensions: True if `event_log` needs the tensions of its first sample.
        files: keys that are file names.
    """

    ideal_cables_only: ClassVar[bool] = False
    overrides: ClassVar[bool] = False
    changes_limits: ClassVar[bool] = False
    changes_mass: ClassVar[bool] = False
    ends_commands: ClassVar[bool] = False
    wants_tensions: ClassVar[bool] = False
    files: ClassVar[tuple[str, ...]] = ()

    time: NonNegative = Field(
        description="time of the event: it acts from the first sample at or after this time",
        json_schema_extra=unit("s"),
    )

    @property
    def logs_energy(self) -> bool:
        """Return True: a run with a change of mass logs its energy."""
        return self.changes_mass

    @property
    def cuts_power(self) -> bool:
        """Return False: the drives have power."""
        return False

    def named(self, names: Sequence[str | None]) -> Self:
        """Return the event with its cable's name instead of its number; `names` are those of all cables."""
        return self

    def load(self, report: Report) -> Self | None:
        """Return the event with its files loaded; None if they are invalid, which is reported."""
        return self

    def check_cable(self, names: Sequence[str]) -> str:
        """Return what is wrong with its cable, or ""; `names` are those of the robot."""
        return ""

    def check_sensor(self, sensors: Sequence[Sensor], cables: int) -> Iterator[tuple[str, str]]:
        """Yield the key and text of problems with the scenario's sensors, of a robot with this number of cables."""
        return iter(())

    def stay(self, guide: Guide, where: Path) -> None:
        """Report violations of the guide; `where` is the path of the event."""

    def check_steps(self, step: float) -> Iterator[tuple[str, str]]:
        """Yield the key and text of problems with this control step, s."""
        return iter(())

    def check_options(self, options: Options) -> Iterator[tuple[Path, str]]:
        """Yield the path and text of problems with these options, and apply changes; called in order of time."""
        return iter(())

    def follow(self, history: History) -> Iterator[str]:
        """Yield problems caused by previous events, and update the history; called in order of time."""
        return iter(())

    def settle(self, history: History) -> Iterator[str]:
        """Yield problems that remain after all events of the same time."""
        return iter(())

    def actions(self, step: float) -> Iterator[tuple[float, Action]]:
        """Yield the actions on cables and options, with their times, s."""
        return iter(())

    def goal(self) -> Posed | None:
        """Return the target pose, if any; unchanged parts are None."""
        return None

    def wrench_profile(self, step: float) -> WrenchProfile | None:
        """Return the external wrench, if any."""
        return None

    def attachment(self, step: float) -> AttachmentSpan | None:
        """Return the body attached to the platform, if any."""
        return None

    def clearance_monitor(self, step: float) -> ClearanceMonitor | None:
        """Return the clearance condition, if any."""
        return None

    def redirect(self, motion: Trajectory, step: float) -> Trajectory:
        """Return the desired motion after the event's effect; raise CdprError if it is impossible."""
        return motion

    def commands(self) -> Sequence[Span]:
        """Return the values that replace the output of controller or solver."""
        return ()

    @abstractmethod
    def event_log(self, step: float, samples: int, tension: Mapping[str, float]) -> Iterator[Event]:
        """Yield log entries, each at the sample at which it applies.

        Args:
            step: control period, s.
            samples: number of samples of the run.
            tension: tension of each cable at the event's first sample, N, by name, if `wants_tensions` and known.
        """


class CableEvent(ScenarioEvent):
    """Event of one cable or, if none is given, of all.

    Attributes:
        breaks: True if the cable no longer exists after the event.
    """

    breaks: ClassVar[bool] = False

    cable: str | int | None

    def named(self, names: Sequence[str | None]) -> Self:
        """Return the event with its cable's name instead of its number."""
        return self.model_copy(update={"cable": names[self.cable - 1]}) if isinstance(self.cable, int) else self

    def check_cable(self, names: Sequence[str]) -> str:
        """Return what is wrong with its cable, or ""."""
        if isinstance(self.cable, int) and not 1 <= self.cable <= len(names):
            return f"cables are numbered from 1 to {len(names)}, got {self.cable}"
        if isinstance(self.cable, str) and self.cable not in names:
            return f"unknown cable '{self.cable}': {did_you_mean(self.cable, names)}allowed: {', '.join(names)}"
        return ""

    def follow(self, history: History) -> Iterator[str]:
        """Yield a problem if the cable is already broken or held."""
        what, since = ("", 0.0) if self.cable is None else history.fate.get(str(self.cable), ("", 0.0))
        if what and not self.possible(what):
            yield f"cable '{self.cable}' is {what} already, since {exact(since)} s"

    def possible(self, fate: str) -> bool:
        """Return True if the event can happen to a cable in this state."""
        return False


def guarding(events: Sequence[ScenarioEvent], step: float) -> list[tuple[ScenarioEvent, ClearanceMonitor]]:
    """Return the events with clearance conditions, each with its condition; `step` is the control period, s."""
    pairs = [(event, event.clearance_monitor(step)) for event in events]
    return [(event, guard) for event, guard in pairs if guard is not None]


def redirecting(events: Sequence[ScenarioEvent]) -> list[ScenarioEvent]:
    """Return the events that change the desired motion, by time."""
    moving = [event for event in events if type(event).redirect is not ScenarioEvent.redirect]
    return sorted(moving, key=lambda event: event.time)


def redirected(motion: Trajectory, events: Sequence[ScenarioEvent], step: float) -> Trajectory:
    """Return the motion after the effects of `events`; CdprError names an event that is impossible."""
    for event in redirecting(events):
        try:
            motion = event.redirect(motion, step)
        except CdprError as error:
            raise CdprError(f"event '{event.type}' at {event.time:g} s: {error}") from error
    return motion
