"""Reproducible random values for files and calls, independent of the machine."""

from __future__ import annotations

import math
import random
from statistics import NormalDist

from pydantic import Field, model_validator

from cdpr.base.fields import Number, Section
from cdpr.scenario.schema import MAX_SEED

MAX_COUNT = 100_000


class Random(Section):
    """Number of random values, the same for the same seed; a larger count begins with the values of a smaller one."""

    uniform: tuple[Number, Number] | None = Field(None, description="lowest and highest")
    normal: tuple[Number, Number] | None = Field(None, description="mean and standard deviation")
    log_uniform: tuple[Number, Number] | None = Field(None, description="lowest and highest, of uniform logarithm")
    count: int = Field(ge=1, le=MAX_COUNT, description="number of values")
    seed: int | None = Field(None, ge=0, le=MAX_SEED, description="default: from the study's and the axis's name")

    @model_validator(mode="after")
    def _one_distribution(self) -> Random:
        given = [name for name in ("uniform", "normal", "log_uniform") if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError("expected one of uniform, normal and log_uniform")
        first, second = getattr(self, given[0])
        if given[0] == "normal":
            if second <= 0:
                raise ValueError(f"the standard deviation must be greater than 0, got {second:g}")
        elif first >= second:
            raise ValueError(f"the lowest value, {first:g}, must be below the highest, {second:g}")
        elif given[0] == "log_uniform" and first <= 0:
            raise ValueError(f"a logarithm needs values greater than 0, got {first:g}")
        elif given[0] == "log_uniform" and second / first == math.inf:
            raise ValueError(f"{first:g} and {second:g} are too far apart")
        return self


def drawn(given: Random, seed: str) -> list[float]:
    """Return the values; `seed` applies if they have no seed of their own."""
    # Python guarantees the same sequence for a seed in all versions; numpy does not.
    source = random.Random(seed if given.seed is None else str(given.seed))
    shares = [max(source.random(), 2.0**-54) for _ in range(given.count)]
    if given.uniform is not None:
        low, high = given.uniform
        return [low + share * (high - low) for share in shares]
    if given.log_uniform is not None:
        low, high = given.log_uniform
        return [low * (high / low) ** share for share in shares]
    assert given.normal is not None
    return [NormalDist(*given.normal).inv_cdf(share) for share in shares]
