"""Checks of the state that the controller sees: sensors that it does not use, and lengths of cables that stretch."""

from __future__ import annotations

from collections.abc import Iterator

from cdpr.cables import bends, chain_of
from cdpr.scenario.plausible.setup import Finding, Setup
from cdpr.sensing import Encoders, Pose

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
    subject = f"{', '.join(first)} and {last} are" if first else f"{last} is"
    yield (
        ("sensors", idle[0]),
        f"{subject} recorded only: the controller '{run.controller.type}' uses the true pose and twist; add an "
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
