"""Cameras of a scenario: what their images show, and checks."""

from __future__ import annotations

from typing import Any

from cdpr.base.errors import CdprError
from cdpr.model.shapes import Hull
from cdpr.scenario import Scenario
from cdpr.sensing.camera import Camera


def imaging_of(scenario: Scenario) -> dict[str, Any]:
    """Return the obstacles that cameras show as plain data for the header of a run; {} without cameras."""
    if not any(isinstance(sensor, Camera) for sensor in scenario.sections.sensors):
        return {}
    obstacles = [
        {"shape": each.shape.outline, "pose": [*each.position.tolist(), *each.attitude.tolist()]}
        for each in scenario.obstacles
    ]
    return {"obstacles": obstacles}


def check_camera(scenario: Scenario, i: int) -> None:
    """Raise an error if no images of sensor i can be made; nothing for other sensors.

    Raises:
        MissingPackageError: if its renderer is not installed.
        CdprError: if its period is not that of rows, or an obstacle cannot be drawn.
    """
    sensor = scenario.sections.sensors[i]
    if not isinstance(sensor, Camera):
        return
    from cdpr.sensing.rendering import check_renderer  # few scenarios need this import

    check_renderer(sensor.renderer)
    step = scenario.simulation.control_step
    every = round(sensor.period / step)
    if every % scenario.log_every:
        row = scenario.log_every * step
        raise CdprError(f"period: expected an integer multiple of log.step, {row:g} s, got {sensor.period:g} s")
    for each in scenario.obstacles:
        if isinstance(each.shape, Hull):
            raise CdprError(
                f"cameras do not draw meshes such as that of obstacle '{each.name}': use boxes, or remove it"
            )
