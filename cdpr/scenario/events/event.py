"""What every event of a scenario is: a section, its checks, what it does in a run, and what is told of it.

An event acts at the first sample at or after its time, k * control_step, and from then on whatever the engine: nothing
happens within a control step.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Protocol, Self

from pydantic import Field

from cdpr import tolerances
from cdpr.errors import CdprError
from cdpr.fields import Kind, NonNegative, unit
from cdpr.log.event import Event
from cdpr.nearest import did_you_mean
from cdpr.problems import Path
from cdpr.scenario.changes import Options
from cdpr.scenario.events.commands import Span
from cdpr.scenario.motions.guide import Guide, Posed
from cdpr.scenario.motions.motion import Report
from cdpr.scenario.problems import exact
from cdpr.trajectory import Trajectory


def first_sample(time: float, step: float) -> int:
    """Return the number of the first sample at or after `time` (s); `step` is the time between two (s)."""
    return math.ceil(time / step - tolerances.TIME * max(1.0, time / step))


class Drives(Protocol):
    """What an event may do to the cables, named, None standing for all of them, and to options. Tensions in N."""

    def hold(self, cable: str, tension: float | None) -> None:
        """From now on a cable has this tension, or where None is given that of the sample before."""

    def lock(self, cable: str) -> None:
        """The distribution learns which tension a cable is held at."""

    def limit(self, cable: str | None, low: float | None, high: float | None) -> None:
        """Change tension limits, but for None, of cables that the distribution does not know to be held."""

    def cut_power(self) -> None:
        """Leave all cables but those that are held without tension, and ask for none any more."""

    def set(self, key: str, value: Any) -> None:
        """Change an option, named as in `controller.kp`, of a plugin that lets it."""


Action = Callable[[Drives], None]


@dataclass(frozen=True)
class Swing:
    """An external wrench: amplitude times sin(angle * (k - first) + phase) at the samples `first` <= k < `end`."""

    first: int
    end: float
    angle: float  # rad a sample; 0 for what does not swing
    phase: float  # rad
    amplitude: tuple[float, ...]  # (6,): force, N, and moment, N m, at the platform's origin, world axes


@dataclass(frozen=True)
class Guard:
    """Cables are to keep their distance: from what touches them at this clearance, m, from a time on, s."""

    clearance: float
    after: float
    stops: bool  # whether the run ends where they do not


@dataclass
class History:
    """What has happened before an event, for its checks.

    Attributes:
        unilateral: whether cables cannot push.
        limits: present limits, N, of each cable by name; None where they are not known.
        set_at: when a cable's `min` or `max` was last changed, s, and to what, in words.
        set_by: which event was the last to change a cable's limits.
        fate: of cables that no longer do what they are told: what has become of them, and when, s.
        stopped: when the robot was stopped, s.
        cables: names of all.
        thin: names of those whose diameter is not known.
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
    """Something that happens at a time.

    Attributes:
        ideal_cables_only: whether it needs cables that pull what they are told.
        overrides: whether it gives cables tensions that the distribution did not choose.
        changes_limits: whether it changes tension limits.
        wants_tensions: whether `tell` needs the tensions of its first sample.
        files: keys that name files.
    """

    ideal_cables_only: ClassVar[bool] = False
    overrides: ClassVar[bool] = False
    changes_limits: ClassVar[bool] = False
    wants_tensions: ClassVar[bool] = False
    files: ClassVar[tuple[str, ...]] = ()

    time: NonNegative = Field(
        description="when it happens: it acts from the first sample at or after this time", json_schema_extra=unit("s")
    )

    def named(self, names: Sequence[str | None]) -> Self:
        """Return the event with its cable's name in place of the number; `names` are those of all cables."""
        return self

    def load(self, report: Report) -> Self | None:
        """Return the event with what its files hold; None where they are wrong, which is reported."""
        return self

    def check_cable(self, names: Sequence[str]) -> str:
        """Return what is wrong with its cable; `names` are those of the robot."""
        return ""

    def stay(self, guide: Guide, where: Path) -> None:
        """Report what leaves the guide; `where` is the path of the event."""

    def check_steps(self, step: float) -> Iterator[tuple[str, str]]:
        """Yield key and text of what cannot be with this control step, s."""
        return iter(())

    def check_options(self, options: Options) -> Iterator[tuple[Path, str]]:
        """Yield path and text of what cannot be with these options, and change them; asked in the order of time."""
        return iter(())

    def follow(self, history: History) -> Iterator[str]:
        """Yield what cannot be after what has happened, and take part in it; asked in the order of time."""
        return iter(())

    def settle(self, history: History) -> Iterator[str]:
        """Yield what cannot be once all that happens at its time has happened."""
        return iter(())

    def actions(self, step: float) -> Iterator[tuple[float, Action]]:
        """Yield what it does to cables, and when, s."""
        return iter(())

    def goal(self) -> Posed | None:
        """Return the pose to which it sends the platform, if any; what it leaves as it is, None."""
        return None

    def swing(self, step: float) -> Swing | None:
        """Return the external wrench that it is, if any."""
        return None

    def guard(self, step: float) -> Guard | None:
        """Return what it watches over, if anything: it happens where cables come too near to something."""
        return None

    def redirect(self, motion: Trajectory, step: float) -> Trajectory:
        """Return the desired motion as it is from then on, and was before; raises CdprError where it cannot be."""
        return motion

    def commands(self) -> Sequence[Span]:
        """Return what it gives in place of the answers of controller or solver."""
        return ()

    @abstractmethod
    def tell(self, step: float, samples: int, tension: Mapping[str, float]) -> Iterator[Event]:
        """Yield what there is to say of it, each at the sample at which it acts.

        Args:
            step: control period, s.
            samples: how many the run made.
            tension: N, of each cable by name at its first sample, where it wants them and they are known.
        """


