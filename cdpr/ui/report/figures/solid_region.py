"""Surface of a workspace in parallel projection, shaded by slope, for print and pages without script."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cdpr.model.robot import Array
from cdpr.scene import colours
from cdpr.ui.report.figures.surface import Frame

Surface = tuple[Array, NDArray[np.int64]]  # corners (k, 3), m, and triangles (t, 3), counter-clockwise from outside

MOST = 4000  # triangles; corners of finer surfaces are merged
MERGED = 40  # cells along the longest side; corners in a cell are merged
SLABS = 12  # depth layers, drawn from far to near


def draw_surface(frame: Frame, view: Array, surface: Surface) -> None:
    """Draw the visible side of a surface; `view` (3, 3) projects onto right, up and towards the viewer."""
    corners, triangles = _coarse(*surface)
    places = corners @ view.T
    a, b, c = (places[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    length = np.maximum(np.linalg.norm(normals, axis=1), 1e-300)
    facing = normals[:, 2] / length
    seen = np.flatnonzero(facing > 0.0)
    seen = seen[np.argsort((a + b + c)[seen, 2])]
    for slab in np.array_split(seen, SLABS):
        tone = np.minimum((facing[slab] * len(colours.SURFACE)).astype(int), len(colours.SURFACE) - 1)
        for k, colour in enumerate(colours.SURFACE):
            rings = [places[triangles[i], :2] for i in slab[tone == k]]
            if rings:  # an edge of the same colour closes the gaps between triangles
                frame.area(rings, {"facecolor": colour, "edgecolor": colour, "linewidth": 0.4, "zorder": 0.8})


def _coarse(corners: Array, triangles: NDArray[np.int64]) -> Surface:
    """Return a surface with fewer triangles if there are too many."""
    if len(triangles) <= MOST:
        return corners, triangles
    size = float(np.ptp(corners, axis=0).max()) / MERGED
    _, first, place = np.unique(np.round(corners / size), axis=0, return_index=True, return_inverse=True)
    found = np.unique(place.reshape(-1)[triangles], axis=0)
    kept = (found[:, 0] != found[:, 1]) & (found[:, 1] != found[:, 2]) & (found[:, 0] != found[:, 2])
    return corners[first], found[kept]
