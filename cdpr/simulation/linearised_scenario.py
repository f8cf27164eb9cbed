"""Scenario at rest at a pose whose loop is linearised, and reasons why a loop has no linearisation."""

from __future__ import annotations

from typing import Any

from cdpr.base.defaults import BACKEND
from cdpr.base.errors import CdprError
from cdpr.cables import chain_of
from cdpr.model.robot import Array
from cdpr.scenario import Scenario
from cdpr.simulation.build import STARTED
from cdpr.simulation.columns import chosen_plugins
from cdpr.simulation.loop_parts import loop_parts
from cdpr.simulation.sensors import seen_sensors
from cdpr.simulation.small_steps import small_steps

EULER, RK4 = "semi_implicit_euler", "rk4"


class NotLinearisedError(CdprError):
    """Reason why a loop has no linearisation."""


def unknown_part(scenario: Scenario) -> str:
    """Return the reason why a kind of part of a scenario has no linearisation at any pose; "" if there is none."""
    name = scenario.simulation.backend
    if scenario.actuators is not None:
        return "the states of actuator FMUs are not known"
    if isinstance(scenario.controller_options, STARTED):
        return f"the states of the controller '{scenario.controller.type}' are not known"
    if _scheme(scenario) not in (RK4, EULER) or isinstance(scenario.backend_options(name), STARTED):
        return f"the plant of the backend '{name}' is not known"
    if scenario.world.contact:
        return "contacts are not linear"
    robot = scenario.robot
    if reason := next((why for each in robot.cables if (why := chain_of(robot, each).span.nonlinear(each))), ""):
        return reason
    return ""


def _scheme(scenario: Scenario) -> object:
    chosen = chosen_plugins(scenario)["backend"]
    return chosen.properties(scenario.backend_options(scenario.simulation.backend)).get("scheme", RK4)  # type: ignore[arg-type]


def held_scenario(scenario: Scenario, pose: Array) -> Scenario:
    """Return the scenario at rest at a pose, on the reference."""
    nonlinear = (part.nonlinear for part in loop_parts(scenario) if part.nonlinear)
    if reason := unknown_part(scenario) or next(nonlinear, "") or _unknown_measurements(scenario):
        raise NotLinearisedError(reason)
    rest = {"position": pose[:3].tolist(), "orientation": {"quaternion": pose[3:].tolist()}}
    changes: dict[str, Any] = {"trajectory": {"type": "hold"}, "initial": rest, "simulation.backend": BACKEND}
    changes["backend_options"] = {BACKEND: {"scheme": _scheme(scenario)}}
    if scenario.events:
        changes["events"] = []
    if scenario.sections.sensors:
        changes["sensors"] = exact_sensors(scenario)
    return scenario.with_changes(changes | small_steps(scenario))


def _unknown_measurements(scenario: Scenario) -> str:
    """Return the reason why the measurements that a controller needs have no linearisation; "" if it needs none."""
    controller = chosen_plugins(scenario)["controller"]
    declared = controller.properties(scenario.controller_options).get("sensors", ())  # type: ignore[arg-type]
    kinds = ", ".join(declared) if isinstance(declared, tuple) else ""
    return f"the controller '{controller.info.name}' uses the sensor {kinds}, which is not linearised" if kinds else ""


def exact_sensors(scenario: Scenario) -> list[dict[str, Any]]:
    """Return the sensors of pose and twist that the controller uses, with gain and bias as their only errors."""
    found: list[dict[str, Any]] = []
    for sensor in seen_sensors(scenario).values():
        row: dict[str, Any] = {"type": sensor.type, "name": sensor.title}
        for quantity in sensor.quantities:
            errors = sensor.errors_of(quantity).to_dict()
            row[quantity.key] = {key: value for key, value in errors.items() if key in ("gain", "bias")}
        found.append(row)
    return found
