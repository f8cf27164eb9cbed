"""Options of the built-in solvers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal

from pydantic import Field

from cdpr.base.errors import PluginError
from cdpr.base.fields import MAX_MAGNITUDE
from cdpr.model import Robot
from cdpr.plugins import PluginOptions

MOST_ITERATIONS = 10**9  # within the integers of all libraries

Weights = Annotated[tuple[Annotated[float, Field(gt=0.0, le=MAX_MAGNITUDE)], ...], Field(strict=False, min_length=1)]
Tensions = Annotated[
    tuple[Annotated[float, Field(ge=-MAX_MAGNITUDE, le=MAX_MAGNITUDE)], ...], Field(strict=False, min_length=1)
]


class QpOptions(PluginOptions):
    """Options of the solver `qp`."""

    about: Literal["zero", "middle", "previous", "given"] = Field(
        "zero",
        description="target of the tensions: zero, the middle of their limits, those of the step before, or "
        "`reference`",
    )
    reference: Tensions | None = Field(
        None, description="tensions for `about: given`, one per cable", json_schema_extra={"unit": "N"}
    )
    weights: Weights | Literal["stiffness"] | None = Field(
        None,
        description="weight of each cable's squared distance, one per cable, or `stiffness`: the compliance of each "
        "cable at the robot's home, so that the energy stored in the cables is least; all 1 by default",
    )
    change: Annotated[float, Field(gt=0.0, le=MAX_MAGNITUDE)] | None = Field(
        None,
        description="largest change of a tension from one control step to the next; not limited by default",
        json_schema_extra={"unit": "N"},
    )


class LpOptions(PluginOptions):
    """Options of the solver `lp`."""

    weights: Weights | None = Field(None, description="cost of each cable's tension, one per cable; all 1 by default")


class MaximinOptions(PluginOptions):
    """Options of the solver `maximin`."""

    norm: Literal["slack", "ball"] = Field(
        "slack",
        description="maximised quantity: the smallest distance of a tension from its limits (slack), or the radius "
        "of a ball in the null space within the limits (ball, Chebyshev centre)",
    )


class AnalyticCentreOptions(PluginOptions):
    """Options of the solver `analytic_centre`."""

    weights: Weights | None = Field(
        None, description="weight of each cable's distance from its limits, one per cable; all 1 by default"
    )


class ExactOptions(PluginOptions):
    """Options of the solver `exact`."""

    objective: Literal["min_norm", "one_norm"] = Field(
        "min_norm", description="minimised quantity: the 2-norm (min_norm) or the sum of the tensions (one_norm)"
    )

    def declares(self) -> dict[str, object]:
        """Return the properties of the least sum, which lies at a vertex and thus jumps."""
        return {"objective": "one_norm", "continuity": "jump"} if self.objective == "one_norm" else {}


class LibraryOptions(PluginOptions):
    """Common options of the solvers of libraries; the subclasses set their defaults."""

    tolerance: float = Field(
        1e-10,
        gt=0.0,
        le=1e-3,
        description="of limits and wrench, as a share of the largest limit; a millionth is too much for the stage",
    )
    iterations: int = Field(1000, ge=1, le=MOST_ITERATIONS, description="maximum number of iterations of the library")


class TimedOptions(LibraryOptions):
    """Options of a library with a time limit."""

    time: float | None = Field(
        None,
        gt=0.0,
        description="time limit; results then depend on the machine; default: none",
        json_schema_extra={"unit": "s"},
    )


class OsqpOptions(TimedOptions):
    """Options of the solver `osqp`."""

    iterations: int = Field(10_000, ge=1, le=MOST_ITERATIONS, description="maximum number of iterations of the library")


class DaqpOptions(LibraryOptions):
    """Options of the solver `daqp`."""

    tolerance: float = Field(1e-11, gt=0.0, le=1e-3, description="of the limits, as a share of the largest one")


class PiqpOptions(LibraryOptions):
    """Options of the solver `piqp`."""

    tolerance: float = Field(
        1e-12, gt=0.0, le=1e-3, description="of residuals and duality gap, as a share of the largest limit"
    )
    iterations: int = Field(
        250, ge=1, le=MOST_ITERATIONS, description="largest number of steps of the library, which is called twice"
    )


class ClarabelOptions(TimedOptions):
    """Options of the solver `clarabel`."""

    tolerance: float = Field(
        1e-13,
        gt=0.0,
        le=1e-3,
        description="of the gap, and ten times that of residuals, as a share of the largest limit",
    )
    iterations: int = Field(
        200, ge=1, le=MOST_ITERATIONS, description="largest number of steps of the library, which is called twice"
    )


class HighsOptions(TimedOptions):
    """Options of the solver `highs`."""

    tolerance: float = Field(
        1e-10, ge=1e-10, le=1e-3, description="of the limits and of optimality, as a share of the largest limit"
    )


class QpsolversOptions(PluginOptions):
    """Options of the solver `qpsolvers`."""

    name: str = Field("daqp", description="installed solver of the library qpsolvers")
    settings: dict[str, bool | int | float | str] = Field(
        default_factory=dict, description="settings of that solver, under its own names, such as eps_abs"
    )

    def declares(self) -> dict[str, object]:
        """Return the properties of the chosen solver.

        The active-set methods daqp and quadprog are exact. The others stop far from the optimum by default, or, like
        HiGHS, have no bound on their time.
        """
        if self.name in ("daqp", "quadprog"):
            return {}
        return {"exact": False, "coverage": "partial", "bounded_time": False}


class ImprovedClosedFormOptions(PluginOptions):
    """Options of the solver `improved_closed_form`."""

    rule: Literal["published", "scaled"] = Field(
        "published",
        description="selection of the next fixed cable: farthest beyond its limit in N (published), or relative to "
        "its motion in the remaining null space (scaled)",
    )


class DykstraOptions(PluginOptions):
    """Options of the solver `dykstra`."""

    iterations: int = Field(500, ge=1, le=MOST_ITERATIONS, description="maximum number of pairs of projections")
    tolerance: float = Field(
        1e-12,
        gt=0.0,
        le=1e-9,
        description="tolerance of the limits, as a share of the largest limit",
    )


class PNormOptions(PluginOptions):
    """Options of the solver `p_norm`."""

    p: int = Field(4, ge=2, le=64, multiple_of=2, description="the exponent, an even number")


def per_cable(robot: Robot, name: str, values: Sequence[float] | None) -> list[float]:
    """Return one value per cable, 1 by default; raise PluginError if there are more or fewer."""
    if values is None:
        return [1.0] * robot.m
    if len(values) != robot.m:
        wanted = f"one number per cable, {robot.m} for robot '{robot.name}'"
        raise PluginError(f"{name}: expected {wanted}, got {len(values)}")
    return list(values)
