"""A tension solver whose kernel is an extension built on cdpr's headers."""

from cdpr.plugins import PluginInfo, hookimpl


@hookimpl
def cdpr_solvers() -> list[PluginInfo]:
    """List the plugins of this package."""
    return [
        PluginInfo(
            name="least_norm",
            factory="cdpr_least_norm.solver:LeastNorm",
            summary="tensions of least norm, without limits, by the normal equations",
            properties={"exact": True, "respects_bounds": False, "continuity": "jump"},
        )
    ]