class CableEvent(ScenarioEvent):
    """Something that happens to one cable, or where that may be left out to all.

    Attributes:
        breaks: whether the cable is no more from then on.
    """

    breaks: ClassVar[bool] = False

    cable: str | int | None

    def named(self, names: Sequence[str | None]) -> Self:
        """Return the event with its cable's name in place of the number."""
        return self.model_copy(update={"cable": names[self.cable - 1]}) if isinstance(self.cable, int) else self

    def check_cable(self, names: Sequence[str]) -> str:
        """Return what is wrong with its cable."""
        if isinstance(self.cable, int) and not 1 <= self.cable <= len(names):
            return f"cables are numbered from 1 to {len(names)}, got {self.cable}"
        if isinstance(self.cable, str) and self.cable not in names:
            return f"no cable is named '{self.cable}': {did_you_mean(self.cable, names)}there are {', '.join(names)}"
        return ""

    def follow(self, history: History) -> Iterator[str]:
        """Yield where the cable is no more, or held."""
        what, since = ("", 0.0) if self.cable is None else history.fate.get(str(self.cable), ("", 0.0))
        if what and not self.possible(what):
            yield f"cable '{self.cable}' is {what} already, since {exact(since)} s"

    def possible(self, fate: str) -> bool:
        """Whether it may happen to a cable of this fate."""
        return False


def guarding(events: Sequence[ScenarioEvent], step: float) -> list[tuple[ScenarioEvent, Guard]]:
    """Return the events that watch over clearances, each with its guard; `step` is the control period, s."""
    pairs = [(event, event.guard(step)) for event in events]
    return [(event, guard) for event, guard in pairs if guard is not None]


def redirected(motion: Trajectory, events: Sequence[ScenarioEvent], step: float) -> Trajectory:
    """Return the motion with what `events` do to it. Raises CdprError, naming the event, where one cannot be."""
    for event in sorted(events, key=lambda event: event.time):
        try:
            motion = event.redirect(motion, step)
        except CdprError as error:
            raise CdprError(f"event '{event.type}' at {event.time:g} s: {error}") from error
    return motion
