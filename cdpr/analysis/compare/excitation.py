"""Effects that a run does not exercise, so that agreement does not cover them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import yaml

from cdpr.log.run import Run
from cdpr.model import rotations

TURN = 0.01  # rad; a wrench in body axes mistaken for one in world axes is off by this share


def unexcited(run: Run) -> list[str]:
    """Return the effects missing in a run, in words, without those of degrees of freedom that the robot lacks."""
    return list(_found(run))


def _found(run: Run) -> Iterator[str]:
    scenario = yaml.safe_load(run.header.scenario_yaml)
    robot = scenario["robot"]
    if any(name.startswith("r") for name in robot["dof"]):
        upright = np.tile([1.0, 0.0, 0.0, 0.0], (len(run.rows), 1))
        if float(np.linalg.norm(rotations.between(run.orientation, upright), axis=1).max()) < TURN:
            yield "a platform that is not upright (rotation)"
        if not any(robot["platform"]["center_of_mass"]) and not _loaded(run, scenario.get("events") or ()):
            yield "a centre of mass off the origin"
    if not run.external.any():
        yield "an external wrench"
    if not run.at_limit.any():
        yield "a tension at its limit"
    if not run.header.physics_step < 0.75 * run.header.control_step:
        yield "several physics steps in a control step (substeps)"


def _loaded(run: Run, events: Sequence[Mapping[str, Any]]) -> bool:
    """Return True if an event of the run attaches a body whose centre of mass is off the origin."""
    return any(any(event.get("center", ())) and event["time"] < run.span[1] for event in events)
