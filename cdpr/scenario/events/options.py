"""Event that changes an option during a run."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, Literal

from pydantic import Field

from cdpr.base.errors import CdprError
from cdpr.base.needs import Needs, of_event
from cdpr.base.problems import Path
from cdpr.log.event import Event
from cdpr.scenario.changes import Options, RefusedError
from cdpr.scenario.events.event import Action, EventActions, ScenarioEvent, first_sample


class SetOption(ScenarioEvent):
    """Change of a controller or solver option, if its plugin declares it changeable."""

    needs: ClassVar[Needs] = of_event()
    type: Literal["set"] = Field(
        default_factory=lambda: "set", description="an option of controller or solver gets another value"
    )
    key: str = Field(description="option, such as controller.kp; the plugin must allow changes during a run")
    value: Any = Field(description="its value from then on")

    def check_options(self, options: Options) -> Iterator[tuple[Path, str]]:
        """Yield the reasons why the option cannot have this value, or cannot change."""
        try:
            options.change(self.key, self.value)
        except RefusedError as error:
            yield from error.faults
        except CdprError as error:
            yield ("value",), str(error)

    def actions(self, step: float) -> Iterator[tuple[float, Action]]:
        """Yield the change at its time."""

        def change(drives: EventActions) -> None:
            drives.set(self.key, self.value)

        yield self.time, change

    def event_log(self, step: float, samples: int, tension: Mapping[str, float]) -> Iterator[Event]:
        """Yield the new value."""
        text = f"{self.key} becomes {json.dumps(self.value)}"
        yield Event(first_sample(self.time, step) * step, self.type, text)
