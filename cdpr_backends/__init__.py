"""The physics backends that come with cdpr."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, model_validator

from cdpr.fmu.options import FmuFile
from cdpr.plugins import PluginInfo, PluginOptions, hookimpl

CABLE_MODELS = ("ideal", "rigid", "elastic")  # with cdpr's own cable kernel; tendons and legs are ideal only

CABLES = "cdpr's own cable kernel (ideal), or rigid legs of 1 g on universal and ball joints (ups)"


class MujocoOptions(PluginOptions):
    """Options of the backend `mujoco`."""

    cables: Literal["ideal", "native", "ups"] = Field(
        "ideal",
        description="cdpr's own cable kernel (ideal), MuJoCo's spatial tendons (native), or rigid legs of 1 g (ups)",
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


class BulletOptions(PluginOptions):
    """Options of the backend `bullet`."""

    cables: Literal["ideal", "ups"] = Field("ideal", description=CABLES)


class DartOptions(PluginOptions):
    """Options of the backend `dart`."""

    cables: Literal["ideal", "ups"] = Field("ideal", description=CABLES)


class ExportOptions(PluginOptions):
    """How cdpr is to export the robot."""

    fmi: Literal[2, 3] = Field(3, description="version of the standard")


class FmuOptions(PluginOptions, FmuFile):
    """Options of the backend `fmu`."""

    file: str | None = Field(
        None, min_length=1, description="the FMU, relative to this file; the scenario's robot is exported unless given"
    )
    export: ExportOptions | None = Field(
        None, description="the scenario's robot, exported by cdpr and kept in the user's cache"
    )
    step: float | None = Field(
        None,
        gt=0.0,
        description="communication step, physics_step divided by an integer; physics_step unless given",
        json_schema_extra={"unit": "s"},
    )

    @model_validator(mode="after")
    def _one_source(self) -> FmuOptions:
        if self.file is not None and self.export is not None:
            raise ValueError("file and export exclude each other")
        if self.file is None and self.sha256 is not None:
            raise ValueError("sha256 is that of a file; give file, too")
        return self


@hookimpl
def cdpr_backends() -> list[PluginInfo]:
    """Return the built-in backends."""
    return [
        PluginInfo(
            name="reference",
            factory="cdpr_backends.reference:make",
            summary="own Runge-Kutta integrator, fourth order, the judge of the others",
            properties={"order": 4, "snapshot": True, "cable_models": CABLE_MODELS},
        ),
        PluginInfo(
            name="mujoco",
            factory="cdpr_backends.mujoco:make",
            summary="MuJoCo, semi-implicit Euler (rk4 with its own tendons)",
            requires=("mujoco",),
            extra="cdpr[mujoco]",
            properties={"order": 1, "snapshot": True, "cable_models": CABLE_MODELS},
            options=MujocoOptions,
        ),
        PluginInfo(
            name="bullet",
            factory="cdpr_backends.bullet:make",
            summary="PyBullet, semi-implicit Euler",
            requires=("pybullet",),
            extra="cdpr[bullet]",
            properties={"order": 1, "snapshot": True, "cable_models": CABLE_MODELS},
            options=BulletOptions,
        ),
        PluginInfo(
            name="dart",
            factory="cdpr_backends.dart:make",
            summary="DART, semi-implicit Euler",
            requires=("dartpy",),
            extra="cdpr[dart]",
            properties={"order": 1, "snapshot": True, "cable_models": CABLE_MODELS},
            options=DartOptions,
        ),
        PluginInfo(
            name="fmu",
            factory="cdpr_backends.fmu:FmuBackend",
            summary="a plant as an FMU (FMI 2.0 or 3.0, co-simulation); without a file, the robot as cdpr exports it",
            requires=("fmpy",),
            extra="cdpr[fmu]",
            properties={"order": 4, "snapshot": True},
            options=FmuOptions,
        ),
    ]
