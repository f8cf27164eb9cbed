"""A tension solver whose kernel is compiled C, called by its address from cffi."""

from cdpr.plugins import PluginInfo, hookimpl


@hookimpl
def cdpr_solvers() -> list[PluginInfo]:
    """List the plugins of this package."""
    return [
        PluginInfo(
            name="cffi_mid_range",
            factory="cdpr_mid_range.solver:MidRange",
            summary="tensions nearest to the middle of their limits, if they are within",
            properties={"exact": True, "respects_bounds": True, "continuity": "jump"},
        )
    ]
