"""Markers in the image of a pinhole camera, on the platform or in the hall."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, field_validator, model_validator

from cdpr.base.fields import Position, Positive, Vector3, unit
from cdpr.base.needs import Needs, of_sensor
from cdpr.mechanics import solids
from cdpr.native.bind import bind
from cdpr.sensing.disturbance import Mount
from cdpr.sensing.errors import Errors
from cdpr.sensing.pinhole import check_lens
from cdpr.sensing.rays import solids_of
from cdpr.sensing.sensor import Quantity, Sensor, Sources, Truth
from cdpr.tension.operations import Operation

MOST_MARKERS = 1000
QuaternionValues = tuple[float, float, float, float]


class Markers(Sensor):
    """Camera that measures the image points of markers.

    A camera on the platform sees markers in the world, and a camera in the world sees markers on the platform. Its axes
    are those of OpenCV: z forwards, x to the right and y down in the image. A point (x, y, z) in these axes has the
    pixel (fx x / z + cx, fy y / z + cy). A marker is seen if z is positive, the pixel is in the image, and neither an
    obstacle nor the platform's shape hides it. Other markers keep their last pixel; at first the principal point.

    Example:
        >>> import cdpr
        >>> camera = cdpr.sensing.Markers(position=[0, 0, 3], attitude=[0, 1, 0, 0], markers=[[0.1, 0.0, 0.2]])
        >>> camera.focal, camera.size
        ((800.0, 800.0), (640, 480))
    """

    needs: ClassVar[Needs] = of_sensor()
    mount: ClassVar[tuple[str, ...]] = ("place", "axes")

    type: Literal["markers"] = "markers"
    on: Literal["world", "platform"] = Field("world", description="body that carries the camera")
    position: Position = Field(description="place of the camera in the axes of its body", json_schema_extra=unit("m"))
    attitude: QuaternionValues = Field(
        (1.0, 0.0, 0.0, 0.0), description="attitude of the camera's axes in those of its body, a quaternion w, x, y, z"
    )
    focal: tuple[Positive, Positive] = Field(
        (800.0, 800.0), description="focal lengths fx and fy", json_schema_extra=unit("px")
    )
    center: tuple[float, float] | None = Field(
        None, description="principal point cx, cy; default: the middle of the image", json_schema_extra=unit("px")
    )
    size: tuple[Annotated[int, Field(ge=1, le=100_000)], Annotated[int, Field(ge=1, le=100_000)]] = Field(
        (640, 480), description="width and height of the image", json_schema_extra=unit("px")
    )
    markers: Annotated[tuple[Vector3, ...], Field(min_length=1, max_length=MOST_MARKERS)] = Field(
        description="places of the markers in the axes of the other body", json_schema_extra=unit("m")
    )
    pixel: Errors = Field(Errors(), description="errors of the pixels, px")

    @field_validator("attitude")
    @classmethod
    def _rotates(cls, value: QuaternionValues) -> QuaternionValues:
        if not np.isclose(np.linalg.norm(value), 1.0, atol=1e-6):  # written with six digits
            raise ValueError(f"expected a unit quaternion w, x, y, z, got one of norm {np.linalg.norm(value):.6g}")
        return value

    @model_validator(mode="after")
    def _sees(self) -> Self:
        check_lens(self.focal, self.center, self.size)
        return self

    @property
    def quantities(self) -> tuple[Quantity, ...]:  # type: ignore[override]
        """Pixels and visibility."""
        count = len(self.markers)
        return (
            Quantity("pixel", 2 * count, "px", "Pixel u, v of each marker, kept while it is not seen"),
            Quantity("seen", count, "", "1 if the marker is seen, else 0"),
        )

    def model(self) -> dict[str, Any]:
        """Return camera and markers for the kernels: `camera`, `markers`, `lens` and `carried` of markers.hpp."""
        attitude = np.array(self.attitude) / np.linalg.norm(self.attitude)
        middle = self.center or (0.5 * self.size[0], 0.5 * self.size[1])
        return {
            "camera": np.concatenate([self.position, attitude]),
            "markers": np.array(self.markers),
            "lens": np.array([*self.focal, *middle, *self.size], dtype=float),
            "carried": int(self.on == "platform"),
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
