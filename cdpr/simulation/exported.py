"""A scenario's controller and solver as they go into an FMU."""

from __future__ import annotations

import numpy as np

from cdpr.errors import CdprError
from cdpr.fmu.export import Control
from cdpr.plugins.in_c import law_in_c, solve_in_c
from cdpr.plugins.registry import registry
from cdpr.scenario import Scenario
from cdpr.simulation.columns import chosen_plugins


def control_of(scenario: Scenario) -> Control:
    """Return them, with the desired motion's start.

    Raises CdprError where one has no C, or the scenario has what exported FMUs do not know: another belief, winches of
    another FMU, a controller that puts out commands; PluginError where a plugin is missing or broken.
    """
    if scenario.believed is not None:
        raise CdprError(
            f"scenario '{scenario.name}' has a believed robot: an exported controller knows only the true one"
        )
    if scenario.actuators is not None:
        raise CdprError(
            f"scenario '{scenario.name}' has actuators: an FMU with a controller has the robot's own winches"
        )
    known, chosen = registry(), chosen_plugins(scenario)
    step, gravity = scenario.simulation.control_step, np.array(scenario.world.gravity)
    controller = chosen["controller"].make(scenario.robot, gravity, step, scenario.controller_options)
    try:
        law = law_in_c(controller, scenario.controller.type, known)
        solver = chosen["solver"].make(scenario.controlled, scenario.solver_options)
        solve = solve_in_c(solver, scenario.solver.type, known)
        desired = np.zeros(19)
        scenario.desired.sampler(desired)(0.0)
        return Control(
            law=law,
            solve=solve,
            respects_bounds=bool(chosen["solver"].info.properties.get("respects_bounds", True)),
            numbers={name: np.array(values, dtype=float) for name, values in controller.numbers_in_c().items()},
            robot=scenario.controlled,
            gravity=gravity,
            control_step=step,
            policy=scenario.solver.infeasible,
            desired=desired,
        )
    finally:
        controller.close()
