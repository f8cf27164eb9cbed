"""Steps of stepper drives in the loop: the lengths that they count, and the steps that they lose."""

from __future__ import annotations

from typing import Any

from cdpr.cables import has_steppers
from cdpr.cables.tables import chain_table
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.simulation.parts import Parts
from cdpr.simulation.sample import Sample
from cdpr.tension.operations import Operation


class Steppers:
    """Steps of the stepper drives of a loop; no operations if it has none.

    Attributes:
        counting: operations at a sample, after the winches were read: counted lengths and lost steps.
        issuing: operations after commands of lengths were written: whole steps, as rates for the plant.
    """

    def __init__(self, parts: Parts, present: Sample, brakes: Array, command: Array, drive: Array) -> None:
        self.counting: list[Operation] = []
        self.issuing: list[Operation] = []
        robot, view = parts.robot, present.view
        if not has_steppers(robot):
            return
        given: dict[str, Any] = {
            "chains": chain_table(robot),
            "unwound": view("unstretched_length"),
            "brakes": brakes,
            "counted": view("counted_length"),
            "issued": present.issued,
            "lost": view("lost_steps"),
        }
        count = bind("count_steps", **given, torque=view("motor_torque"))
        issue = bind("issue_steps", **given, command=command, drive=drive, period=parts.control_step)
        self.counting, self.issuing = ([Operation("distribution", do)] for do in (count, issue))
