"""Initial state of a run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, Self

import numpy as np
from pydantic import Field

from cdpr.base.fields import HOME, ZERO, Position, Section, Vector3, unit
from cdpr.base.needs import EVERYWHERE, UNCONCERNED, Needs, left_out
from cdpr.model.robot import Array
from cdpr.model.rotations import matrix
from cdpr.scenario.orientation import UPRIGHT, Orientation

AT_REST = left_out("the format has no initial velocity")
AS_GIVEN = left_out("the model starts at the given pose")


class Initial(Section):
    """State of the platform at time 0, world axes."""

    needs: ClassVar[Mapping[str, Needs]] = {
        "position": EVERYWHERE,
        "orientation": EVERYWHERE,
        **dict.fromkeys(("velocity", "angular_velocity"), Needs(sdf=AT_REST, urdf=AT_REST)),
        "equilibrium": Needs(
            bare_controller_fmu=UNCONCERNED,
            native=UNCONCERNED,
            mjcf=AS_GIVEN,
            sdf=AS_GIVEN,
            urdf=AS_GIVEN,
        ),
    }

    position: Position = Field(
        description="position of the platform's origin; default, with the attitude: the robot's home, if it has one",
        json_schema_extra=unit("m") | {HOME: True},
    )
    orientation: Orientation = Field(UPRIGHT, description="attitude; default: upright")
    velocity: Vector3 = Field(ZERO, description="velocity of the origin", json_schema_extra=unit("m/s"))
    angular_velocity: Vector3 = Field(ZERO, description="angular velocity", json_schema_extra=unit("rad/s"))
    equilibrium: bool = Field(
        False,
        description="the run starts where the platform comes to rest near this pose, with the first commands of the "
        "winches; the motion starts at this pose. Requires a controller without feedback",
    )

    def state(self) -> Array:
        """Return the given state (13,), in the layout of `cdpr.model`."""
        return np.concatenate([self.position, self.orientation.quaternion(), self.velocity, self.angular_velocity])

    def of_tool(self, tool: Array) -> Self:
        """Return the initial state of a tool at (3,), m, platform axes, instead of the origin."""
        reach = matrix(self.orientation.quaternion()) @ tool
        position = np.array(self.position) + reach
        velocity = np.array(self.velocity) + np.cross(self.angular_velocity, reach)
        return self.model_copy(update={"position": tuple(position.tolist()), "velocity": tuple(velocity.tolist())})
