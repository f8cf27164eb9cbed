"""Check that a scenario is deterministic, which comparing or caching runs requires."""

from __future__ import annotations

from cdpr.base.errors import CdprError
from cdpr.scenario.scenario import Scenario


def check_repeatable(scenario: Scenario, what: str) -> None:
    """Raise CdprError if a plugin of the scenario declares that it is not deterministic.

    `what` names the feature that requires it, for the message.
    """
    found, simulation = scenario.plugins, scenario.simulation
    declared = {
        f"backend '{simulation.backend}'": found.get("backend", simulation.backend).properties(
            scenario.backend_options()  # type: ignore[arg-type]
        ),
        f"controller '{scenario.controller.type}'": found.get("controller", scenario.controller.type).properties(
            scenario.controller_options  # type: ignore[arg-type]
        ),
    }
    for name, properties in declared.items():
        if not properties.get("deterministic", True):
            raise CdprError(
                f"{scenario.source}: {what} requires reproducible runs, but with these options {name} follows the "
                "wall clock: set lockstep: true and real_time: false"
            )
