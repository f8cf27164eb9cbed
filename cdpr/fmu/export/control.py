"""Controller and tension distribution of an exported FMU, and their variables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from cdpr.fmu.export.variables import Variable, entrance, parameter
from cdpr.fmu.export.winch_variables import prescribed
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.entries import TABLE, headers_of, own_entries, table
from cdpr.native.exported_pipeline import ExportedPipeline
from cdpr.native.own import Own

# Desired motion: name, numbers, unit, text; together the 19 of `cdpr.model`.
DESIRED = (
    ("desired_position", 3, "m", "desired position of the platform's origin, world"),
    ("desired_quaternion", 4, "", "desired attitude, platform to world, w, x, y, z"),
    ("desired_velocity", 3, "m/s", "desired velocity of the origin, world axes"),
    ("desired_angular_velocity", 3, "rad/s", "desired angular velocity, world axes"),
    ("desired_acceleration", 3, "m/s2", "desired acceleration of the origin, world axes"),
    ("desired_angular_acceleration", 3, "rad/s2", "desired angular acceleration, world axes"),
)


@dataclass(frozen=True, eq=False)
class Control:
    """Controller and tension distribution of an exported FMU, evaluated once in each control step.

    Attributes:
        names: names of the controller and, unless it returns commands, of the solver.
        options: options of the controller that stay parameters: values by name.
        robot: nominal robot of controller and solver.
        pipeline: operations of a control step, with the arrays `state`, `desired`, `tension`, `report` and `lines`.
        own: headers of operations that are not in the kernel library, and their entries by name.
        desired: (19,) at the start.
    """

    names: Sequence[str]
    options: Mapping[str, Array]
    robot: Robot
    pipeline: ExportedPipeline
    own: Mapping[str, Own]
    control_step: float
    desired: Array

    def sources(self) -> dict[str, bytes]:
        """Return the C++ file that lists the operations, and the required headers of the kernel library."""
        headers, entries = own_entries(self.own)
        listed = table(self.pipeline.names, entries)
        found = headers_of(content.decode() for content in (listed, *headers.values()))
        return {TABLE: listed, **headers, **found}

    def copied(self) -> ExportedPipeline:
        """Return a copy of the pipeline, for more arrays and links."""
        pipeline = self.pipeline
        return ExportedPipeline([*pipeline.arrays], [*pipeline.links], [*pipeline.operations])

    def inputs(self) -> list[Variable]:
        """Return the inputs: the desired motion."""
        found, first = [], 0
        for name, size, unit, text in DESIRED:
            start = self.desired[first : first + size]
            found.append(entrance(name, size, unit, text, start, terminal="desired"))
            first += size
        return found

    def parameters(self) -> list[Variable]:
        """Return the parameters: the controller's options and its step."""
        own = [
            parameter(f"controller.{name}", values.shape, "", values, f"{name} of the controller {self.names[0]}")
            for name, values in self.options.items()
        ]
        text = "time between decisions"
        if prescribed(self.robot):  # their operations contain it
            return [*own, Variable("control_step", "constant", (), "s", (self.control_step,), text)]
        return [*own, parameter("control_step", (), "s", [self.control_step], text, False, least=0.0)]
