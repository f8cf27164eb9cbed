"""Built-in physics backends."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field, model_validator

from cdpr.base.column import Column
from cdpr.base.fields import MAX_MAGNITUDE
from cdpr.cables import EXITS, MODELS
from cdpr.fmu.read.options import FMU, FmuFile
from cdpr.link.options import REMOTE, PeerOptions
from cdpr.plugins import FileName, PluginInfo, PluginOptions, hookimpl

ALL_EXITS = tuple(EXITS)
OUR_CABLES = {"cable_models": tuple(MODELS), "exits": ALL_EXITS}  # tendons and legs support none

FEATURES = ("moving_anchors", "winch_commands", "exit_friction", "brakes", "steppers")

# Scheme of MuJoCo, Bullet and DART. The reference also has it, for comparisons with each of them.
EULER = "semi_implicit_euler"

# Ranges of the platform, as properties of the engines: smallest mass, kg, and principal moment, kg m^2; smallest radius
# of gyration, m. MuJoCo's compiler rejects smaller masses and moments (mjMINVAL). Bullet sets the inverse of smaller
# ones and of smaller joint inertias to 0, so that nothing moves. The rate errors of MuJoCo's hinges, and of DART for a
# mass off the joint, are below 1e-6 from this radius on.
MUJOCO_RANGE = {"smallest": 1e-15, "slimmest": 1e-5}
BULLET_RANGE = {"smallest": 2.0**-52}
DART_RANGE = {"slimmest": 1e-5}

CABLES = "cdpr's own cable kernel (ideal), or rigid legs on universal and ball joints (ups)"


class ReferenceOptions(PluginOptions):
    """Options of the backend `reference`."""

    scheme: Literal["rk4", "semi_implicit_euler"] = Field(
        "rk4", description="classical Runge-Kutta, fourth order, or the first-order scheme of the engines"
    )

    def declares(self) -> dict[str, Any]:
        """Return the order and the scheme of the semi-implicit Euler scheme, if it is chosen."""
        return {"order": 1, "scheme": EULER} if self.scheme == EULER else {}


def _legs(cables: str) -> dict[str, Any]:
    """Return the properties of rigid legs, whose mass and joints change the plant, so that its order is unknown."""
    if cables != "ups":
        return {}
    return {
        "cables": "ups",
        "exits": (),
        "features": (),
        "order": 0,
        "scheme": "constrained",
        "works": {"rigid legs": ""},
    }


class LegOptions(PluginOptions):
    """Common options of rigid legs."""

    leg_mass: float = Field(
        1e-3, gt=0.0, le=MAX_MAGNITUDE, description="of each leg of `cables: ups`", json_schema_extra={"unit": "kg"}
    )
    slide_damping: float = Field(
        0.0,
        ge=0.0,
        le=MAX_MAGNITUDE,
        description="viscous, along each leg of `cables: ups`",
        json_schema_extra={"unit": "N s/m"},
    )
    hinge_damping: float = Field(
        0.0,
        ge=0.0,
        le=MAX_MAGNITUDE,
        description="viscous, of each hinge of `cables: ups`",
        json_schema_extra={"unit": "N m s"},
    )

    @model_validator(mode="after")
    def _of_legs(self) -> LegOptions:
        # A scenario with all defaults written out contains these, too.
        fields = LegOptions.model_fields
        given = [name for name in fields if getattr(self, name) != fields[name].default]
        if given and getattr(self, "cables", "ups") != "ups":
            raise ValueError(f"{', '.join(given)}: only rigid legs have that; add cables: ups")
        return self


class MujocoOptions(LegOptions):
    """Options of the backend `mujoco`."""

    cables: Literal["ideal", "native", "ups"] = Field(
        "ideal",
        description="cdpr's own cable kernel (ideal), MuJoCo's spatial tendons (native), or rigid legs (ups)",
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

    def declares(self) -> dict[str, Any]:
        """Return the properties of the chosen cables and integrator.

        MuJoCo's Runge-Kutta scheme has order four, but is not that of the reference, which conserves the momentum.
        """
        if self.cables != "native":
            return _legs(self.cables)
        return {"exits": (), "features": (), **({"order": 4, "scheme": ""} if self.integrator == "rk4" else {})}


class BulletOptions(LegOptions):
    """Options of the backend `bullet`."""

    cables: Literal["ideal", "ups"] = Field("ideal", description=CABLES)

    def declares(self) -> dict[str, Any]:
        """Return the properties of rigid legs, if they are chosen."""
        return _legs(self.cables)


class DartOptions(LegOptions):
    """Options of the backend `dart`."""

    cables: Literal["ideal", "ups"] = Field("ideal", description=CABLES)

    def declares(self) -> dict[str, Any]:
        """Return the properties of rigid legs, if they are chosen."""
        return _legs(self.cables)


class ExportOptions(PluginOptions):
    """Options of the robot's export by cdpr."""

    fmi: Literal[2, 3] = Field(3, description="version of the standard")


