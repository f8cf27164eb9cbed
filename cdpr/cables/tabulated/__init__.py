"""Cable that stretches along its chord by a measured curve of tension over strain.

Ropes and strands become stiffer under load: their manufacturers or a test give the tension at some strains. Of the
length l (m) the part l0 is unwound. The tension is f(e) + d (l' - l0'), with the strain e = (l - l0) / l0 and the curve
f through 0 and up to five points, straight between them; beyond the last point it continues straight. A slack cable has
no tension. With all points on one line the cable is the model `elastic`, whose remarks on steps apply, too.

The curve is that of slow loading, without hysteresis and creep; see `cdpr.cables.viscoelastic` for these.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated

import numpy as np
from pydantic import AfterValidator, Field

from cdpr.base.fields import NonNegative, Positive
from cdpr.base.needs import of_winch
from cdpr.cables.chain import Number, Span, Table
from cdpr.cables.elastic import DAMPING
from cdpr.model import Cable
from cdpr.model.robot import Array

POINTS = 5  # as in tabulated.hpp
TABLE = "stiffness_table"


def _rising(rows: list[tuple[float, float]]) -> list[tuple[float, float]]:
    for k, (low, high) in enumerate(pairwise(rows)):
        if not (high[0] > low[0] and high[1] > low[1]):
            raise ValueError(
                f"expected strains and tensions that rise, but point {k + 2} is {list(high)} after {list(low)}"
            )
    return rows


Curve = Annotated[list[tuple[Positive, Positive]], Field(min_length=1, max_length=POINTS), AfterValidator(_rising)]


def _numbers_of(quantity: str, unit: str) -> tuple[Number, ...]:
    """Return the numbers of a quantity at each point; the first is required."""
    return tuple(
        Number(
            f"cable.{quantity}_{k}",
            Positive if k == 1 else NonNegative,
            unit,
            f"curve of tension over strain, {quantity} at point {k}" + ("" if k == 1 else ", 0 without such a point"),
            None if k == 1 else 0.0,
            table=TABLE,
        )
        for k in range(1, POINTS + 1)
    )


STRAINS, TENSIONS = _numbers_of("strain", ""), _numbers_of("tension", "N")


CURVE = Table(
    TABLE,
    Curve,
    "strains and tensions (N) of up to five points of a curve from 0, with cable.model: tabulated",
    (STRAINS, TENSIONS),
)


class Tabulated(Span):
    """Span with a curve."""

    def stiffest(self, cable: Cable) -> float:
        """Return the largest slope of the curve, N."""
        points = [(0.0, 0.0), *CURVE.rows(cable.own)]
        return max((high[1] - low[1]) / (high[0] - low[0]) for low, high in pairwise(points))

    def tangent(self, cable: Cable, tension: Array) -> Array:
        """Return (1 + e) f'(e) - T, N, at the strains e of tensions (k,), N."""
        points = np.array([(0.0, 0.0), *CURVE.rows(cable.own)])
        slopes = np.diff(points[:, 1]) / np.diff(points[:, 0])
        piece = np.searchsorted(points[1:-1, 1], tension)
        strain = points[piece, 0] + (tension - points[piece, 1]) / slopes[piece]
        return np.asarray((1.0 + strain) * slopes[piece] - tension)


TABULATED = Tabulated(
    header="cdpr/cables/tabulated/tabulated.hpp", numbers=(*STRAINS, *TENSIONS, DAMPING), needs=of_winch()
)
