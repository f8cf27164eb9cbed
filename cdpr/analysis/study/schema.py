"""Sections of a study file."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field, model_validator

from cdpr.analysis.jobs.draw import MAX_COUNT, Random
from cdpr.base.fields import Number, Section, WholeOrNumber
from cdpr.scenario.schema import MAX_SEED

Keep = Literal["none", "failed", "all"]

SOURCES = ("values", "range", "linspace", "logspace", "random", "points", "zip")


class Range(Section):
    """Equal steps; whole numbers stay whole."""

    start: WholeOrNumber = Field(description="first value")
    stop: WholeOrNumber = Field(description="last value, included if a step reaches it")
    step: WholeOrNumber = Field(description="distance of two values")


class Spaced(Section):
    """Number of equally spaced values from start to stop, both included."""

    start: Number = Field(description="first value")
    stop: Number = Field(description="last value")
    count: int = Field(ge=2, le=MAX_COUNT, description="number of values")


class Axis(Section):
    """Axis of a study: one key or several, with values from one source."""

    name: str | None = Field(None, max_length=64, description="heading in tables and figures; default: the key")
    key: str | None = Field(None, description="a key of the scenario, as after --set")
    keys: list[str] | None = Field(None, min_length=1, description="keys that all take the same value")
    values: list[Any] | None = Field(None, min_length=1, description="the values")
    range: Range | None = Field(None, description="values in equal steps")
    linspace: Spaced | None = Field(None, description="values at equal distances")
    logspace: Spaced | None = Field(None, description="values at equal ratios")
    random: Random | None = Field(None, description="random values")
    points: dict[str, dict[str, Any]] | None = Field(
        None, min_length=1, description="names, each with the keys and values that it sets"
    )
    zip: list[Axis] | None = Field(None, min_length=1, description="axes of equal length, run through together")

    @model_validator(mode="after")
    def _one_source(self) -> Axis:
        given = [source for source in SOURCES if getattr(self, source) is not None]
        if len(given) != 1:
            found = f"got {' and '.join(given)}" if given else "got none"
            raise ValueError(f"expected one of {', '.join(SOURCES)}, {found}")
        named = [name for name in ("key", "keys") if getattr(self, name) is not None]
        if given[0] in ("points", "zip"):
            if named:
                raise ValueError(f"{given[0]} and {named[0]}cannot be combined: the keys are in the {given[0]}")
            if given[0] == "points" and self.name is None:
                raise ValueError("an axis of points needs a name")
            if given[0] == "zip" and self.name is not None:
                raise ValueError("zip cannot have a name: name the axes in it")
        elif len(named) != 1:
            raise ValueError("expected one of key and keys")
        return self

    @property
    def label(self) -> str:
        """Heading in tables and figures."""
        return self.name or self.key or (self.keys or [""])[0]

    def leaves(self) -> list[Axis]:
        """Return the axis itself, or the axes inside its `zip`."""
        return [self] if self.zip is None else [leaf for axis in self.zip for leaf in axis.leaves()]

    @property
    def targets(self) -> list[str]:
        """Keys that one value sets."""
        return self.keys or [self.key or ""]


class Block(Section):
    """Part of a study with its own axes."""

    name: str = Field(min_length=1, max_length=64, description="name, a column of the table")
    scenario: str | None = Field(None, description="scenario file instead of the study's, relative to this file")
    changes: dict[str, Any] = Field({}, description="keys and values, on top of the study's")
    axes: list[Axis] = Field([], description="multiplied with those of the study")


class StudyFile(Section):
    """Study: a scenario, and the axes along which it varies."""

    name: str | None = Field(None, max_length=64, description="name of the study; default: the file's name")
    scenario: str | None = Field(None, description="scenario file, relative to this file, or name of an example")
    changes: dict[str, Any] = Field({}, description="keys of the scenario and their values, in all cases")
    seed: int = Field(0, ge=0, le=MAX_SEED, description="seed of random values, and with its identity of each case")
    keep: Keep = Field(
        "none", description="cases that keep a run folder; failed: also those that end infeasible or diverged"
    )
    axes: list[Axis] = Field([], description="varied keys; the cases are the product of all axes")
    blocks: list[Block] = Field([], description="parts with axes of their own, run one after the other")
