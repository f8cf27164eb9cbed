"""Checks of a scenario, and the parts of its loop.

`build` makes all parts for a run; `faults` finds, without starting anything, all that would keep it from that. Both
do the same checks, so that `cdpr validate` and a run reject the same scenarios.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeVar, cast

import numpy as np

from cdpr.base.column import Column
from cdpr.base.errors import CdprError, PluginError
from cdpr.base.problems import Path, dotted, short_repr
from cdpr.cables import COMMANDED, commands_of, rubs, with_model
from cdpr.fmu.read.options import FmuFile
from cdpr.link.options import PeerOptions
from cdpr.mechanics.anchors import Anchors
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.plugins import Backend, Controller, Environment, TensionSolver
from cdpr.plugins.controller import OUTPUTS, Output, listed, stage_of_output
from cdpr.plugins.registry import Registered, Role
from cdpr.scenario import Scenario
from cdpr.scenario.needs import lacking, missing
from cdpr.simulation.attached_checks import check_known_mass, out_of_range
from cdpr.simulation.cameras import check_camera
from cdpr.simulation.columns import chosen_plugins, columns_of
from cdpr.simulation.controller_calls import period_of
from cdpr.simulation.estimation import check_estimator
from cdpr.simulation.loop_part import LoopPart
from cdpr.simulation.loop_parts import loop_parts
from cdpr.simulation.moving_anchors import moving_part
from cdpr.simulation.parts import Parts
from cdpr.simulation.resting_start import check_resting_start
from cdpr.simulation.settings import Settings
from cdpr.simulation.step_checks import Circumstances, check_step, empty_drum
from cdpr.simulation.works import works_of
from cdpr.trajectory import Trajectory

T = TypeVar("T")

# Options of controllers that start a program or run native code when created: only a run may do that.
STARTED = FmuFile, PeerOptions


@dataclass(frozen=True)
class Prepared:
    """Parts of a loop without its plant."""

    chosen: dict[Role, Registered]
    controlled_robot: Robot  # nominal robot of controller and solver
    trajectory: Trajectory
    columns: tuple[Column, ...]
    solver: TensionSolver
    controller: Controller
    output: Output


@dataclass(frozen=True)
class Fault:
    """Reason why a scenario cannot be built, and the path of the section that it concerns."""

    path: Path
    error: CdprError


def _prepare(scenario: Scenario, opened: ExitStack) -> Prepared:
    """Make controller and solver, which `opened` closes.

    Raises:
        CdprError: if the scenario cannot be built.
        PluginError: if a plugin is missing or broken.
    """
    found = _Checks(scenario, opened, start=True)
    parts = found.run()
    if found.faults:
        raise found.faults[0].error
    assert parts is not None
    return parts


def build(scenario: Scenario) -> Parts:
    """Make robot, trajectory, controller, solver and backend, the backend in the scenario's initial state.

    Raises:
        PluginError: if a plugin is missing, broken or cannot be created.
    """
    robot, nominal = scenario.robot, scenario.nominal
    simulation = scenario.simulation
    gravity = np.array(scenario.world.gravity)
    with ExitStack() as opened:  # close these if a later one fails
        parts = _prepare(scenario, opened)
        chosen, controller, solver = parts.chosen, parts.controller, parts.solver
        plant = robot if scenario.actuators is None else with_model(robot, COMMANDED)
        backend: Backend = chosen["backend"].make(
            plant, gravity, simulation.physics_step, scenario.backend_options(simulation.backend)
        )
        opened.callback(backend.close)
        if scenario.world.contact:
            backend.surround(Environment(obstacles=scenario.obstacles))
        if scenario.actuators is not None:
            from cdpr.simulation.actuators import actuated  # also enables the check for all modules that run FMUs

            backend = actuated(scenario, backend, chosen["backend"])
            opened.callback(backend.close)
        backend.reset(scenario.initial.state())
        loop = Parts(
            robot=robot,
            controlled_robot=parts.controlled_robot,
            nominal=nominal,
            planned=scenario.planned,
            trajectory=parts.trajectory,
            controller=controller,
            solver=solver,
            solver_name=scenario.solver.type,
            respects_bounds=bool(chosen["solver"].info.properties.get("respects_bounds", True)),
            policy=scenario.solver.infeasible,
            limits=scenario.sections.limits,
            backend=backend,
            control_step=simulation.control_step,
            substeps=simulation.substeps,
            output=parts.output,
            events=scenario.events,
            obstacles=scenario.obstacles,
            live=frozenset(role for role, entry in chosen.items() if entry.info.properties.get("live", False)),
            columns=parts.columns,
            more=loop_parts(scenario),
            immediate=scenario.immediate_cables,
            settings=Settings(scenario.options(), {"controller": controller, "solver": solver}),
        )
        opened.pop_all()
    return loop


def faults(scenario: Scenario) -> Iterator[Fault]:
    """Yield all reasons why a scenario cannot be built, without starting anything."""
    with ExitStack() as opened:
        found = _Checks(scenario, opened, start=False)
        found.run()
    yield from found.faults


class _Checks:
    """Independent checks; without `start`, some parts are not made."""

    def __init__(self, scenario: Scenario, opened: ExitStack, *, start: bool) -> None:
        self._scenario, self._opened, self._start = scenario, opened, start
        self.faults: list[Fault] = []

    def run(self) -> Prepared | None:
        """Return the parts; None for a part with a fault, or one that was not to be made."""
        scenario = self._scenario
        trajectory = self._try(("events",) if scenario.events else ("trajectory",), lambda: scenario.desired)
        chosen = chosen_plugins(scenario)
        usable = {role: self._try(_TYPES[role], partial(self._usable, entry)) for role, entry in chosen.items()}
        columns = self._try((), lambda: columns_of(scenario))
        if columns is not None:
            self._try((), lambda: works_of(scenario))
        self._try(("initial", "equilibrium"), lambda: check_resting_start(scenario, chosen["controller"]))
        self._try(("robot", "winch"), lambda: check_drums(scenario))
        for i in range(len(scenario.sections.sensors)):
            self._try(("sensors", i), partial(check_camera, scenario, i))
        self._try(("simulation", "physics_step"), lambda: check_cables(scenario, chosen["backend"]))
        self.faults += [Fault(path, error) for path, error in out_of_range(scenario, chosen["backend"])]
        more = () if columns is None else loop_parts(scenario)
        self._try((), lambda: self._check_mover(more))
        for role in ("backend", "controller"):
            self._lacking(role, chosen[role], more)
        if scenario.actuators is not None:
            self._try(("actuators",), lambda: self._actuators(chosen["backend"]))
        nominal = scenario.nominal
        controlled = scenario.controlled_robot if nominal is None else replace(nominal, dof=scenario.controlled_dof)
        if scenario.estimator is not None and usable["estimator"]:
            self._try(("estimator",), lambda: check_estimator(scenario))
        solver = (
            self._try(("solver",), lambda: self._solver(chosen["solver"], controlled)) if usable["solver"] else None
        )
        controller = output = None
        if usable["controller"] and (self._start or not isinstance(scenario.controller_options, STARTED)):
            controller = self._try(("controller",), lambda: self._controller(chosen["controller"]))
        if controller is not None:
            created = controller
            commands = commands_of(scenario.robot)
            output = self._try(("controller",), lambda: output_of(chosen["controller"], created, commands))
            self._try(("events",), lambda: check_known_mass(scenario.events, created, chosen["solver"], scenario))
        if trajectory is None or columns is None or solver is None or controller is None or output is None:
            return None
        return Prepared(chosen, controlled, trajectory, columns, solver, controller, output)

    def _try(self, path: Path, do: Callable[[], T]) -> T | None:
        try:
            return do()
        except CdprError as error:
            self.faults.append(Fault(path, error))
            return None

    def _usable(self, entry: Registered) -> bool:
        """Reject a plugin with missing requirements; in a run also one that cannot be imported."""
        if self._start or entry.missing:
            entry.load()
        return True

    def _check_mover(self, parts: Sequence[LoopPart]) -> None:
        """Reject a robot and actuators that do not support the part of the loop that moves the anchors."""
        part = moving_part(parts)
        if part is not None:
            Anchors(self._scenario.robot)
            if self._scenario.actuators is not None:
                raise CdprError(f"actuators: do not support anchors that move, by {part.title}")

    def _lacking(self, role: Role, entry: Registered, parts: Sequence[LoopPart]) -> None:
        """Report the sections and parts of the loop that need features which a plugin does not declare."""
        scenario = self._scenario
        options = scenario.controller_options if role == "controller" else scenario.backend_options()
        properties = entry.properties(options)  # type: ignore[arg-type]
        lacks = list(lacking(scenario, role, properties))
        for path, feature in lacks:
            error = PluginError(
                f"{scenario.place(*path)}: {dotted(path)}: {role} '{entry.info.name}', with its options, does not "
                f"support {feature}: choose another {role}, or remove the section"
            )
            self.faults.append(Fault(path, error))
        reported = {feature for _, feature in lacks}
        for part in parts:
            required = {feature for needs in part.all_needs for feature in missing(needs, role, properties)}
            for feature in sorted(required - reported):  # others are reported by the section of the part
                error = PluginError(
                    f"{part.title}: {role} '{entry.info.name}', with its options, does not support {feature}: "
                    f"choose another {role}, or remove the part"
                )
                self.faults.append(Fault((), error))

    def _actuators(self, backend: Registered) -> None:
        from cdpr.simulation.actuators import check_actuators  # also enables the check for all modules that run FMUs

        if set(commands_of(self._scenario.robot)) != {"tension"}:
            raise CdprError("actuators: their commands are tensions: set robot.winch.type to torque, or remove them")
        if rubs(self._scenario.robot):
            raise CdprError("actuators: do not support friction on pulleys: remove it from robot.cable.exit, or them")
        check_actuators(self._scenario, backend)

    def _solver(self, entry: Registered, robot: Robot) -> TensionSolver:
        return cast("TensionSolver", entry.make(robot, self._scenario.solver_options))

    def _controller(self, entry: Registered) -> Controller:
        scenario = self._scenario
        robot, gravity = scenario.nominal or scenario.robot, np.array(scenario.world.gravity)
        step = scenario.simulation.control_step
        controller: Controller = entry.make(robot, gravity, step, scenario.controller_options)
        self._opened.callback(controller.close)
        if isinstance(controller, Controller):
            controller.use_sensors({sensor.title: sensor.nominal for sensor in scenario.sections.sensors})
        return controller


_TYPES: dict[Role, Path] = {
    "solver": ("solver", "type"),
    "controller": ("controller", "type"),
    "backend": ("simulation", "backend"),
    "estimator": ("estimator", "type"),
}


def output_of(entry: Registered, controller: Controller, commands: Sequence[str]) -> Output:
    """Return the stage of a controller's output for winches that take these `commands`.

    Raises:
        PluginError: if the controller declares an unknown output, one that a winch does not take, or an invalid period.
    """
    name, declared = entry.info.name, controller.output or entry.info.properties.get("output", "wrench")
    if not isinstance(declared, str) or declared not in OUTPUTS:
        raise PluginError(
            f"controller '{name}' declares the output {short_repr(declared)}; known are {', '.join(OUTPUTS)}"
        )
    stage = stage_of_output(declared, commands)
    if stage is None:
        raise PluginError(
            f"controller '{name}' outputs a {declared} for each cable, but the winches of this robot take "
            f"{listed(commands)}: choose a controller with output wrench or tension, or change robot.winch.type"
        )
    period_of(controller)
    return stage


def check_cables(scenario: Scenario, backend: Registered, state: Array | None = None) -> None:
    """Reject a backend without support for the robot's winches, and a step at which they are unstable.

    `state` (13,) contains the pose of the platform; default: the initial one.

    Raises:
        PluginError: if the backend does not support the cables.
        CdprError: if the step is too long.
    """
    robot, step = scenario.robot, scenario.simulation.physics_step
    declared = backend.properties(scenario.backend_options(backend.info.name))  # type: ignore[arg-type]
    if scenario.actuators is not None or scenario.immediate_cables:
        return
    known = declared.get("cable_models", (COMMANDED,))
    for i, cable in enumerate(robot.cables):
        model, key = cable.model or robot.cable_model, "robot.cable.model" if cable.model is None else _model_key(i)
        if not isinstance(known, tuple | list) or model not in known:
            raise PluginError(
                f"backend '{backend.info.name}' does not support {key} {model}: choose another backend, or "
                f"set {key} to {COMMANDED}"
            )
    pose = scenario.initial.state() if state is None else state
    about = Circumstances(robot, pose, scenario.gravity, f"backend '{backend.info.name}'")
    check_step(about, step, fourth_order=declared.get("scheme") == "rk4")


def check_drums(scenario: Scenario) -> None:
    """Reject an initial pose at which a drum is empty.

    Raises:
        CdprError: if a drum is empty.
    """
    if scenario.actuators is None and (text := empty_drum(scenario.robot, scenario.initial.state())):
        raise CdprError(text)


def _model_key(i: int) -> str:
    return f"robot.cables[{i}].model"
