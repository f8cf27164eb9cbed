"""Check of a backend and a step against the winches of a robot."""

from __future__ import annotations

from cdpr.base.errors import CdprError, PluginError
from cdpr.cables import COMMANDED
from cdpr.plugins.registry import Registered
from cdpr.scenario import Scenario


def check_cables(scenario: Scenario, backend: Registered) -> None:
    """Reject a backend without support for the robot's winches or pulleys, and a step at which winches are unstable.

    Raises:
        PluginError: if the backend does not support the cables.
        CdprError: if the step is too long.
    """
    robot, step = scenario.robot, scenario.simulation.physics_step
    declared = backend.properties(scenario.backend_options(backend.info.name))  # type: ignore[arg-type]
    exits = declared.get("exits", ())
    known_exits = exits if isinstance(exits, tuple | list) else ()
    for cable in robot.cables:
        if cable.exit is not None and cable.exit.header and cable.exit.type not in known_exits:
            raise PluginError(
                f"backend '{backend.info.name}', with its options, requires exits at the anchors, and "
                f"cable '{cable.name}' has exit {cable.exit.type}: choose another backend, or its default cables, or "
                "leave the exit away"
            )
    if scenario.actuators is not None or scenario.ideal_cables:
        return
    known = declared.get("cable_models", (COMMANDED,))
    for i, cable in enumerate(robot.cables):
        model, key = cable.model or robot.cable_model, "robot.cable.model" if cable.model is None else _own(i)
        if not isinstance(known, tuple | list) or model not in known:
            raise PluginError(
                f"backend '{backend.info.name}' does not support {key} {model}: choose another backend, or "
                f"set {key} to {COMMANDED}"
            )
    from cdpr.mechanics.stability import longest, oscillator, stable

    about = oscillator(robot, scenario.initial.state())
    scheme = about.runge_kutta if declared.get("scheme") == "rk4" else about.semi_implicit
    if not stable(scheme(step)):
        raise CdprError(
            f"simulation.physics_step {step:g} s is too long for these cables and winches, and backend "
            f"'{backend.info.name}' would diverge: at the initial pose they swing with up to {about.fastest:.4g} rad/s "
            f"(step * omega = {step * about.fastest:.3g}), and damping and friction require short steps, too; it is "
            f"stable up to {longest(scheme, step):g} s"
        )


def _own(i: int) -> str:
    return f"robot.cables[{i}].model"
