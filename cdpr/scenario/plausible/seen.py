"""Checks of what the controller sees: unused sensors, markers out of sight, and lengths of cables that stretch."""

from __future__ import annotations

from collections.abc import Iterator

from cdpr.cables import bends, chain_of
from cdpr.scenario.plausible.setup import Finding, Setup
from cdpr.sensing import Encoders, Markers, Pose

SHOWN = 4  # names of sensors in a message


def unseen_sensors(setup: Setup) -> Iterator[Finding]:
    """Yield sensors of the pose that nothing uses, while the controller uses the true pose.

    An `estimator` section of its own, also with `type: none`, states the intention.
    """
    run = setup.run
    if run is None or run.estimator is not None or any(isinstance(sensor, Pose) for sensor in run.sensors):
        return
    if not (setup.controller.get("state", True) and setup.controller.get("feedback", True)):
        return
    needed = setup.controller.get("sensors", ())
    idle = [i for i, each in enumerate(run.sensors) if each.locates and each.type not in needed]  # type: ignore[operator]
    if not idle:
        return
    names = [f"'{run.sensors[i].title}'" for i in idle]
    more = [f"{len(names) - SHOWN} more"] if len(names) > SHOWN else []
    *first, last = [*names[:SHOWN], *more]
    subject = f"{', '.join(first)} and {last} do" if first else f"{last} does"
    yield (
        ("sensors", idle[0]),
        f"{subject} not replace the true pose and twist, which the controller '{run.controller.type}' uses; add an "
        "estimator (estimator: {type: ekf}) or sensors of the types pose and twist, or write estimator: {type: none} "
        "if that is intended",
    )


def stretched_lengths(setup: Setup) -> Iterator[Finding]:
    """Yield an estimator that takes unwound lengths of stretching or sagging cables for distances."""
    run, declared = setup.run, setup.estimator.get("chord_lengths", False)
    if run is None or run.estimator is None or not declared or run.actuators is not None:
        return
    if isinstance(declared, tuple) and any(sensor.type in declared for sensor in run.sensors):
        return
    if not any(isinstance(sensor, Encoders) for sensor in run.sensors):
        return  # an error of the estimator
    robot = setup.robot
    sags = bends(robot)
    if not sags and not any(chain_of(robot, cable).stretches for cable in robot.cables):
        return
    remedy = "use sensors of the types pose and twist instead" if sags else "use the estimator ekf"
    yield (
        ("estimator", "type"),
        f"'{run.estimator.type}' assumes straight cables that do not stretch, but the encoders measure unwound "
        f"lengths: the error of the pose is about the {'stretch and sag' if sags else 'stretch'}; {remedy}",
    )


def markers_out_of_sight(setup: Setup) -> Iterator[Finding]:
    """Yield the camera of a controller that sees too few markers at the initial pose to determine the pose."""
    run, used = setup.run, setup.controller.get("sensors", ())
    if run is None or Markers.kind() not in used:  # type: ignore[operator]
        return
    found = next(((i, each) for i, each in enumerate(run.sensors) if isinstance(each, Markers)), None)
    if found is None:
        return  # an error of the controller
    i, camera = found
    needed, count = -(-setup.robot.n // 2), len(camera.markers)
    seen = camera.visible(setup.robot, run.initial.state(), setup.obstacles)
    if seen < needed <= count:  # fewer markers are an error of the controller
        yield (
            ("sensors", i),
            f"the camera '{camera.title}' sees {seen} of {count} markers at the initial pose, and the controller "
            f"'{run.controller.type}' needs {needed}: check position, attitude (z is the direction of view), focal and "
            "size, and what hides the markers",
        )
