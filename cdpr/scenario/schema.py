"""Sections of a scenario file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import AfterValidator, Field, PrivateAttr

from cdpr.base.defaults import BACKEND, CONTROLLER, ESTIMATOR, SOLVER
from cdpr.base.fields import HOME, Name, Position, Positive, Section, Vector3, tab, unit
from cdpr.base.needs import EVERYWHERE, UNCONCERNED, Needs, left_out, no, of_control, of_estimator, of_run
from cdpr.scenario.actuator_schema import Actuators
from cdpr.scenario.appearance import ObstacleSection
from cdpr.scenario.drives_schema import Drives
from cdpr.scenario.events import MAX_EVENTS, AnyEvent
from cdpr.scenario.initial import Initial
from cdpr.scenario.motions import AnyMotion
from cdpr.scenario.motions.hold import Hold
from cdpr.scenario.orientation import Orientation
from cdpr.scenario.robot_schema import DofName, RobotSection, in_order
from cdpr.sensing import MAX_SENSORS, AnySensor

MAX_SEED = 2**63 - 1

NO_CONTACT = no("exported plants have no contact")
NOT_EXPORTED = left_out("not exported")


class World(Section):
    """Surroundings of the robot."""

    needs: ClassVar[Mapping[str, Needs]] = {
        "gravity": Needs(urdf=left_out("URDF has no gravity")),
        "contact": replace(
            of_run(
                plant_fmu=NO_CONTACT,
                controller_fmu=NO_CONTACT,
                mjcf=NOT_EXPORTED,
                sdf=NOT_EXPORTED,
                urdf=NOT_EXPORTED,
            ),
            backend={"surroundings": "obstacles"},
        ),
    }

    gravity: Vector3 = Field(
        (0.0, 0.0, -9.81),
        description="acceleration of gravity, world axes, z up",
        json_schema_extra=unit("m/s^2"),
    )
    obstacles: tuple[ObstacleSection, ...] = Field(
        (),
        description="obstacles of the cables; for workspaces and clearances, without effect on the motion unless "
        "`contact` is set",
    )
    contact: bool = Field(
        False,
        description="the platform touches the obstacles with its shape; only on backends that declare it, which those "
        "of cdpr do not yet",
    )


class Simulation(Section):
    """Physics backend and time steps."""

    needs: ClassVar[Mapping[str, Needs]] = {
        **dict.fromkeys(("backend", "duration", "seed", "ends_early"), of_run()),
        "control_step": of_control(),
        "physics_step": Needs(native=UNCONCERNED, urdf=UNCONCERNED),
    }

    backend: str = Field(BACKEND, description="physics backend, any installed one")
    duration: Positive = Field(
        description="simulated time, an integer multiple of control_step", json_schema_extra=unit("s")
    )
    control_step: Positive = Field(
        0.001, description="time between two calls of the controller", json_schema_extra=unit("s")
    )
    physics_step: Positive = Field(
        default_factory=lambda data: data["control_step"],
        description="time step of the engine: control_step divided by an integer; default: control_step",
        json_schema_extra=unit("s"),
    )
    seed: int = Field(0, ge=0, le=MAX_SEED, description="seed of everything random")
    ends_early: bool | None = Field(
        None,
        description="true if the run ends before its motion or events on purpose, as in a saved session: no warning",
    )

    @property
    def steps(self) -> int:
        """Number of control steps."""
        return round(self.duration / self.control_step)

    @property
    def substeps(self) -> int:
        """Number of physics steps per control step."""
        return round(self.control_step / self.physics_step)


class Log(Section):
    """Logging of a run."""

    needs: ClassVar[Needs] = of_run()

    step: Positive = Field(
        description="time between two recorded samples, an integer multiple of control_step; the first and last "
        "sample are always recorded; summary and events use all samples",
        json_schema_extra=unit("s"),
    )


class PluginSection(Section):
    """Section with the options of a plugin next to its own keys; those of a scenario's section are kept."""

    _options: dict[str, Any] = PrivateAttr(default_factory=dict)

    def with_options(self, options: dict[str, Any]) -> Self:
        """Return a copy with these options, as they were given."""
        section = self.model_copy()
        section._options = options
        return section

    def to_dict(self) -> dict[str, Any]:
        """Return the given values and options as plain data, with the keys of a file."""
        return self._options | super().to_dict()


class ControllerSection(PluginSection):
    """Controller; its options are next to `type` and validated by the plugin's model."""

    needs: ClassVar[Needs] = of_control()

    type: str = Field(CONTROLLER, description="controller, any installed one; its options are keys of this section")


class SolverSection(PluginSection):
    """Tension solver; its options are next to these keys and validated by the plugin's model."""

    needs: ClassVar[Needs] = of_control()

    type: str = Field(SOLVER, description="tension solver, any installed one; its options are keys of this section")
    infeasible: Literal["best_effort", "hold_tension", "stop"] = Field(
        "best_effort",
        description="reaction if no admissible tensions balance the wrench: apply the nearest balanced wrench, hold "
        "the previous tensions, or stop the run",
    )


class EstimatorStart(Section):
    """Pose at time 0 that an estimator assumes."""

    needs: ClassVar[Needs] = of_estimator()

    position: Position | None = Field(
        None, description="position of the platform's origin; default: the true one", json_schema_extra=unit("m")
    )
    orientation: Orientation | None = Field(None, description="attitude; default: the true one")


