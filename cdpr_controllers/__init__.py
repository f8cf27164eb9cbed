"""The controllers that come with cdpr."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from cdpr.plugins import PluginInfo, PluginOptions, hookimpl

Gain = Annotated[float, Field(ge=0.0)]
Gains = Gain | Annotated[tuple[Gain, Gain, Gain, Gain, Gain, Gain], Field(strict=False)]


class ComputedTorqueOptions(PluginOptions):
    """Options of the controller `computed_torque`."""

    kp: Gains = Field(
        100.0,
        description="proportional gain, a number or one per degree of freedom",
        json_schema_extra={"unit": "1/s^2"},
    )
    kd: Gains = Field(
        20.0, description="damping gain, a number or one per degree of freedom", json_schema_extra={"unit": "1/s"}
    )


class StaticOptions(PluginOptions):
    """Options of the controller `static`."""

    kp: Gains = Field(
        50.0,
        description="proportional gain, a number or one per degree of freedom",
        json_schema_extra={"unit": "1/s^2"},
    )
    kd: Gains = Field(
        50.0, description="damping gain, a number or one per degree of freedom", json_schema_extra={"unit": "1/s"}
    )


@hookimpl
def cdpr_controllers() -> list[PluginInfo]:
    """Return the built-in controllers."""
    return [
        PluginInfo(
            name="computed_torque",
            factory="cdpr_controllers.computed_torque:ComputedTorque",
            summary="inverse dynamics with proportional and damping terms (thesis 6.3-6.5, corrected)",
            properties={"output": "wrench"},
            options=ComputedTorqueOptions,
        ),
        PluginInfo(
            name="static",
            factory="cdpr_controllers.static:Static",
            summary="gravity compensation with proportional and damping terms, no feed-forward",
            properties={"output": "wrench"},
            options=StaticOptions,
        ),
    ]
