"""An engine with one of the faults that adapters have; with `installed` on the path, too, it counts as installed."""

from typing import Literal

from pydantic import Field

from cdpr.plugins import PluginInfo, PluginOptions, hookimpl

Trap = Literal[
    *("none", "frame", "damping", "clamp", "persistence", "lag", "auto_reset", "dropped_nan"),
    *("gravity", "light_damping", "late"),
]


class TrapOptions(PluginOptions):
    """Selected fault and engine, and the scheme declared by the engine."""

    engine: str = Field("mujoco", description="the backend that is wrapped")
    trap: Trap = Field("none", description="the fault")
    scheme: str = Field("semi_implicit_euler", description="the scheme that is declared; '' for none")
    order: int = Field(1, description="the order that is declared")

    def declares(self):
        """Without a scheme it is judged by its order."""
        return {"scheme": self.scheme, "order": self.order}


@hookimpl
def cdpr_backends() -> list[PluginInfo]:
    """Return the plugins of this package."""
    return [
        PluginInfo(
            "traps",
            "cdpr_traps.backend:make",
            "another backend with a fault",
            properties={"order": 1, "snapshot": True, "scheme": "semi_implicit_euler"},
            options=TrapOptions,
        )
    ]