class EstimatorSection(PluginSection):
    """Estimator of the state; its options are next to these keys and validated by the plugin's model."""

    needs: ClassVar[Needs] = of_estimator()

    type: str = Field(ESTIMATOR, description="estimator, any installed one; its options are keys of this section")
    start: EstimatorStart | None = Field(
        None, description="pose at time 0 from which the estimate begins; default: the true one"
    )


TRUE_ROBOT = no("an exported controller always computes with the simulated robot")
OWN_WINCHES = no("an exported controller supports only the winches in the robot file")
NO_ACTUATORS = left_out("actuator FMUs are not exported")
UNCHECKED = left_out("an exported controller continues after limit violations")


class ScenarioSection(Section):
    """Scenario: one robot, one motion, one run."""

    needs: ClassVar[Mapping[str, Needs]] = {
        "name": EVERYWHERE,
        "believed": of_control(controller_fmu=TRUE_ROBOT, bare_controller_fmu=TRUE_ROBOT, native=TRUE_ROBOT),
        "controlled": of_control(),
        "limits": of_run(controller_fmu=UNCHECKED, bare_controller_fmu=UNCHECKED, native=UNCHECKED),
        "actuators": Needs(
            controller_fmu=OWN_WINCHES,
            bare_controller_fmu=OWN_WINCHES,
            native=OWN_WINCHES,
            threads=no("an actuator FMU needs Python in each step"),
            plant_fmu=NO_ACTUATORS,
            mjcf=NO_ACTUATORS,
            sdf=NO_ACTUATORS,
            urdf=NO_ACTUATORS,
        ),
        "backend_options": of_run(),
    }

    name: Name = Field(
        "scenario", description="name of the scenario; default: the file's name", json_schema_extra=tab("simulation")
    )
    robot: RobotSection = Field(
        description="robot file, relative to this file, or the robot itself", json_schema_extra=tab("robot")
    )
    believed: RobotSection | None = Field(
        None,
        description="nominal model: the robot data that controller, tension solver and estimator use; default: the "
        "same as `robot`. Give only the keys and the cables that differ, each cable with its name. `nominal` is "
        "another name of this key",
        json_schema_extra=tab("robot", 1),
    )
    world: World = Field(
        World.model_construct(), description="gravity and obstacles", json_schema_extra=tab("simulation", 1)
    )
    simulation: Simulation = Field(description="backend, duration and time steps", json_schema_extra=tab("simulation"))
    initial: Initial = Field(
        description="state of the platform at time 0; default: at rest at the robot's home; required "
        "if the robot has no home",
        json_schema_extra=tab("motion") | {HOME: True},
    )
    trajectory: AnyMotion = Field(
        Hold.model_construct({"type"}),
        description="the desired motion; default: hold the initial pose",
        json_schema_extra=tab("motion"),
    )
    controlled: Annotated[tuple[DofName, ...], AfterValidator(in_order)] | None = Field(
        None,
        description="directions in which the cables produce the controller's wrench; default: all of robot.dof. In the "
        "other directions, the wrench of the cables is arbitrary, and the platform can move",
        json_schema_extra=tab("control", 1),
    )
    controller: ControllerSection = Field(
        ControllerSection.model_construct(),
        description="the controller and its options",
        json_schema_extra=tab("control"),
    )
    solver: SolverSection = Field(
        SolverSection.model_construct(),
        description="the tension solver and its options",
        json_schema_extra=tab("control"),
    )
    limits: Literal["warn", "stop"] = Field(
        "warn",
        description="reaction to violated limits of length, speed and tension: `warn` reports the number of samples "
        "with violations, `stop` ends the run at the first violation",
        json_schema_extra=tab("control", 1),
    )
    actuators: Actuators | None = Field(
        None,
        description="FMU that simulates the winches, from commands to cable tensions; it replaces robot.cable.model",
        json_schema_extra=tab("control", 1),
    )
    drives: Drives | None = Field(
        None,
        description="imperfections of the drives of the winches: delay, resolution, limited rate and backlash of the "
        "commands; default: none",
        json_schema_extra=tab("control", 1),
    )
    sensors: list[AnySensor] = Field(
        [],
        max_length=MAX_SENSORS,
        description="sensors; default: none. Instead of the true values, the controller uses the first sensor of type "
        "`pose`, the first of type `twist` and, if no cable stretches, the first of type `encoders`",
        json_schema_extra=tab("control", 1),
    )
    estimator: EstimatorSection | None = Field(
        None,
        description="estimator, which computes the state of the platform from the sensors, for the controller and the "
        "tension solver; default: `none`. Without an estimator, they use the measured pose and twist if there are "
        "sensors of the types `pose` and `twist`, and the true state if both are missing. If only one is missing, the "
        "scenario is rejected",
        json_schema_extra=tab("control", 1),
    )
    events: list[AnyEvent] = Field(
        [],
        max_length=MAX_EVENTS,
        description="events during the run: pushes, faults, stops",
        json_schema_extra=tab("events"),
    )
    log: Log | None = Field(
        None, description="recorded samples of a run; default: all", json_schema_extra=tab("simulation", 1)
    )
    backend_options: dict[str, dict[str, Any]] = Field(
        {},
        description="options of each backend, under its name; a run uses those of its backend",
        json_schema_extra=tab("simulation", 1),
    )
