"""The tension solvers that come with cdpr."""

from __future__ import annotations

from cdpr.plugins import PluginInfo, hookimpl


@hookimpl
def cdpr_solvers() -> list[PluginInfo]:
    """Return the built-in solvers."""
    return [
        PluginInfo(
            name="qp",
            factory="cdpr_solvers.qp:MinimumNorm",
            summary="minimum 2-norm within the limits, exact, by a dual active set in the null space",
            properties={"exact": True, "respects_bounds": True, "continuity": "C0"},
        ),
        PluginInfo(
            name="pseudo_inverse",
            factory="cdpr_solvers.pseudo_inverse:PseudoInverse",
            summary="minimum 2-norm without limits (thesis 6.26); may leave them, then the stage clips",
            properties={"exact": True, "respects_bounds": False, "continuity": "Cinf"},
        ),
    ]
