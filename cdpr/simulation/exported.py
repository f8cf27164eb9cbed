"""Controller and tension distribution of a scenario for an FMU or a real-time program."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from typing import Any

import numpy as np

from cdpr.base.errors import CdprError, PluginError
from cdpr.cables import commands_of, takes_lengths
from cdpr.cables.tables import line_table
from cdpr.fmu.export import Control, Load
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.native.exported_pipeline import ANSWER, FINITE, IGNORED, Call, ExportedPipeline, Link, Translation
from cdpr.native.own import Own
from cdpr.plugins import Controller, TensionSolver
from cdpr.plugins.compiled import speaks_for
from cdpr.plugins.controller import Output
from cdpr.plugins.registry import registry
from cdpr.scenario import Scenario
from cdpr.simulation.build import output_of
from cdpr.simulation.columns import chosen_plugins
from cdpr.simulation.controller_calls import add_inner_loop, corrects, observes, period_of
from cdpr.simulation.exported_sensors import ExportedSensors
from cdpr.simulation.exported_start import exported_start
from cdpr.simulation.exported_winding import ExportedWinding
from cdpr.simulation.needs import require
from cdpr.tension.command import CommandStage
from cdpr.tension.current_sample import Cables, Present
from cdpr.tension.operations import Operation
from cdpr.tension.stage import StageSolver, TensionStage
from cdpr.tension.winch_command import WinchStage


def control_of(scenario: Scenario, use: str = "controller_fmu") -> Control:
    """Return the controller and the tension distribution of a scenario, with the initial desired motion.

    Args:
        scenario: scenario.
        use: one of `cdpr.base.needs.USES` with a controller; for "native", the pipeline's last operation writes the
            desired motion, for the calling code.

    Raises:
        ScenarioError: if an exported controller does not support a section of the scenario.
        CdprError: if controller or solver has no compiled operation.
        PluginError: if a plugin is missing or broken.
    """
    require(scenario, use)
    chosen = chosen_plugins(scenario)
    step, gravity = scenario.simulation.control_step, np.array(scenario.world.gravity)
    with ExitStack() as opened:
        controller = chosen["controller"].make(scenario.robot, gravity, step, scenario.controller_options)
        opened.callback(controller.close)
        if isinstance(controller, Controller):
            controller.use_sensors({sensor.title: sensor.nominal for sensor in scenario.sections.sensors})
        output = output_of(chosen["controller"], controller, commands_of(scenario.robot))
        _check_controller(scenario, controller, use)
        names, solver = [scenario.controller.type], None
        if output == "wrench":
            solver = chosen["solver"].make(scenario.controlled_robot, scenario.solver_options)
            names.append(scenario.solver.type)
        desired = np.zeros(19)
        scenario.desired.sampler(desired)(0.0)
        pipeline, own, sensors = _pipeline(scenario, controller, output, solver, use, opened)
        tunable = controller.tunable()
        return Control(
            names=names,
            options={name: np.array(each.value, dtype=float) for name, each in tunable.items()},
            robot=scenario.controlled_robot,
            pipeline=pipeline,
            own=own,
            control_step=step,
            desired=desired,
            columns=[each.column for each in sensors.outputs] if sensors else (),
            unused=sensors.unused if sensors else (),
        )


def _check_controller(scenario: Scenario, controller: Controller, use: str) -> None:
    """Raise CdprError if an export does not support the inputs or the period of a controller."""
    name, remedy = scenario.controller.type, "choose another (--set controller.type=NAME)"
    if period_of(controller) > 1:
        raise CdprError(
            f"the controller '{name}' has a period of several control steps, so it cannot be exported: {remedy}"
        )
    if use != "controller_fmu" and (observes(controller) or corrects(controller)):
        raise CdprError(
            f"the controller '{name}' uses further inputs (such as measurements) or corrects the distributed tensions, "
            f"so only an FMU of the plant with its controller can contain it: {remedy}"
        )


def loads_of(scenario: Scenario) -> tuple[Load, ...]:
    """Return the bodies that events attach to the platform."""
    step = scenario.simulation.control_step
    spans = [event.attachment(step) for event in scenario.events]
    return tuple(Load(span.first * step, span.end * step, span.body) for span in spans if span is not None)


def _pipeline(
    scenario: Scenario,
    controller: Controller,
    output: Output,
    solver: TensionSolver | None,
    use: str,
    opened: ExitStack,
) -> tuple[ExportedPipeline, Mapping[str, Own], ExportedSensors | None]:
    """Return the pipeline of a control step, the operations that are not in the kernel library, and the sensors."""
    robot = scenario.controlled_robot
    state, desired, lines = np.zeros(13), np.zeros(19), line_table(robot)
    live, cables = Present.of(robot.m), Cables.of(robot)
    sensors = ExportedSensors(scenario, state, live, cables) if use == "controller_fmu" else None
    if sensors:
        opened.callback(sensors.close)
    seen, measured = (sensors.seen, sensors.seen_cables) if sensors else (state, np.zeros((2, robot.m)))
    own: dict[str, Own] = {}
    controller.connect(live.report)
    controller.sense(measured)
    if sensors:
        sensors.show(controller)
    stage: TensionStage | CommandStage
    winding = None
    if takes_lengths(scenario.robot):
        _, lengths, start = exported_start(scenario)
        assert lengths is not None
        assert start is not None
        winding = ExportedWinding(scenario, lines, seen, measured, start, lengths)
    if winding is not None and output == "winch":
        given = {**winding.arguments, "start": winding.start}
        stage = WinchStage(robot, scenario.solver.infeasible, live, cables, given)
        out = stage.command
    elif solver is None:
        stage = CommandStage(robot, scenario.solver.infeasible, live, cables)
        out = stage.command
    else:
        stage, out = _stage(scenario, solver, live, cables), live.wrench
        if corrects(controller):
            add_inner_loop(controller, stage, np.zeros(robot.m))
            if not hasattr(stage.operations[-1].do, "words"):
                raise CdprError(
                    f"the controller '{scenario.controller.type}' corrects the distributed tensions in Python, so it "
                    "cannot be exported: choose another (--set controller.type=NAME)"
                )
    law = _compiled("controller", scenario.controller.type, controller.compiled, controller.control, seen, desired, out)
    calls = [
        Call(law, entry=_own_entry("controller", controller, law, own)),
        Call(bind("not_finite", values=out), FINITE),
        *_calls(stage.operations, solver, own),
    ]
    named = {"state": state, "desired": desired, "tension": live.tension, "report": live.report, "lines": lines}
    if winding is not None:
        named |= {"unwound": winding.unwound, "winch_command": winding.command, "drive": winding.drive}
        if output != "winch":
            calls.append(Call(winding.winds(live.tension)))
    if sensors:
        calls = [*sensors.calls(lines, winding.command if winding else None, calls), *calls]
        named |= sensors.named
    else:
        geometry = {"matrix": live.W, "length": measured[0], "rate": measured[1]}
        calls = [Call(bind("geometry", lines=lines, state=seen, **geometry)), *calls]
    if any(load.body.known for load in loads_of(scenario)):
        if "inertial" not in getattr(law, "given", {}):
            raise CdprError(
                f"the controller '{scenario.controller.type}' has no array `inertial`, so an exported FMU cannot "
                "change the mass that it knows: set known: false, or choose another (--set controller.type=NAME)"
            )
        named["inertial"] = law.given["inertial"]
    translation = Translation(named, shared=("lines",))
    pipeline = translation.translate(calls, [Call(scenario.desired.sampler(desired))] if use == "native" else [])
    for name, tunable in controller.tunable().items():
        if not tunable.array.flags.c_contiguous:
            raise PluginError(
                f"controller '{scenario.controller.type}': the array of the option '{name}' in `tunable` is not "
                "contiguous: expected a whole array, or successive elements of one"
            )
        array, place = translation.where(tunable.array)
        pipeline.links.append(
            Link(f"controller.{name}", 0, tunable.array.size, array, place, per_step=tunable.per_step)
        )
    for column, values in sensors.outputs if sensors else ():
        pipeline.links.append(Link(column.name, 0, values.size, *translation.where(values)))
    return pipeline, own, sensors


def _stage(scenario: Scenario, solver: TensionSolver, live: Present, cables: Cables) -> TensionStage:
    name = scenario.solver.type

    def compiled(*given: Array) -> Any:
        return _compiled("solver", name, solver.compiled, solver.solve, *given)

    respects = bool(registry().get("solver", name).info.properties.get("respects_bounds", True))
    stage = TensionStage(
        scenario.controlled_robot,
        StageSolver(solver.solve, name, respects, scenario.solver.infeasible, compiled),
        live,
        cables,
    )
    stage.refusal = "not reported by FMUs"  # the operation itself then replaces a rejected answer
    return stage


def _compiled(role: str, name: str, says: Callable[..., Any], does: Callable[..., object], *given: Array) -> Any:
    """Return a plugin's operation, bound to arrays."""
    bound = says(*given) if speaks_for(says, does) else None
    if bound is None or not hasattr(bound, "words"):
        raise CdprError(
            f"the {role} '{name}' has no compiled operation, so it cannot be exported: choose another "
            f"(--set {role}.type=NAME)"
        )
    return bound


def _own_entry(role: str, plugin: Controller | TensionSolver, bound: Any, own: dict[str, Own]) -> str:
    """Return the name of an operation that is not in the kernel library, and note its source; else ""."""
    if hasattr(bound, "given"):
        return ""
    if plugin.source is None:
        raise CdprError(
            f"the {role}'s operation was compiled elsewhere, so it cannot be exported: give the plugin the attribute "
            "`source`, the C++ of its operation (docs/plugin_kernels.md)"
        )
    own[f"own_{role}"] = plugin.source
    return f"own_{role}"


def _calls(operations: Sequence[Operation], solver: TensionSolver | None, own: dict[str, Own]) -> list[Call]:
    """Return the operations of a stage as calls."""
    calls = []
    for operation in operations:
        vital = IGNORED if operation.refused is None else ANSWER
        entry = (
            _own_entry("solver", solver, operation.do, own) if operation.name == "solver" and solver is not None else ""
        )
        calls.append(Call(operation.do, vital, operation.skip, operation.mend, entry))
    return calls
