"""A controller whose law is compiled C, called by its address from ctypes."""

from pydantic import Field

from cdpr.plugins import PluginInfo, PluginOptions, hookimpl


class Options(PluginOptions):
    """Options of the controller."""

    kp: float = Field(25.0, ge=0.0, description="Stiffness per mass, 1/s^2")
    kd: float = Field(10.0, ge=0.0, description="Damping per mass, 1/s")


@hookimpl
def cdpr_controllers() -> list[PluginInfo]:
    """List the plugins of this package."""
    return [
        PluginInfo(
            name="spring",
            factory="cdpr_spring.controller:Spring",
            summary="spring and damper towards the desired motion, and the weight",
            options=Options,
        )
    ]
