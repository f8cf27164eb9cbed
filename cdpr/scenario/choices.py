"""Selection of backend, solver, controller and estimator by arguments, and the keys of their sections."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from cdpr.base.defaults import CONTROLLER, ESTIMATOR, SOLVER
from cdpr.base.problems import Mark, shown
from cdpr.config.overrides import Change, brief, marked_changes
from cdpr.config.problems import Problems
from cdpr.scenario.schema import ControllerSection, EstimatorSection, SolverSection

# Keys of these sections that do not belong to the plugin selected by `type`.
CORE_KEYS: dict[str, tuple[str, ...]] = {
    "controller": tuple(ControllerSection.model_fields),
    "solver": tuple(SolverSection.model_fields),
    "estimator": tuple(EstimatorSection.model_fields),
}
DEFAULT_TYPE = {"controller": CONTROLLER, "solver": SOLVER, "estimator": ESTIMATOR}
CHOICES = {
    "backend": "simulation.backend",
    "solver": "solver.type",
    "controller": "controller.type",
    "estimator": "estimator.type",
}


@dataclass(frozen=True)
class Choice(Change):
    """Selection of a plugin by an argument."""


def choices(chosen: Mapping[str, str | None], problems: Problems) -> list[Change]:
    """Return the changes that select plugins from the arguments that `CHOICES` names."""
    given = [(name, key, chosen[name]) for name, key in CHOICES.items() if chosen.get(name) is not None]
    rows = [(key, value, Mark(f"{name}={brief(shown(value))}")) for name, key, value in given]
    return [Choice(each.path, each.value, each.mark) for each in marked_changes(rows, problems)]


def typed(chosen: Mapping[str, str | None], texts: Sequence[str] = ()) -> list[Change | str]:
    """Return the changes from `--backend` and the other options of `CHOICES`, followed by the `--set` texts."""
    given = [(name, value) for name, value in chosen.items() if value is not None]
    return [
        *(Choice(tuple(CHOICES[name].split(".")), value, Mark(f"--{name} {brief(value)}")) for name, value in given),
        *texts,
    ]


def with_choices(changes: Sequence[Change], problems: Problems) -> list[Change]:
    """Return the changes, with the plugins selected by arguments also in sections that other changes replace.

    A change that names another plugin is reported.
    """
    done = list(changes)
    for choice in (change for change in changes if isinstance(change, Choice)):
        section, key = choice.path[:-1], choice.path[-1]
        for i, other in enumerate(done):
            value = other.value
            if other.path == section and isinstance(value, dict):
                done[i] = replace(other, value={key: choice.value, **value})
                value = done[i].value[key]
            elif other.path != choice.path:
                continue
            if value != choice.value:
                problems.add(
                    choice.mark, choice.path, f"contradicts {shown(value)} of {other.mark}; give one of the two"
                )
    return done
