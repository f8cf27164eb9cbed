"""A tension solver whose kernel is Python, compiled by numba."""

from cdpr.plugins import PluginInfo, hookimpl


@hookimpl
def cdpr_solvers() -> list[PluginInfo]:
    """List the plugins of this package."""
    return [
        PluginInfo(
            name="strong_cables",
            factory="cdpr_strong_cables.solver:StrongCables",
            requires=("numba",),
            summary="least tensions relative to each cable's strength, without limits",
            properties={"exact": True, "respects_bounds": False, "continuity": "jump"},
        )
    ]
