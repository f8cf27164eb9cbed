"""Selection of backend, solver and controller by arguments, and the keys of their sections."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from cdpr.base.problems import Mark, shown
from cdpr.config.overrides import Change, brief, marked_changes
from cdpr.config.problems import Problems
from cdpr.scenario.schema import ControllerSection, SolverSection

# Keys of these sections that do not belong to the plugin selected by `type`.
CORE_KEYS: dict[str, tuple[str, ...]] = {
    "controller": tuple(ControllerSection.model_fields),
    "solver": tuple(SolverSection.model_fields),
}
DEFAULT_TYPE = {"controller": ControllerSection().type, "solver": SolverSection().type}
CHOICES = {"backend": "simulation.backend", "solver": "solver.type", "controller": "controller.type"}


def choices(chosen: Mapping[str, str | None], problems: Problems) -> list[Change]:
    """Return the changes that select plugins from the arguments `backend`, `solver` and `controller`."""
    given = [(name, key, chosen[name]) for name, key in CHOICES.items() if chosen.get(name) is not None]
    return marked_changes([(key, value, Mark(f"{name}={brief(shown(value))}")) for name, key, value in given], problems)


def typed(chosen: Mapping[str, str | None], texts: Sequence[str] = ()) -> list[Change | str]:
    """Return the changes from `--backend`, `--solver` and `--controller`, followed by the `--set` texts."""
    given = [(name, value) for name, value in chosen.items() if value is not None]
    return [
        *(Change(tuple(CHOICES[name].split(".")), value, Mark(f"--{name} {brief(value)}")) for name, value in given),
        *texts,
    ]
