"""Controller and tension distribution of an exported FMU, and their variables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from cdpr.base.column import Column
from cdpr.base.errors import CdprError
from cdpr.base.units import known_unit
from cdpr.fmu.export.variables import Variable, entrance, output, parameter
from cdpr.fmu.export.winch_variables import prescribed
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr.native.entries import TABLE, headers_of, own_entries, table
from cdpr.native.exported_pipeline import ExportedPipeline
from cdpr.native.own import Own

# Arrays of a pipeline that the plant writes for sensors: unwound lengths and rates of the winches, and the tensions at
# the platform and at the winch, (2, m) each.
WINCH_SENSORS = PAID_OUT, PULLS = "paid_out", "pulls"

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
        columns: outputs of sensors and estimator, which links copy from arrays.
        unused: names of the sensors that the export omits.
    """

    names: Sequence[str]
    options: Mapping[str, Array]
    robot: Robot
    pipeline: ExportedPipeline
    own: Mapping[str, Own]
    control_step: float
    desired: Array
    columns: Sequence[Column] = ()
    unused: Sequence[str] = ()

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

    @property
    def measures_winches(self) -> bool:
        """Return True if sensors measure the winches of the plant, in arrays that the plant writes."""
        return any(self.pipeline.find(name) is not None for name in WINCH_SENSORS)

    def outputs(self, others: Sequence[Variable]) -> list[Variable]:
        """Return the outputs of sensors and estimator, in the units of a run's columns.

        Raises:
            CdprError: if one has the name of another variable.
        """
        known = {each.name for each in others}
        for column in self.columns:
            if column.name in known:
                raise CdprError(
                    f"sensors: the column '{column.name}' has the name of another variable of the FMU: give its sensor "
                    "another name"
                )
        return [self._output(column) for column in self.columns]

    def _output(self, column: Column) -> Variable:
        text, unit = column.text[0].lower() + column.text[1:], _unit_of_fmu(column.unit)
        given = text, "" if unit else column.unit, column.frame and f"{column.frame} axes"
        about = f"{', '.join(filter(None, given))}, at the last control step; 0 before the first step"
        found = output(column.name, column.width or self.robot.m, unit, about)
        return replace(found, shape=()) if column.width == 1 else found

    def parameters(self) -> list[Variable]:
        """Return the parameters: the controller's options and its step."""
        own = [
            parameter(f"controller.{name}", values.shape, "", values, f"{name} of the controller {self.names[0]}")
            for name, values in self.options.items()
        ]
        text = "time between decisions"
        if prescribed(self.robot) or self.columns:  # operations of winches and sensors contain it
            return [*own, Variable("control_step", "constant", (), "s", (self.control_step,), text)]
        return [*own, parameter("control_step", (), "s", [self.control_step], text, False, least=0.0)]


def _unit_of_fmu(unit: str) -> str:
    """Return the unit of a column in the notation of FMI; "" for one without SI units, such as px."""
    return unit.replace("^", "").replace(" ", ".") if known_unit(unit) else ""
