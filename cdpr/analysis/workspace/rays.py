"""Free intervals of the platform's position along parallel rays, to full precision and without missed intervals."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr.analysis.workspace.regions import Region
from cdpr.base.errors import CdprError
from cdpr.base.threads import in_threads
from cdpr.mechanics.clearance import Clearance
from cdpr.model.robot import Array
from cdpr.native.bind import bind

MOST = 64  # maximum number of interval ends along one ray, as in tracing.hpp


@dataclass(frozen=True, eq=False)
class Rays:
    """Free intervals of rays along an axis, through the centres of the cells across it.

    Attributes:
        axis: axis of the rays.
        number: (k,), number of the ray, over the cells across, the last axis fastest.
        free: (k, 2), m, ends of a free interval.
        region: region of the cells.
    """

    axis: int
    number: NDArray[np.int64]
    free: Array
    region: Region

    @property
    def volume(self) -> float:
        """Free size, m^3, m^2 or m: lengths times the cells across."""
        across = [i for i in self.region.moving if i != self.axis]
        return float((self.free[:, 1] - self.free[:, 0]).sum() * np.prod(self.region.spacing[across]))

    def figures(self) -> dict[str, Any]:
        """Return its figures."""
        count = self.region.cells // self.region.shape[self.axis]
        return {"rays": count, "along": "xyz"[self.axis], "stretches": len(self.free)}

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return its data as arrays for a file."""
        return {"ray_axis": np.array(self.axis), "ray_number": self.number, "ray_free": self.free}

    @classmethod
    def from_plain(cls, region: Region, arrays: dict[str, NDArray[Any]]) -> Rays:
        """Return the rays from the arrays of `plain`."""
        return cls(int(arrays["ray_axis"]), arrays["ray_number"], arrays["ray_free"], region)

    def at_cells(self) -> NDArray[np.bool_]:
        """Return True for cells with their centre in a free interval, (cells,)."""
        shape = self.region.shape
        middles = self.region.axes[self.axis]
        found = np.zeros((self.region.cells // shape[self.axis], shape[self.axis]), dtype=bool)
        for number, (low, high) in zip(self.number.tolist(), self.free.tolist(), strict=True):
            found[number] |= (middles >= low) & (middles <= high)
        across = [shape[i] for i in range(3) if i != self.axis]
        return np.moveaxis(found.reshape(*across, shape[self.axis]), 2, self.axis).reshape(-1)


def rays(
    bodies: Clearance,
    region: Region,
    edge: float,
    over: str,
    jobs: int | None,
    progress: Callable[[int, int], None],
) -> Rays:
    """Return the free intervals of rays along the last axis of a region, through the centres of its cells.

    Args:
        bodies: bodies whose clearances count.
        region: the region.
        edge: smallest clearance that is free, m.
        over: "all" or "any" attitudes must be free.
        jobs: threads; the result is the same.
        progress: called with the number of finished rays and their total.

    Raises:
        CdprError: if a ray has too many intervals.
    """
    axis = region.moving[-1]
    across = [region.axes[i] if i != axis else region.lower[i : i + 1] for i in range(3)]
    starts = np.stack(np.meshgrid(*across, indexing="ij"), axis=-1).reshape(-1, 3)
    about = {
        **bodies.bodies._asdict(),
        "axis": axis,
        "over_all": over == "all",
        "low": float(region.lower[axis]),
        "high": float(region.upper[axis]),
        "edge": edge,
        "orientations": np.ascontiguousarray(region.orientations),
    }
    ends, counts = np.empty((len(starts), MOST)), np.empty(len(starts), dtype=np.int64)
    done = 0

    def part(cut: slice) -> None:
        nonlocal done
        bind("search_rays", **about, positions=starts[cut], ends=ends[cut], counts=counts[cut]).unlocked()
        done += cut.stop - cut.start
        progress(min(done, len(starts)), len(starts))

    in_threads(len(starts), part, jobs, chunk=256)
    if (counts < 0).any():
        x, y, z = starts[int(np.argmax(counts < 0))].tolist()
        raise CdprError(f"rays: the one from {x:g}, {y:g}, {z:g} has more than {MOST // 2} free stretches")
    number = np.repeat(np.arange(len(starts)), counts // 2)
    kept = np.arange(MOST)[None] < counts[:, None]
    return Rays(axis, number, ends[kept].reshape(-1, 2), region)
