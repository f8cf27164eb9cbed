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
            properties={
                "exact": True,
                "respects_bounds": True,
                "continuity": "C0",
                "coverage": "full",
                "objective": "min_norm",
            },
        ),
        PluginInfo(
            name="pseudo_inverse",
            factory="cdpr_solvers.pseudo_inverse:PseudoInverse",
            summary="minimum 2-norm without limits (thesis 6.26); may leave them, then the stage clips",
            properties={"exact": True, "respects_bounds": False, "continuity": "Cinf"},
        ),
        PluginInfo(
            name="closed_form",
            factory="cdpr_solvers.closed_form:ClosedForm",
            summary="closest to the middle of the limits (thesis 6.28, corrected); gives up outside the limits",
            properties={"exact": True, "respects_bounds": True, "continuity": "Cinf", "objective": "mid_range"},
        ),
        PluginInfo(
            name="osqp",
            factory="cdpr_solvers.osqp:Osqp",
            summary="minimum 2-norm within the limits by OSQP, to about 1e-6 N",
            requires=("osqp", "scipy"),
            extra="cdpr[solvers]",
            properties={
                "exact": False,
                "respects_bounds": True,
                "continuity": "C0",
                "objective": "min_norm",
                "warm_start": True,  # of its step size and scaling only
            },
        ),
    ]
