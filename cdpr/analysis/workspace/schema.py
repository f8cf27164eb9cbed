"""Schemas of the data in workspace files; readers validate it before use."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, model_validator

from cdpr.analysis.workspace.regions import MOST_NUMBERED

Finite = Annotated[float, Field(allow_inf_nan=False, strict=True)]
Positive = Annotated[Finite, Field(gt=0.0)]
Count = Annotated[int, Field(ge=1, le=MOST_NUMBERED, strict=True)]
Triple = tuple[Finite, Finite, Finite]
Quadruple = tuple[Finite, Finite, Finite, Finite]
Sextuple = tuple[Finite, Finite, Finite, Finite, Finite, Finite]
SHAPES = ("box", "sphere", "cylinder", "hull", "mesh")


class Read(BaseModel):
    """Base class: unknown keys are kept."""

    model_config = ConfigDict(extra="allow", frozen=True)


class ReadRequired(Read):
    """See `cdpr.analysis.workspace.required.Required`."""

    form: Literal["zonotope", "ellipsoid", "vertices"]
    vectors: list[Sextuple]
    accelerations: bool


class ReadObstacle(Read):
    """See `cdpr.model.shapes.Obstacle`; one of the shapes."""

    name: str
    position: Triple
    attitude: Quadruple
    box: tuple[Positive, Positive, Positive] | None = None
    sphere: Positive | None = None
    cylinder: tuple[Positive, Positive] | None = None
    hull: Annotated[list[Triple], Field(min_length=1)] | None = None
    mesh: tuple[Triple, Triple] | None = None

    @model_validator(mode="after")
    def _one_shape(self) -> ReadObstacle:
        if sum(getattr(self, shape) is not None for shape in SHAPES) != 1:
            raise ValueError(f"expected one of {', '.join(SHAPES)}")
        return self


class ReadQuestion(Read):
    """See `cdpr.analysis.workspace.question.Question`."""

    required: ReadRequired
    gravity: Triple
    length: Positive
    at_least: Finite | None
    obstacles: list[ReadObstacle]
    diameter: Finite | None
    axial_stiffness: Positive | None
    direction: Literal["x", "y", "z", "rx", "ry", "rz"] | None


class ReadSource(Read):
    """Files from which a workspace was computed, recorded by the command line."""

    file: str | None = None
    robot: str | None = None
    scenario: str | None = None
    changes: list[str] | dict[str, Any] = Field(default_factory=list)


class ReadAbout(Read):
    """See `cdpr.analysis.workspace.result.Workspace.about`."""

    kind: str
    robot: str
    question: ReadQuestion
    over: Literal["all", "any"] = "all"
    method: Literal["grid", "octree", "hull", "rays", "turns", "certify", "combined"]
    limited_by: dict[str, str]
    notes: list[str] = Field(default_factory=list)
    source: ReadSource = Field(default_factory=ReadSource)
    oracle: dict[str, Any] | None = None


class ReadRobot(Read):
    """Schema of the robot in workspace.json."""

    name: str


class ReadRegion(Read):
    """See `cdpr.analysis.workspace.regions.Region`."""

    lower: Triple
    upper: Triple
    cells: tuple[Count, Count, Count]
    orientations: Annotated[list[Quadruple], Field(min_length=1)]

    @model_validator(mode="after")
    def _has_extent(self) -> ReadRegion:
        if any(low > high for low, high in zip(self.lower, self.upper, strict=True)) or self.lower == self.upper:
            raise ValueError("lower must be below upper")
        if self.cells[0] * self.cells[1] * self.cells[2] > MOST_NUMBERED:
            raise ValueError(f"more than {MOST_NUMBERED} cells")
        return self


class ReadManifest(Read):
    """See `cdpr.analysis.workspace.chunks`: workspace.json of a folder."""

    name: str
    cases: Count
    digest: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]
    format: str
    kind: str
    region: ReadRegion
    question: ReadQuestion
    over: Literal["all", "any"]
    method: Literal["grid"]
    notes: list[str]
    chunk: Count
    versions: dict[str, str]
    robot: ReadRobot
    source: ReadSource

    @model_validator(mode="after")
    def _covers_all(self) -> ReadManifest:
        x, y, z = self.region.cells
        if self.cases != -(-x * y * z // self.chunk):
            raise ValueError(f"{self.cases} chunks of {self.chunk} cells do not fit {x} x {y} x {z} cells")
        return self


class ReadSummary(Read):
    """Schema of summary.json."""

    limited_by: dict[str, str]


ABOUT, MANIFEST, SUMMARY = TypeAdapter(ReadAbout), TypeAdapter(ReadManifest), TypeAdapter(ReadSummary)