class FmuOptions(PluginOptions, FmuFile):
    """Options of the backend `fmu`."""

    file: FileName | None = Field(
        None, description="the FMU, relative to this file; default: export of the scenario's robot"
    )
    export: ExportOptions | None = Field(
        None, description="the scenario's robot, exported by cdpr and kept in the user's cache"
    )
    step: float | None = Field(
        None,
        gt=0.0,
        description="communication step, physics_step divided by an integer; default: physics_step",
        json_schema_extra={"unit": "s"},
    )

    @model_validator(mode="after")
    def _one_source(self) -> FmuOptions:
        if self.file is not None and self.export is not None:
            raise ValueError("file and export exclude each other")
        if self.file is None and self.sha256 is not None:
            raise ValueError("sha256 is that of a file; give file, too")
        return self

    def declares(self) -> dict[str, Any]:
        """Return no order, scheme and change of mass for an FMU from a file, because they are unknown."""
        return {"order": 0, "scheme": "", "load": False} if self.file is not None else {}


class RemoteOptions(PluginOptions, PeerOptions):
    """Options of the backend `remote`."""

    program: FileName | None = Field(
        None, description="a program to start, relative to this file; it talks through its standard input and output"
    )
    real_time: bool = Field(False, description="run each step in real time, and count late steps")

    def declares(self) -> dict[str, Any]:
        """Return whether runs are reproducible; a real-time plant is not."""
        return {"deterministic": not self.real_time}


@hookimpl
def cdpr_backends() -> list[PluginInfo]:
    """Return the built-in backends."""
    return [
        PluginInfo(
            name="reference",
            factory="cdpr_backends.reference_schemes:make",
            summary="cdpr's own integrator, Runge-Kutta of fourth order; `cdpr compare` compares other engines with it",
            properties={
                "order": 4,
                "snapshot": True,
                "load": True,
                "threads": True,
                **OUR_CABLES,
                "features": FEATURES,
                "scheme": "rk4",
                "schemes": ["rk4", EULER],
            },
            options=ReferenceOptions,
        ),
        PluginInfo(
            name="mujoco",
            factory="cdpr_backends.mujoco:make",
            summary="MuJoCo, semi-implicit Euler; `cables: native` also supports Runge-Kutta of fourth order",
            requires=("mujoco",),
            extra="cdpr[mujoco]",
            properties={
                "order": 1,
                "snapshot": True,
                "load": True,
                **OUR_CABLES,
                **MUJOCO_RANGE,
                "features": FEATURES,
                "scheme": EULER,
            },
            options=MujocoOptions,
        ),
        PluginInfo(
            name="bullet",
            factory="cdpr_backends.bullet:make",
            summary="PyBullet, semi-implicit Euler",
            requires=("pybullet",),
            extra="cdpr[bullet]",
            properties={
                "order": 1,
                "snapshot": True,
                "load": True,
                **OUR_CABLES,
                **BULLET_RANGE,
                "features": FEATURES,
                "scheme": EULER,
            },
            options=BulletOptions,
        ),
        PluginInfo(
            name="dart",
            factory="cdpr_backends.dart:make",
            summary="DART, semi-implicit Euler",
            requires=("dartpy",),
            extra="cdpr[dart]",
            properties={
                "order": 1,
                "snapshot": True,
                "load": True,
                **OUR_CABLES,
                **DART_RANGE,
                "features": FEATURES,
                "scheme": EULER,
            },
            options=DartOptions,
        ),
        PluginInfo(
            name=FMU,
            factory="cdpr_backends.fmu:FmuBackend",
            summary="an FMU of the plant (FMI 2.0 or 3.0, co-simulation): `file`, or by default one that cdpr exports",
            requires=("fmpy",),
            extra="cdpr[fmu]",
            properties={
                "order": 4,
                "snapshot": True,
                "load": True,
                **OUR_CABLES,
                "features": ("winch_commands",),
                "scheme": "rk4",
            },
            options=FmuOptions,
        ),
        PluginInfo(
            name=REMOTE,
            factory="cdpr_backends.remote:RemoteBackend",
            summary="plant in another process: the computer of a real robot, or another simulator (docs/remote.md)",
            properties={
                "order": 0,
                **OUR_CABLES,
                "features": ("winch_commands",),
                "scheme": "",
                "deterministic": True,
                "live": True,
            },
            options=RemoteOptions,
            columns=(Column("step_late", 1, "s", "delay of the last step by the wall clock; only in real time"),),
        ),
    ]
