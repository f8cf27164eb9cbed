"""Works on the platform besides those of cables, external wrenches and payloads, as parts of a scenario declare them.

A backend declares them in its property `works`, a part of the loop in its attribute `works`, and a section in its
`needs`: a mapping from sources to columns, "" for a source of unknown work. The energy balance of a run includes the
known works. It is not judged if a work is unknown.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from cdpr.base.errors import PluginError
from cdpr.base.problems import short_repr
from cdpr.log.header import BODIES, Header
from cdpr.scenario import Scenario
from cdpr.scenario.events import ScenarioEvent, logged_mass_changes, mass_changes
from cdpr.scenario.needs import in_use
from cdpr.simulation.columns import chosen_plugins, columns_of
from cdpr.simulation.loop_parts import loop_parts

UNRECORDED = (BODIES, "")


def works_of(scenario: Scenario) -> tuple[tuple[str, str], ...]:
    """Return the declared sources of work on the platform, each with the column of its work; "" if it is unknown.

    Raises:
        PluginError: if a declaration is invalid.
    """
    columns = {column.name: column for column in columns_of(scenario)}
    found: dict[str, str] = {}
    for owner, declared in _declared(scenario):
        if not isinstance(declared, Mapping) or not all(isinstance(name, str) for name in declared.values()):
            raise PluginError(f"{owner}: works: expected a mapping of sources and columns, got {short_repr(declared)}")
        for source, name in declared.items():
            if not isinstance(source, str) or not source:
                raise PluginError(f"{owner}: works: expected a source with a name, got {short_repr(source)}")
            if found.get(source, name) != name:
                raise PluginError(f"{owner}: works: another part declares the source '{source}' already")
            if name and (name not in columns or (columns[name].width, columns[name].unit) != (1, "J")):
                raise PluginError(
                    f"{owner}: works of '{source}': expected an additional column of this run with width 1 and unit J, "
                    f"or '' for unknown work, got '{name}'"
                )
            found[source] = name
    loaded = logged_mass_changes(scenario.events)
    return (*found.items(), *_bodies(scenario.events, loaded))


def with_live_events(header: Header, events: Sequence[ScenarioEvent]) -> tuple[tuple[str, str], ...]:
    """Return the works of a run with these events."""
    works = tuple(row for row in header.works if row != UNRECORDED)
    return (*works, *_bodies(events, header.loaded))


def _bodies(events: Sequence[ScenarioEvent], loaded: bool) -> tuple[tuple[str, str], ...]:
    """Return the unknown work of attached bodies, in a run without the column of their energy."""
    return (UNRECORDED,) if mass_changes(events) and not loaded else ()


def _declared(scenario: Scenario) -> Iterator[tuple[str, object]]:
    """Yield the declarations, each with the name of its owner for messages."""
    entry = chosen_plugins(scenario)["backend"]
    properties = entry.properties(scenario.backend_options(entry.info.name))  # type: ignore[arg-type]
    yield f"backend '{entry.info.name}'", properties.get("works", {})
    for part in loop_parts(scenario):
        yield part.title, part.works
        yield part.title, part.needs.works
    for path, needs, _ in in_use(scenario):
        yield ".".join(map(str, path)), needs.works
