"""Built-in controllers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import Field

from cdpr.base.column import CABLES, WORLD
from cdpr.base.fields import MAX_MAGNITUDE
from cdpr.fmu.read.options import FMU, FmuFile
from cdpr.link.options import REMOTE, PeerOptions
from cdpr.plugins import Column, FileName, PluginInfo, PluginOptions, hookimpl
from cdpr_controllers.estimators import cdpr_estimators as cdpr_estimators  # a hook of this module, too

Gain = Annotated[float, Field(ge=0.0, le=MAX_MAGNITUDE)]
Gains = Gain | Annotated[tuple[Gain, Gain, Gain, Gain, Gain, Gain], Field(strict=False)]
Pair = Gain | Annotated[tuple[Gain, Gain], Field(strict=False)]
Layer = Annotated[float, Field(gt=0.0, le=MAX_MAGNITUDE)]
PositivePair = Layer | Annotated[tuple[Layer, Layer], Field(strict=False)]
CableGains = Gain | Annotated[tuple[Gain, ...], Field(strict=False, min_length=1)]


class ComputedTorqueOptions(PluginOptions):
    """Options of the controller `computed_torque`."""

    kp: Gains = Field(
        100.0,
        description="proportional gain, one number or six: x, y, z, rx, ry, rz",
        json_schema_extra={"unit": "1/s^2"},
    )
    kd: Gains = Field(
        20.0,
        description="damping gain, one number or six: x, y, z, rx, ry, rz",
        json_schema_extra={"unit": "1/s"},
    )


class StaticOptions(PluginOptions):
    """Options of the controller `static`."""

    kp: Gains = Field(
        50.0,
        description="proportional gain, one number or six: x, y, z, rx, ry, rz",
        json_schema_extra={"unit": "1/s^2"},
    )
    kd: Gains = Field(
        50.0,
        description="damping gain, one number or six: x, y, z, rx, ry, rz",
        json_schema_extra={"unit": "1/s"},
    )


class PidOptions(PluginOptions):
    """Options of the controller `pid`."""

    kp: Gains = Field(
        100.0,
        description="proportional gain, one number or six: x, y, z, rx, ry, rz",
        json_schema_extra={"unit": "1/s^2"},
    )
    ki: Gains = Field(
        100.0,
        description="integral gain, one number or six: x, y, z, rx, ry, rz",
        json_schema_extra={"unit": "1/s^3"},
    )
    kd: Gains = Field(
        20.0,
        description="damping gain, one number or six: x, y, z, rx, ry, rz",
        json_schema_extra={"unit": "1/s"},
    )
    integral_limit: Gains = Field(
        10.0,
        description="largest acceleration of the integral term, one number or six: x, y, z, rx, ry, rz",
        json_schema_extra={"unit": "m/s^2 and rad/s^2"},
    )


class TensionFeedbackOptions(ComputedTorqueOptions):
    """Options of the controller `tension_feedback`."""

    sensor: str | None = Field(None, description="name of the sensor of tensions; default: the first one")
    gain: CableGains = Field(
        0.5, description="share of the tension error that is added at once, a number or one per cable"
    )
    integral_gain: CableGains = Field(
        50.0, description="integral gain, a number or one per cable", json_schema_extra={"unit": "1/s"}
    )
    integral_limit: CableGains = Field(
        500.0, description="largest tension of the integral, a number or one per cable", json_schema_extra={"unit": "N"}
    )


class SlidingModeOptions(PluginOptions):
    """Options of the controller `sliding_mode`; a pair has a value for the position and one for the attitude."""

    slope: Pair = Field(
        10.0,
        description="decay rate of the error on the surface, a number or two: position, attitude",
        json_schema_extra={"unit": "1/s"},
    )
    gain: Pair = Field(
        3.0,
        description="acceleration towards the surface, above that of all disturbances, a number or two",
        json_schema_extra={"unit": "m/s^2 and rad/s^2"},
    )
    layer: PositivePair = Field(
        0.06,
        description="thickness of the boundary layer about the surface, a number or two",
        json_schema_extra={"unit": "m/s and rad/s"},
    )


class AdaptiveOptions(PluginOptions):
    """Options of the controller `adaptive`."""

    slope: Gain = Field(10.0, description="decay rate of the error while s is 0", json_schema_extra={"unit": "1/s"})
    kd: Gain = Field(10.0, description="decay rate of s with the true mass", json_schema_extra={"unit": "1/s"})
    mass_gain: Gain = Field(
        0.25,
        description="adaptation of the mass, relative to the nominal mass; 0: none",
        json_schema_extra={"unit": "s^2/m^2"},
    )
    center_gain: Gain = Field(
        0.04, description="adaptation of the centre of mass; 0: none", json_schema_extra={"unit": "s^2"}
    )
    mass_min: float = Field(0.2, ge=0.01, le=1.0, description="lowest estimate, a multiple of the nominal mass")
    mass_max: float = Field(5.0, ge=1.0, le=100.0, description="highest estimate, a multiple of the nominal mass")
    center_max: float = Field(
        0.5,
        ge=0.0,
        le=MAX_MAGNITUDE,
        description="largest distance of the estimated centre of mass from the platform's origin along each axis",
        json_schema_extra={"unit": "m"},
    )


class CableLengthOptions(PluginOptions):
    """Options of the controller `cable_length`; the gains suit platforms of about 100 kg."""

    kp: CableGains = Field(
        10000.0, description="stiffness, a number or one per cable", json_schema_extra={"unit": "N/m"}
    )
    ki: CableGains = Field(
        5000.0, description="integral gain, a number or one per cable", json_schema_extra={"unit": "N/(m s)"}
    )
    kd: CableGains = Field(
        1500.0, description="damping, a number or one per cable", json_schema_extra={"unit": "N s/m"}
    )
    integral_limit: CableGains = Field(
        500.0, description="largest tension of the integral, a number or one per cable", json_schema_extra={"unit": "N"}
    )
    pretension: Gain = Field(
        0.0,
        description="reference tension of the feed-forward, which balances the weight",
        json_schema_extra={"unit": "N"},
    )
    forward_kinematics: bool = Field(
        True, description="balance the weight at the pose estimated from the lengths; false: at the desired pose"
    )


class InverseKinematicsOptions(PluginOptions):
    """Options of the controller `inverse_kinematics`."""

    pretension: Gain = Field(
        0.0,
        description="tension of the cables in the computation of their lengths; reference of the holding tensions",
        json_schema_extra={"unit": "N"},
    )
    flex_compensation: bool = Field(
        False, description="shorten the cables by the stretch under the tensions that hold the platform"
    )


class VisualServoOptions(PluginOptions):
    """Options of the controller `visual_servo`."""

    kp: Gains = Field(
        25.0,
        description="proportional gain, one number or six: x, y, z, rx, ry, rz",
        json_schema_extra={"unit": "1/s^2"},
    )
    kd: Gains = Field(
        10.0,
        description="damping gain, one number or six: x, y, z, rx, ry, rz",
        json_schema_extra={"unit": "1/s"},
    )
    interaction: Literal["desired", "current", "mean"] = Field(
        "mean", description="pose of the interaction matrix: the desired or the estimated one, or the mean of both"
    )
    smoothing: Annotated[float, Field(gt=0.0, le=10.0)] = Field(
        0.1,
        description="time constant of the filter that estimates error and velocity from the images",
        json_schema_extra={"unit": "s"},
    )


class FmuOptions(PluginOptions, FmuFile):
    """Options of the controller `fmu`."""

    file: FileName = Field(description="the FMU, relative to this file")


class RemoteOptions(PluginOptions, PeerOptions):
    """Options of the controller `remote`."""

    program: FileName | None = Field(
        None, description="a program to start, relative to this file; it talks through its standard input and output"
    )
    output: Literal["wrench", "command", "tension", "length", "rate", "winch"] = Field(
        "wrench",
        description="output: the wrench on the platform, or of each cable the tension (N; `command` means the same), "
        "the unwound length (m) or its rate (m/s), which all winches must take, or the quantity that its winch takes "
        "(`winch`)",
    )
    lockstep: bool = Field(
        True,
        description="wait for the answer to each step; false lets it run freely and takes its newest answer, so runs "
        "are not reproducible",
    )

    @property
    def quantity(self) -> str:
        """Output as controllers declare it."""
        return {"command": "tension", "winch": "command"}.get(self.output, self.output)

    def declares(self) -> Mapping[str, object]:
        """Return its output, and whether its runs are reproducible."""
        return {"output": self.quantity, "deterministic": self.lockstep}


@hookimpl
def cdpr_controllers() -> list[PluginInfo]:
    """Return the built-in controllers."""
    return [
        PluginInfo(
            name="computed_torque",
            factory="cdpr_controllers.computed_torque:ComputedTorque",
            summary="inverse dynamics of the platform with proportional and damping terms (thesis 6.3-6.5, corrected)",
            properties={"output": "wrench", "features": ("moving_anchors",)},
            options=ComputedTorqueOptions,
            changeable=("kp", "kd"),
        ),
        PluginInfo(
            name="static",
            factory="cdpr_controllers.static:Static",
            summary="gravity compensation with proportional and damping terms, without feed-forward",
            properties={"output": "wrench", "features": ("moving_anchors",)},
            options=StaticOptions,
            changeable=("kp", "kd"),
        ),
        PluginInfo(
            name="pid",
            factory="cdpr_controllers.pid:Pid",
            summary="gravity compensation with proportional, integral and damping terms; anti-windup",
            properties={"output": "wrench", "features": ("moving_anchors",)},
            options=PidOptions,
            changeable=("kp", "ki", "kd", "integral_limit"),
        ),
        PluginInfo(
            name="tension_feedback",
            factory="cdpr_controllers.tension_feedback:TensionFeedback",
            summary="computed torque; a PI controller per cable corrects its tension by a load cell",
            properties={"output": "wrench", "features": ("moving_anchors",), "sensors": ("tension",)},
            options=TensionFeedbackOptions,
            columns=(Column("distributed_tension", CABLES, "N", "Tensions that the inner loop follows"),),
            changeable=("kp", "kd", "gain", "integral_gain", "integral_limit"),
        ),
        PluginInfo(
            name="sliding_mode",
            factory="cdpr_controllers.sliding_mode:SlidingMode",
            summary="sliding mode with a boundary layer: bounded errors under bounded disturbances",
            properties={"output": "wrench", "features": ("moving_anchors",)},
            options=SlidingModeOptions,
            columns=(
                Column("sliding_velocity", 3, "m/s", "Sliding variable of the position", WORLD),
                Column("sliding_turn_rate", 3, "rad/s", "Sliding variable of the attitude", WORLD),
            ),
            changeable=("slope", "gain", "layer"),
        ),
        PluginInfo(
            name="adaptive",
            factory="cdpr_controllers.adaptive:Adaptive",
            summary="computed torque that estimates the mass and the centre of mass (Slotine and Li)",
            properties={"output": "wrench", "features": ("moving_anchors",)},
            options=AdaptiveOptions,
            columns=(
                Column("estimated_mass", 1, "kg", "Mass that the controller uses"),
                Column("estimated_center", 3, "m", "Centre of mass that the controller uses", "platform axes"),
            ),
            changeable=("slope", "kd", "mass_gain", "center_gain"),
        ),
        PluginInfo(
            name="cable_length",
            factory="cdpr_controllers.cable_length:CableLength",
            summary="PID control of each cable length, plus tensions that hold the platform; estimates the pose",
            properties={"output": "tension", "state": False},
            options=CableLengthOptions,
            changeable=("kp", "ki", "kd", "integral_limit"),
        ),
        PluginInfo(
            name="inverse_kinematics",
            factory="cdpr_controllers.inverse_kinematics:InverseKinematics",
            summary="unwound lengths or rates of the cables for the desired pose, without feedback; flex compensation",
            properties={"output": "command", "feedback": False},
            options=InverseKinematicsOptions,
        ),
        PluginInfo(
            name="visual_servo",
            factory="cdpr_controllers.visual_servo:VisualServo",
            summary="image-based visual servoing on the markers in a camera's image, with computed torque",
            properties={"output": "wrench", "state": False, "sensors": ("markers",)},
            options=VisualServoOptions,
            columns=(
                Column("servo_error", 1, "px", "Root mean square distance of the markers from their desired pixels"),
                Column("servo_markers", 1, "", "Number of markers seen in the last image"),
                Column("servo_age", 1, "s", "Time since the last image from which the pose followed"),
            ),
            changeable=("kp", "kd"),
        ),
        PluginInfo(
            name=FMU,
            factory="cdpr_controllers.fmu:FmuController",
            summary="controller as an FMU (FMI 2.0 or 3.0, co-simulation); its output is a wrench or tensions",
            requires=("fmpy",),
            extra="cdpr[fmu]",
            properties={"output": "wrench or tension", "state": False},
            options=FmuOptions,
        ),
        PluginInfo(
            name=REMOTE,
            factory="cdpr_controllers.remote:RemoteController",
            summary="controller in another process; the run waits for each answer, or continues without it "
            "(docs/remote.md)",
            properties={"output": "wrench", "state": False, "deterministic": True, "live": True},
            options=RemoteOptions,
        ),
    ]
