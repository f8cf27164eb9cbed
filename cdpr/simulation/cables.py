"""Whether a backend can move a robot on winches, and with this step."""

from __future__ import annotations

from cdpr.errors import CdprError, PluginError
from cdpr.plugins.registry import Registered
from cdpr.scenario import Scenario


def check_cables(scenario: Scenario, backend: Registered) -> None:
    """Refuse a backend that would take winches for ideal cables, and a step with which they swing themselves up.

    Raises PluginError and CdprError.
    """
    robot, step = scenario.robot, scenario.simulation.physics_step
    if scenario.cable_model in ("ideal", "fmu"):
        return
    declared = backend.properties(scenario.backend_options(backend.info.name))  # type: ignore[arg-type]
    known = declared.get("cable_models", ("ideal",))
    if not isinstance(known, tuple | list) or robot.cable_model not in known:
        raise PluginError(
            f"backend '{backend.info.name}' does not know robot.cable.model {robot.cable_model}: choose another "
            "backend, or set robot.cable.model to ideal"
        )
    from cdpr.mechanics.stability import longest, oscillator, stable

    about = oscillator(robot, scenario.initial.state())
    scheme = about.runge_kutta if declared.get("scheme") == "rk4" else about.semi_implicit
    if not stable(scheme(step)):
        raise CdprError(
            f"simulation.physics_step {step:g} s is too long for these cables and winches, and backend "
            f"'{backend.info.name}' would diverge: at the initial pose they swing with up to {about.fastest:.4g} rad/s "
            f"(step * omega = {step * about.fastest:.3g}), and damping and friction ask for short steps too; it is "
            f"stable up to {longest(scheme, step):g} s"
        )
