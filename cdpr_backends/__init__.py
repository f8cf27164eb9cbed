"""The physics backends that come with cdpr."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, model_validator

from cdpr.plugins import PluginInfo, PluginOptions, hookimpl


class MujocoOptions(PluginOptions):
    """Options of the backend `mujoco`."""

    cables: Literal["ideal", "native"] = Field(
        "ideal",
        description="who evaluates the cables: cdpr's own kernel (ideal) or MuJoCo's spatial tendons (native)",
    )
    integrator: Literal["euler", "rk4"] = Field(
        "euler", description="semi-implicit Euler, or fourth-order Runge-Kutta (with native cables only)"
    )

    @model_validator(mode="after")
    def _geometry_at_every_stage(self) -> MujocoOptions:
        if self.integrator == "rk4" and self.cables != "native":
            raise ValueError(
                "integrator rk4 needs cables: native; with the wrench frozen over the step it would be first order"
            )
        return self


@hookimpl
def cdpr_backends() -> list[PluginInfo]:
    """Return the built-in backends."""
    return [
        PluginInfo(
            name="reference",
            factory="cdpr_backends.reference:make",
            summary="own Runge-Kutta integrator, fourth order, the judge of the others",
            properties={"order": 4},
        ),
        PluginInfo(
            name="mujoco",
            factory="cdpr_backends.mujoco:make",
            summary="MuJoCo, semi-implicit Euler (rk4 with its own tendons)",
            requires=("mujoco",),
            extra="cdpr[mujoco]",
            properties={"order": 1},
            options=MujocoOptions,
        ),
    ]
