"""Runs that are interrupted by a snapshot, its restoration and a reset."""

from __future__ import annotations

from typing import Any

import cdpr


def assert_restarts_give(whole: bytes, scenario: Any, overrides: dict[str, Any]) -> None:
    """Assert that a run of 50 samples gives the bytes `whole` of its rows after a restored snapshot and a reset."""
    with cdpr.Simulation(scenario, overrides=overrides) as simulation:
        simulation.step(20)
        snapshot = simulation.snapshot()
        simulation.step(15)
        simulation.restore(snapshot)
        simulation.step(30)
        assert simulation.run().rows.tobytes() == whole
        simulation.reset()
        simulation.step(50)
        assert simulation.run().rows.tobytes() == whole
