"""Stand-in until the branch desk is here."""

from typing import Any

from cdpr.scenario import Scenario, load_scenario


class Desk:
    """A scenario that cannot be edited yet."""

    def __init__(self, name: str, **choices: Any) -> None:
        self._scenario = load_scenario(name, **choices)

    def form(self) -> dict[str, Any]:
        """Nothing."""
        return {}

    def scenario(self) -> Scenario:
        """Return it."""
        return self._scenario

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(name)
