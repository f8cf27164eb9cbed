"""Markers in the image of a pinhole camera, on the platform or in the hall."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from cdpr.base.fields import Vector3, unit
from cdpr.base.needs import Needs, of_sensor
from cdpr.mechanics import solids
from cdpr.model import rotations
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.sensing.disturbance import Mount
from cdpr.sensing.errors import Errors
from cdpr.sensing.pinhole import Pinhole
from cdpr.sensing.rays import solids_of
from cdpr.sensing.records import Records
from cdpr.sensing.sensor import Quantity, Sources, Truth
from cdpr.tension.operations import Operation

if TYPE_CHECKING:
    from cdpr.scene.sensors import SensorDrawing

MOST_MARKERS = 1000


class Markers(Pinhole):
    """Camera that measures the image points of markers.

    A camera on the platform sees markers in the world, and a camera in the world sees markers on the platform. A marker
    is seen if z is positive, the pixel is in the image, and neither an obstacle nor the platform's shape hides it.
    Other markers keep their last pixel; at first the principal point.

    Example:
        >>> import cdpr
        >>> camera = cdpr.sensing.Markers(position=[0, 0, 3], attitude=[0, 1, 0, 0], markers=[[0.1, 0.0, 0.2]])
        >>> camera.focal, camera.size
        ((800.0, 800.0), (640, 480))
    """

    needs: ClassVar[Needs] = of_sensor()
    mount: ClassVar[tuple[str, ...]] = ("place", "axes")
    locates: ClassVar[bool] = True
    measurement: ClassVar[str] = "markers"

    type: Literal["markers"] = "markers"
    markers: Annotated[tuple[Vector3, ...], Field(min_length=1, max_length=MOST_MARKERS)] = Field(
        description="places of the markers in the axes of the other body", json_schema_extra=unit("m")
    )
    pixel: Errors = Field(Errors(), description="errors of the pixels, px")

    @property
    def quantities(self) -> tuple[Quantity, ...]:  # type: ignore[override]
        """Pixels and visibility."""
        count = len(self.markers)
        return (
            Quantity("pixel", 2 * count, "px", "Pixel u, v of each marker, kept while it is not seen", seen="seen"),
            Quantity("seen", count, "", "1 if the marker is seen, else 0"),
        )

    def model(self) -> dict[str, Any]:
        """Return camera and markers for the kernels: `camera`, `markers`, `lens` and `carried` of markers.hpp."""
        return {
            "camera": np.concatenate([self.position, self.axes]),
            "markers": np.array(self.markers),
            "lens": np.array([*self.focal, *self.principal_point, *self.size], dtype=float),
            "carried": int(self.carried),
        }

    def truth(self, sources: Sources) -> Truth:
        """Return pixels and visibility (3 k,)."""
        count = len(self.markers)
        values = np.zeros(3 * count)
        model = self.model()
        shape = sources.robot.platform.shape
        write = bind(
            "project_markers",
            state=sources.state,
            **model,
            solids=solids_of(sources.obstacles),
            shape=solids.rows([] if shape is None else [solids.row(shape)]),
            pixels=values[: 2 * count].reshape(count, 2),
            seen=values[2 * count :],
        )
        mount = Mount(model["camera"][:3], model["camera"][3:])
        return Truth(values, (Operation("sensors", write, timed=True),), (values,), mount)

    def measurement_numbers(self) -> list[float]:
        """Return place and attitude of the camera, focal lengths, principal point, 1 if carried, and the markers."""
        lens = [*self.focal, *self.principal_point]
        return [*self.position, *self.axes, *lens, float(self.carried), *np.ravel(self.markers)]

    def drawing(self, extent: float) -> SensorDrawing:
        """Return frustum and markers."""
        column, chosen = f"{self.title}_seen", tuple(range(len(self.markers)))
        return replace(super().drawing(extent), marks=np.array(self.markers), column=column, chosen=chosen)

    def recorded_truth(self, key: str, records: Records) -> Array | None:
        """Return the pixels of all markers, as if none were hidden."""
        if key != "pixel":
            return None
        markers, R, p = np.array(self.markers), rotations.matrix(records.attitude), records.position[:, None]
        carried = self.carried
        points = np.einsum("nji,nkj->nki", R, markers - p) if carried else p + np.einsum("nij,kj->nki", R, markers)
        x, y, z = np.moveaxis(np.einsum("ji,nkj->nki", rotations.matrix(self.axes), points - self.position), -1, 0)
        (fx, fy), (cx, cy) = self.focal, self.principal_point
        return np.stack([fx * x / z + cx, fy * y / z + cy], axis=-1).reshape(len(p), -1)
