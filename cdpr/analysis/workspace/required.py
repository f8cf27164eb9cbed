"""Sets of wrenches or accelerations that cables must provide in addition to the weight at rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from cdpr.base.errors import CdprError
from cdpr.model.arrays import checked
from cdpr.model.robot import Array, read_only

Form = Literal["zonotope", "ellipsoid", "vertices"]

MOST_CORNERS = 64  # maximum number of corners that are checked individually

# values in the kernels
FORMS: dict[str, int] = {"zonotope": 0, "ellipsoid": 1, "vertices": 2}


@dataclass(frozen=True, eq=False)
class Required:
    """Convex set in six dimensions: N and N m, or m/s^2 and rad/s^2; world axes, about the platform's origin.

    Attributes:
        form: meaning of the vectors: g of {sum s_k g_k : |s_k| <= 1}, the same with |s| <= 1, or corners of a hull.
        vectors: (k, 6); (0, 6) for a zonotope that is the origin alone.
        accelerations: True for accelerations at rest, which the platform's inertia converts to wrenches.
    """

    form: Form
    vectors: Array
    accelerations: bool = False

    def __repr__(self) -> str:
        kind = "accelerations" if self.accelerations else "wrenches"
        return f"<Required {kind}: {self.form} of {len(self.vectors)} vectors>"

    def to_dict(self) -> dict[str, Any]:
        """Return the set as plain data."""
        return {"form": self.form, "vectors": self.vectors.tolist(), "accelerations": self.accelerations}

    def corners(self) -> Array:
        """Return the corners (k, 6) of the set, at least the origin.

        Raises:
            CdprError: if it has too many corners or none.
        """
        if self.form == "vertices":
            return self.vectors
        if self.form == "ellipsoid" and len(self.vectors):
            raise CdprError("an ellipsoid has no corners to evaluate one by one: use a box around it")
        if 2 ** len(self.vectors) > MOST_CORNERS:
            raise CdprError(
                f"the required set has {2 ** len(self.vectors)} corners, at most {MOST_CORNERS} are allowed"
            )
        return np.array([np.array(signs) @ self.vectors for signs in product((-1.0, 1.0), repeat=len(self.vectors))])

    @classmethod
    def from_plain(cls, data: dict[str, Any]) -> Required:
        """Return the set from the data of `plain`."""
        return cls(data["form"], _vectors(data["vectors"], "vectors"), data["accelerations"])


NOTHING = Required("zonotope", read_only(np.zeros((0, 6))))


def box(half: ArrayLike, *, accelerations: bool = False) -> Required:
    """Return the box of all vectors within +- `half` (6,), each at least 0."""
    return Required("zonotope", _axes(half, "box"), accelerations)


def ellipsoid(half: ArrayLike, *, accelerations: bool = False) -> Required:
    """Return the ellipsoid along the axes with half axes `half` (6,), each at least 0."""
    return Required("ellipsoid", _axes(half, "ellipsoid"), accelerations)


def zonotope(generators: ArrayLike, *, accelerations: bool = False) -> Required:
    """Return the zonotope: sums of s_k g_k, |s_k| <= 1, for generators g_k (k, 6)."""
    return Required("zonotope", _vectors(generators, "zonotope"), accelerations)


def vertices(corners: ArrayLike, *, accelerations: bool = False) -> Required:
    """Return the convex hull of corners (k, 6), at least one."""
    found = _vectors(corners, "vertices")
    if not len(found):
        raise CdprError("vertices: expected at least one corner")
    return Required("vertices", found, accelerations)


def point(wrench: ArrayLike) -> Required:
    """Return the set of one wrench (6,)."""
    return vertices([checked(wrench, (6,), "point", finite=True)])


def _axes(half: ArrayLike, name: str) -> Array:
    sizes = checked(half, (6,), name, finite=True)
    if (sizes < 0.0).any():
        raise CdprError(f"{name}: expected six sizes of at least 0, got {_list_text(sizes)}")
    return read_only(np.diag(sizes)[sizes > 0.0])


def _vectors(given: ArrayLike, name: str) -> Array:
    found = checked(given, (None, 6), name, finite=True) if np.size(given) else np.zeros((0, 6))
    return read_only(found.copy())


def _list_text(values: Sequence[float] | Array) -> str:
    return ", ".join(f"{value:g}" for value in values)
