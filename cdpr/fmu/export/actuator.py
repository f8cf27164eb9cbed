"""Winches of a robot without its platform, as a model that can be exported."""

from __future__ import annotations

from dataclasses import dataclass

from cdpr.base.errors import CdprError
from cdpr.cables import ACTUATED, immediate, rubs, takes_lengths
from cdpr.fmu.export.models import LENGTH, RATE, times, unilateral
from cdpr.fmu.export.parts import add_chains, winch_parameters
from cdpr.fmu.export.variables import Model, Variable, entrance
from cdpr.fmu.export.winch_variables import COMMANDS, chains_of, usual_tension, winch_outputs
from cdpr.mechanics.kinematics import lengths, make_state
from cdpr.mechanics.properties import home_pose
from cdpr.model import Robot
from cdpr.native.exported_pipeline import ExportedPipeline


@dataclass(frozen=True, eq=False)
class Actuator(Model):
    """Winches of a robot and its cables, without the platform: commands and lengths in, tensions out.

    Lengths and rates are constant during a step. A cable whose drum moves with it has no tension without the platform.
    """

    robot: Robot
    physics_step: float

    @property
    def name(self) -> str:
        """Return the name, after the robot's."""
        return f"{self.robot.name} winches"

    @property
    def description(self) -> str:
        """Return one line on the winches."""
        return f"winches and cables of the cable-driven parallel robot '{self.robot.name}', {self.robot.m} cables"

    def variables(self) -> list[Variable]:
        """Return all variables.

        Raises:
            CdprError: if winches alone determine no tension, or a parameter of a cable is missing.
        """
        m = self.robot.m
        _require_own_tensions(self.robot)
        home, _ = home_pose(self.robot)
        start = lengths(self.robot, make_state(home[:3], home[3:]))
        return [
            *times(self.physics_step),
            *winch_parameters(self.robot),
            entrance("command", m, "N", COMMANDS["tension"], terminal="winches", nominal=usual_tension(self.robot)),
            entrance("cable_length", m, "m", LENGTH, start, least=0.0, terminal="cables"),
            entrance("cable_rate", m, "m/s", RATE, terminal="cables"),
            *winch_outputs(self.robot, ("cable_length", "cable_rate")),
            unilateral(self.robot),
        ]

    def pipeline(self) -> ExportedPipeline:
        """Return the pipeline of winches and spans."""
        pipeline = ExportedPipeline()
        add_chains(pipeline, self.robot)
        return pipeline


def _require_own_tensions(robot: Robot) -> None:
    """Reject cables whose tension depends on the platform's acceleration, and a robot without any winch."""
    if takes_lengths(robot):
        raise CdprError(
            f"robot '{robot.name}' has winches that take lengths or rates: export winches and platform in one, without "
            "--only-winch, or set winch.type to torque"
        )
    if immediate(robot):
        raise CdprError(
            f"robot '{robot.name}' has ideal cables, so there is no winch to export: set cable.model to {ACTUATED} and "
            "give winch and stiffness, or export the robot without winches"
        )
    if rubs(robot):
        raise CdprError(
            f"robot '{robot.name}' has pulleys with friction: their wrap angles depend on the platform, which winches "
            "alone do not know: remove the friction, or export winches and platform in one, with --with-winch"
        )
    for cable, chain in zip(robot.cables, chains_of(robot), strict=True):
        if chain.span.bends:
            raise CdprError(
                f"cable '{cable.name}' has model {cable.model or robot.cable_model}: it sags, so its tension depends "
                "on the direction of its chord, and winches alone know only its length: set its model to "
                f"{ACTUATED}, or export winches and platform in one, with --with-winch"
            )
        if not (chain.stretches or chain.immediate):
            raise CdprError(
                f"cable '{cable.name}' has model {cable.model or robot.cable_model}: it does not stretch, so its drum "
                "moves with the platform, so winches alone do not determine its tension: set its model to "
                f"{ACTUATED}, or export winches and platform in one, with --with-winch"
            )
