"""A tension solver that loads strong cables more than weak ones."""

from pydantic import Field

from cdpr.plugins import PluginInfo, PluginOptions, hookimpl


class Options(PluginOptions):
    """Options of a scenario under `solver`."""

    power: float = Field(1.0, ge=0.0, description="0 treats all cables alike, 1 weighs each by its strength")


@hookimpl
def cdpr_solvers() -> list[PluginInfo]:
    """Return the plugins of this package."""
    return [
        PluginInfo(
            name="weighted",
            factory="cdpr_weighted.solver:Weighted",
            summary="least tensions relative to each cable's strength, without limits",
            properties={"exact": True, "respects_bounds": False, "continuity": "Cinf"},
            options=Options,
        )
    ]
