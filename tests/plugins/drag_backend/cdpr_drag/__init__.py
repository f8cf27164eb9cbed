"""A backend with air: a free body, semi-implicit Euler, drag proportional to the square of the speed."""

from pydantic import Field

from cdpr.plugins import Column, PluginInfo, PluginOptions, hookimpl


class DragOptions(PluginOptions):
    """Options of a scenario under `backend_options: {drag: ...}`."""

    area: float = Field(
        0.0,
        ge=0.0,
        description="drag coefficient times frontal area; 0 is a vacuum",
        json_schema_extra={"unit": "m^2"},
    )


@hookimpl
def cdpr_backends() -> list[PluginInfo]:
    """Return the plugins of this package."""
    return [
        PluginInfo(
            name="drag",
            factory="cdpr_drag.backend:DragBackend",
            summary="semi-implicit Euler with the drag of air, free platforms only",
            properties={"order": 1, "snapshot": True, "works": {"the drag of air": "drag_work"}},
            columns=(Column("drag_work", 1, "J", "Work of the drag of air since the first sample"),),
            options=DragOptions,
        )
    ]
