"""Pinhole model, the base of cameras."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, field_validator, model_validator

from cdpr.base.fields import Position, Positive, unit
from cdpr.model import rotations
from cdpr.model.robot import Array
from cdpr.sensing.message import Message
from cdpr.sensing.sensor import Sensor

if TYPE_CHECKING:
    from cdpr.scene.sensors import SensorDrawing

DEPTH = 0.1  # of a drawn frustum, relative to the extent of the frame anchors
UNIT = 1e-6  # of quaternions that are written with six digits
LARGEST = 100_000  # px, width and height
MOST = 1000  # times the size of the image, and its inverse: renderers and drawings fail with narrower and wider views


class Pinhole(Sensor):
    """Base class of cameras in the world or on the platform.

    Their axes are those of OpenCV: z forwards, x to the right and y down in the image. A point (x, y, z) in these axes
    has the pixel (fx x / z + cx, fy y / z + cy).
    """

    on: Literal["world", "platform"] = Field("world", description="body that carries the camera")
    position: Position = Field(description="place of the camera in the axes of its body", json_schema_extra=unit("m"))
    attitude: tuple[float, float, float, float] = Field(
        (1.0, 0.0, 0.0, 0.0), description="attitude of the camera's axes in those of its body, a quaternion w, x, y, z"
    )
    focal: tuple[Positive, Positive] = Field(
        (800.0, 800.0), description="focal lengths fx and fy", json_schema_extra=unit("px")
    )
    center: tuple[float, float] | None = Field(
        None, description="principal point cx, cy; default: the middle of the image", json_schema_extra=unit("px")
    )
    size: tuple[Annotated[int, Field(ge=1, le=LARGEST)], Annotated[int, Field(ge=1, le=LARGEST)]] = Field(
        (640, 480), description="width and height of the image", json_schema_extra=unit("px")
    )

    @field_validator("attitude", mode="before")
    @classmethod
    def _is_quaternion(cls, value: object) -> object:
        wanted = "expected a quaternion w, x, y, z (a list of 4 numbers)"
        if isinstance(value, dict):
            raise ValueError(f"{wanted}, got a mapping{_as_list(value)}")
        if isinstance(value, list) and len(value) != 4:
            raise ValueError(f"{wanted}, got {len(value)}")
        return tuple(value) if isinstance(value, list) else value

    @field_validator("attitude")
    @classmethod
    def _rotates(cls, value: tuple[float, ...]) -> tuple[float, ...]:
        if not np.isclose(np.linalg.norm(value), 1.0, atol=UNIT):
            raise ValueError(f"expected a unit quaternion w, x, y, z, got one of norm {np.linalg.norm(value):.6g}")
        return value

    @model_validator(mode="after")
    def _sees(self) -> Self:
        given = f"got {self.focal[0]:g} and {self.focal[1]:g}"
        least, largest = [each / MOST for each in self.size], [float(each * MOST) for each in self.size]
        if any(length > limit for length, limit in zip(self.focal, largest, strict=True)):
            raise ValueError(
                f"focal: expected at most {largest[0]:g} px and {largest[1]:g} px, {MOST} times the size of the image, "
                f"{given}: the image would show less than 0.06 degrees"
            )
        if any(length < limit for length, limit in zip(self.focal, least, strict=True)):
            raise ValueError(
                f"focal: expected at least {least[0]:g} px and {least[1]:g} px, the size of the image / {MOST}, "
                f"{given}: the image would show more than 179.7 degrees"
            )
        if self.center is not None and any(abs(x) > limit for x, limit in zip(self.center, largest, strict=True)):
            raise ValueError(
                f"center: expected at most {largest[0]:g} px and {largest[1]:g} px in size, {MOST} times the size of "
                f"the image, got {self.center[0]:g} and {self.center[1]:g}"
            )
        return self

    @property
    def carried(self) -> bool:
        """True if the platform carries the camera, else the world."""
        return self.on == "platform"

    @property
    def axes(self) -> Array:
        """Attitude (4,), of length 1 to round-off."""
        return np.asarray(np.array(self.attitude) / np.linalg.norm(self.attitude))

    @property
    def principal_point(self) -> tuple[float, float]:
        """Principal point cx, cy, px."""
        width, height = self.size
        return self.center or (0.5 * width, 0.5 * height)

    def frustum(self, depth: float) -> Array:
        """Return the edges (16, 3), m, of the pyramid that it sees up to a depth, m, in the axes of its body."""
        width, height = self.size
        pixels = np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])
        corners = depth * np.column_stack([(pixels - self.principal_point) / self.focal, np.ones(4)])
        edges = [end for i in range(4) for end in (np.zeros(3), corners[i], corners[i], corners[(i + 1) % 4])]
        return np.asarray(self.position + np.einsum("ij,kj->ki", rotations.matrix(self.axes), np.array(edges)))

    def drawing(self, extent: float) -> SensorDrawing:
        """Return the frustum."""
        from cdpr.scene.sensors import SensorDrawing  # validation needs no drawings

        at, edges = np.array(self.position), self.frustum(DEPTH * extent)
        return SensorDrawing(self.title, self.carried, at, self.axes, edges)

    def message(self, cables: Sequence[str]) -> Message:
        """Return the lens."""
        (fx, fy), (cx, cy), (width, height) = self.focal, self.principal_point, self.size
        constant = {
            "height": height,
            "width": width,
            "distortion_model": "plumb_bob",
            "d": [0.0] * 5,
            "k": [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0],
            "r": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
            "p": [fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
        }
        return Message("sensor_msgs/CameraInfo", {}, constant, framed=True, topic="/camera_info")


def _as_list(given: dict[Any, Any]) -> str:
    """Return advice on an attitude in angles, as other sections accept it: its quaternion; "" for other mappings."""
    for key, factor in (("rpy", 1.0), ("rpy_deg", np.pi / 180.0)):
        try:
            angles = factor * np.array(given.get(key), dtype=float)
        except (TypeError, ValueError):
            continue
        if angles.shape == (3,) and np.isfinite(angles).all():
            return f"; write [{', '.join(f'{part + 0.0:.9g}' for part in rotations.from_rpy(*angles).round(9))}]"
    return ""
