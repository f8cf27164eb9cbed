"""Sections of a design's study file."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from cdpr.base.fields import NonNegative, Number, Position, Positive, Section, Vector3, unit
from cdpr.scenario.appearance import ObstacleSection
from cdpr.scenario.orientation import Orientation
from cdpr.scenario.schema import MAX_SEED

Search = Literal["differential_evolution", "nsga2", "cma", "random"]

EVALUATIONS = 1000
MAX_EVALUATIONS = 10_000_000
MAX_POPULATION = 1000  # selection compares all pairs of twice as many
MAX_CELLS = 2_000_000  # above this, one evaluation takes minutes
LABEL = r"^[A-Za-z][\w -]{0,39}$"

SOURCES = ("volume", "least", "mean", "extent", "key")
SETS = ("wrench_box", "wrench_ellipsoid", "acceleration_box", "acceleration_ellipsoid")
ASKED = (*SETS, "at_least", "length", "diameter", "axial_stiffness", "direction")

Six = tuple[NonNegative, NonNegative, NonNegative, NonNegative, NonNegative, NonNegative]
Cells = Annotated[int, Field(ge=1, le=MAX_CELLS)]
Label = Annotated[str, Field(pattern=LABEL)]


class Moved(Section):
    """A key that a variable sets, to `factor` times its value plus `offset`."""

    key: str = Field(description="a key of the robot file, as after --set")
    factor: Number = Field(1.0, description="-1 on the other side of a symmetric robot")
    offset: Number = Field(0.0, description="what is added")


class Variable(Section):
    """Variable of a design: one number that sets one key or several."""

    name: Label | None = Field(None, description="heading in tables and figures; default: the key")
    key: str | None = Field(None, description="a key of the robot file, as after --set")
    keys: list[Moved] | None = Field(None, min_length=1, description="keys that move together")
    bounds: tuple[Number, Number] = Field(description="lowest and highest value")

    @model_validator(mode="after")
    def _sound(self) -> Variable:
        if (self.key is None) == (self.keys is None):
            raise ValueError("expected one of key and keys")
        if self.keys is not None and self.name is None:
            raise ValueError("several keys need a name")
        if any(moved.factor == 0.0 for moved in self.keys or ()):
            raise ValueError("expected a factor other than 0")
        if not self.bounds[0] < self.bounds[1]:
            raise ValueError(f"bounds: the lowest value, {self.bounds[0]:g}, must be below {self.bounds[1]:g}")
        return self

    @property
    def label(self) -> str:
        """Heading in tables and figures."""
        return self.name or self.key or ""

    @property
    def moved(self) -> list[Moved]:
        """Keys that it sets."""
        return self.keys or [Moved(key=self.key or "")]


class FigureSection(Section):
    """Figure of a candidate: one source, and its requirements."""

    volume: str | None = Field(None, description="size of a workspace of this kind in the region")
    least: str | None = Field(None, description="least value of a kind of workspace over all poses")
    mean: str | None = Field(None, description="mean value of a kind of workspace over all poses")
    extent: Literal["x", "y", "z"] | None = Field(None, description="extent of the frame's anchors along an axis (m)")
    key: str | None = Field(None, description="a number of the robot file, by its key")
    wrench_box: Six | None = Field(None, description="half widths of wrenches beyond carrying the weight (N, N m)")
    wrench_ellipsoid: Six | None = Field(None, description="half axes of such an ellipsoid (N, N m)")
    acceleration_box: Six | None = Field(None, description="half widths of accelerations (m/s^2, rad/s^2)")
    acceleration_ellipsoid: Six | None = Field(None, description="half axes of such an ellipsoid (m/s^2, rad/s^2)")
    at_least: Number | None = Field(None, description="value from which on a cell counts as inside, of a volume")
    length: Positive | None = Field(None, description="length that divides moments", json_schema_extra=unit("m"))
    diameter: NonNegative | None = Field(None, description="of all cables", json_schema_extra=unit("m"))
    axial_stiffness: Positive | None = Field(None, description="E A of all cables", json_schema_extra=unit("N"))
    direction: str | None = Field(None, description="degree of freedom of the stiffness")

    @model_validator(mode="after")
    def _one_source(self) -> FigureSection:
        given = [source for source in SOURCES if getattr(self, source) is not None]
        if len(given) != 1:
            found = f"got {' and '.join(given)}" if given else "got none"
            raise ValueError(f"expected one of {', '.join(SOURCES)}, {found}")
        used = [part for part in ASKED if getattr(self, part) is not None]
        if used and given[0] in ("extent", "key"):
            raise ValueError(f"{given[0]} does not accept {used[0]}")
        if self.at_least is not None and self.volume is None:
            raise ValueError("at_least applies to a volume only: limit other figures by a constraint")
        sets = [part for part in SETS if getattr(self, part) is not None]
        if len(sets) > 1:
            raise ValueError(f"expected one required set, got {' and '.join(sets)}")
        return self

    @property
    def source(self) -> str:
        """Source of its value."""
        return next(source for source in SOURCES if getattr(self, source) is not None)

    @property
    def kind(self) -> str:
        """Kind of workspace that it evaluates; "" if none."""
        return self.volume or self.least or self.mean or ""


class Term(Section):
    """A part of a weighted sum: weight times the figure over its scale."""

    figure: str = Field(description="name of a figure")
    weight: Number = Field(1.0, description="weight of the figure in the sum")
    scale: Positive = Field(1.0, description="value that divides the figure, to make terms comparable")


class Goal(Section):
    """Figure, or weighted sum of several figures, to maximise or to minimise."""

    maximise: str | list[Term] | None = Field(None, description="name of a figure, or terms of a sum")
    minimise: str | list[Term] | None = Field(None, description="likewise")

    @model_validator(mode="after")
    def _one_way(self) -> Goal:
        if (self.maximise is None) == (self.minimise is None):
            raise ValueError("expected one of maximise and minimise")
        if self.maximise == [] or self.minimise == []:
            raise ValueError("a sum needs a term")
        return self

    @property
    def way(self) -> str:
        """Name of the key that is set."""
        return "maximise" if self.maximise is not None else "minimise"

    @property
    def terms(self) -> list[Term]:
        """Terms of the sum."""
        given = self.maximise if self.maximise is not None else self.minimise
        return given if isinstance(given, list) else [Term(figure=given or "")]

    @property
    def label(self) -> str:
        """Description in words."""
        return f"{self.way} {' + '.join(map(_of_term, self.terms))}".replace(" + -", " - ")


def _of_term(term: Term) -> str:
    weight = "" if term.weight == 1.0 else f"{term.weight:g} "
    return f"{weight}{term.figure}" + ("" if term.scale == 1.0 else f" / {term.scale:g}")


class Limit(Section):
    """A constraint: limits of a figure."""

    figure: str = Field(description="name of a figure")
    at_least: Number | None = Field(None, description="smallest allowed value")
    at_most: Number | None = Field(None, description="largest allowed value")

    @model_validator(mode="after")
    def _bounded(self) -> Limit:
        if self.at_least is None and self.at_most is None:
            raise ValueError("expected at_least, at_most or both")
        if self.at_least is not None and self.at_most is not None and self.at_least > self.at_most:
            raise ValueError(f"at_least, {self.at_least:g}, must not be above at_most, {self.at_most:g}")
        return self

    @property
    def label(self) -> str:
        """Description in words."""
        low = "" if self.at_least is None else f"{self.at_least:g} <= "
        return f"{low}{self.figure}" + ("" if self.at_most is None else f" <= {self.at_most:g}")


class RegionSection(Section):
    """A box of positions, divided into cells that are evaluated at their centres."""

    lower: Position | None = Field(None, description="lowest corner, world; default: that of the robot's frame")
    upper: Position | None = Field(None, description="highest corner, likewise")
    cells: Cells | tuple[Cells, Cells, Cells] = Field(10, description="along the longest side, or along x, y, z")
    orientations: list[Orientation] | None = Field(
        None, min_length=1, max_length=1000, description="required attitudes; default: the home's"
    )


class PoseSection(Section):
    """A pose of the platform's origin."""

    position: Position = Field(description="position", json_schema_extra=unit("m"))
    orientation: Orientation | None = Field(None, description="attitude; default: the home's")


