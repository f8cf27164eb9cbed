"""Options of a scenario for an FMU's signals."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

FMU = "fmu"  # kind of FMU backends, controllers and winches in scenarios and logs

Variables = str | tuple[str, ...]


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False, defer_build=True)


class Source(_Section):
    """Variables and format of one signal in the FMU."""

    variable: Variables = Field(
        description="an array, the common part of a family such as F[1], F[2], a pattern with {i} (from 1) or {i0} "
        "(from 0) for the number, or a list of names, one for each number of the signal"
    )
    unit: Variables | None = Field(
        None, description="unit of the FMU's values, such as mm/s, instead of the one that the FMU declares"
    )
    order: str | None = Field(
        None,
        description="of a quaternion: wxyz or xyzw; of Euler angles: the axes as in scipy, upper case moving (XYZ), "
        "lower case fixed",
    )
    factor: float = Field(1.0, description="the FMU's value times this is the signal; -1 turns a sign")


class Signals(_Section):
    """Variables of the FMU by signal; an omitted signal is found automatically if that is unambiguous.

    The value `none` excludes a signal. `euler` can replace `quaternion`.
    """

    inputs: dict[str, Variables | Source] = Field(default_factory=dict, description="inputs of the FMU")
    outputs: dict[str, Variables | Source] = Field(default_factory=dict, description="signals that the FMU gives")
    cable_order: tuple[int, ...] | None = Field(
        None, description="the FMU's number, from 1, of each cable of the robot in turn"
    )


Parameter = bool | int | float | str | Annotated[tuple[bool | int | float | str, ...], Field(strict=False)]


class FmuFile(_Section):
    """Options of an FMU in any role."""

    sha256: str | None = Field(
        None,
        pattern="^[0-9a-fA-F]{64}$",
        description="checksum of the file; given, the file must have it, and its native code is trusted to run",
    )
    isolation: Literal["process", "inproc"] | None = Field(
        None,
        description="run the FMU in a separate process, or in the process of cdpr, which is faster, but a crash of the "
        "FMU also ends cdpr; default: process, and inproc if there is no key `file`",
    )
    step_timeout: float = Field(
        5.0,
        gt=0.0,
        description="longest wall time of one control step in a separate process",
        json_schema_extra={"unit": "s"},
    )
    parameters: dict[str, Parameter] = Field(
        default_factory=dict,
        description="values of the FMU's parameters by name, in its units; whole arrays row by row, or elements such "
        "as inertia[1,1]",
    )
    from_robot: bool = Field(
        True, description="set the parameters that have the names of cdpr's own exports: mass, inertia, ..."
    )
    signals: Signals = Field(
        Signals.model_construct(),
        description="assignment of the FMU's variables to signals, where their names are ambiguous",
    )
