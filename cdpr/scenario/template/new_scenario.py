"""New scenario for a robot: a slow move from its home with statically feasible ends."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cdpr.base import defaults
from cdpr.cables import TENSION, commands_of
from cdpr.model import DOF_NAMES, Robot, rotations
from cdpr.model.robot import Array
from cdpr.plugins.registry import Registry
from cdpr.scenario.motions.quintic import Quintic
from cdpr.scenario.schema import World
from cdpr.scenario.static_feasibility import holds

SHARE = 0.1  # relative to the frame's extent along each axis; half of it upwards
TURN = 10.0  # degrees, for a robot that only rotates
HALVINGS = 5
SHORTEST = 2.0  # s
GENTLE = 0.05  # highest acceleration, relative to gravity
PEAK = 10.0 / math.sqrt(3.0)  # acceleration of a quintic move of length 1 in time 1
REST = 1.0  # s after the move
ABOVE = 2.0  # pretension, relative to the lowest allowed tension: the motion changes tensions
DIGITS = 3  # decimals: millimetres for robots of at least a metre


def scenario_data(robot: Robot, section: str | dict[str, Any], plugins: Registry) -> dict[str, Any]:
    """Return the plain data of the scenario file; `section` is the value of its key `robot`."""
    from cdpr.mechanics.properties import home_pose  # expensive import: it compiles

    home, _ = home_pose(robot)
    data: dict[str, Any] = {"robot": section}
    move, length = _move(robot, home)
    duration = max(SHORTEST, math.ceil(math.sqrt(PEAK * length / (GENTLE * 9.81))))
    data["simulation"] = {"backend": defaults.BACKEND, "duration": duration + REST, "control_step": 0.001}
    if robot.home is None:
        data["initial"] = {"position": [round(float(part), _digits(robot)) + 0.0 for part in home[:3]]}
    if move:
        data["trajectory"] = {"type": Quintic.kind(), "duration": duration, "to": move}
    data["controller"] = controller_data(robot, plugins)
    data["solver"] = {"type": defaults.SOLVER}
    return data


def controller_data(robot: Robot | None, plugins: Registry) -> dict[str, Any]:
    """Return the section of the controller of a new scenario; without a robot, that of the default controller.

    Winches that hold lengths receive lengths, as wrenches act on the platform only as fast as the winches turn.
    """
    name, given = defaults.CONTROLLER, dict[str, object]()
    if robot is not None and TENSION not in commands_of(robot):
        name, given = defaults.LENGTH_CONTROLLER, {**defaults.LENGTH_OPTIONS}
        if robot.m > robot.n:  # with fewer cables, the weight determines the tensions
            given["pretension"] = ABOVE * float(robot.tension_min.max())
    options = plugins.get("controller", name).info.options(**given)
    return {"type": name, **options.model_dump(mode="json", by_alias=True)}


def _digits(robot: Robot) -> int:
    """Return the number of decimals of positions: more for robots smaller than a metre."""
    extent = float(np.ptp(robot.anchors[:, :3], axis=0).max())
    return DIGITS if extent >= 1.0 or extent == 0.0 else DIGITS - math.floor(math.log10(extent))


def _move(robot: Robot, home: Array) -> tuple[dict[str, Any], float]:
    """Return the target and its distance, m; an empty target if no nearby pose is statically feasible."""
    gravity = np.array(World().gravity)
    extent = np.ptp(robot.anchors[:, :3], axis=0)
    free = np.array([name in robot.dof for name in DOF_NAMES])
    way = SHARE * np.array([1.0, 1.0, 0.5]) * extent * free[:3]
    axis = next((DOF_NAMES[i] for i in (5, 4, 3) if free[i]), None)
    for halving in range(HALVINGS):
        to = np.round(home[:3] + way / 2.0**halving, _digits(robot))
        if free[:3].any():
            if holds(robot, to, home[3:], gravity):
                upright = home[3:].tolist()
                turned = {} if upright == [1.0, 0.0, 0.0, 0.0] else {"orientation": {"quaternion": upright}}
                return {"position": to.tolist(), **turned}, float(np.linalg.norm(to - home[:3]))
        elif axis is not None:
            angles = [TURN / 2.0**halving if name == axis else 0.0 for name in DOF_NAMES[3:]]
            turn = rotations.from_rpy(*np.radians(angles))
            if holds(robot, home[:3], turn, gravity):
                return {"orientation": {"rpy_deg": angles}}, 0.0
    return {}, 0.0