class OptimizerSection(Section):
    """Optimiser of the candidates."""

    type: Search | None = Field(None, description="differential_evolution, or nsga2 for several goals; cma; random")
    evaluations: int = Field(EVALUATIONS, ge=1, le=MAX_EVALUATIONS, description="number of candidates to evaluate")
    seed: int = Field(0, ge=0, le=MAX_SEED, description="seed of all random numbers")
    population: int | None = Field(None, ge=5, le=MAX_POPULATION, description="number of candidates in a generation")


class DesignFile(Section):
    """A design: a robot, what of it is varied, and what for."""

    name: str | None = Field(None, max_length=64, description="name of the design; default: the file's name")
    robot: str = Field(min_length=1, description="robot file, relative to this file, or name of an example")
    gravity: Vector3 = Field((0.0, 0.0, -9.81), description="gravity, world", json_schema_extra=unit("m/s^2"))
    region: RegionSection | None = Field(None, description="positions at which figures are evaluated")
    poses: list[PoseSection] | None = Field(
        None, min_length=1, description="poses at which figures are evaluated, instead of a region"
    )
    obstacles: list[ObstacleSection] = Field([], description="obstacles that the cables must not touch")
    vary: list[Variable] = Field(min_length=1, max_length=200, description="what is varied")
    figures: dict[Label, FigureSection] = Field(min_length=1, max_length=50, description="named figures of the robot")
    goal: Goal | None = Field(None, description="figure or weighted sum to maximise or minimise")
    goals: list[Goal] | None = Field(None, min_length=1, max_length=5, description="several goals, for a Pareto front")
    constraints: list[Limit] = Field([], description="limits of figures")
    optimizer: OptimizerSection = Field(OptimizerSection(), description="optimizer that generates candidates")

    @model_validator(mode="after")
    def _sound(self) -> DesignFile:
        if (self.region is None) == (self.poses is None):
            raise ValueError("expected one of region and poses")
        if (self.goal is None) == (self.goals is None):
            raise ValueError("expected one of goal and goals")
        return self

    @property
    def wanted(self) -> list[Goal]:
        """All goals."""
        return self.goals or ([self.goal] if self.goal is not None else [])
