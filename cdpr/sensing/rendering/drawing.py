"""Primitives of an image, the camera that sees them, and the interface of renderers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from cdpr.model.robot import Array

Colour = tuple[float, float, float]
BACKGROUND = (0.86, 0.88, 0.90)
NEAR, FAR = 0.02, 200.0  # m, distances of the first and the last plane that are drawn


@dataclass(frozen=True)
class Lens:
    """Pinhole camera.

    Attributes:
        focal: fx and fy, px.
        center: principal point cx, cy, px.
        size: width and height of the image, px.
    """

    focal: tuple[float, float]
    center: tuple[float, float]
    size: tuple[int, int]

    def edges(self, near: float) -> tuple[float, float, float, float]:
        """Return left, right, top and bottom of the image on the plane `near` (m) before the camera; y is down."""
        (fx, fy), (cx, cy), (width, height) = self.focal, self.center, self.size
        return -near * cx / fx, near * (width - cx) / fx, -near * cy / fy, near * (height - cy) / fy


class Primitive(NamedTuple):
    """Shape of one colour in the world.

    Attributes:
        kind: "box" with its edge lengths, "sphere" with its radius, "cylinder" with radius and height along z, m.
        size: (3,) m, as far as it is used.
        position: (3,) m.
        R: (3, 3), attitude.
        colour: red, green and blue, 0 to 1.
        shines: True if its colour does not depend on the light.
    """

    kind: Literal["box", "sphere", "cylinder"]
    size: Array
    position: Array
    R: Array
    colour: Colour
    shines: bool = False


Drawing = list[Primitive]
Image = NDArray[np.uint8]


class Renderer(Protocol):
    """Renderer of images of one size, for one camera."""

    def draw(self, eye: Array, R: Array, drawing: Drawing) -> Image:
        """Return the image (height, width, 3), red, green and blue.

        Args:
            eye: (3,) m, place of the camera.
            R: (3, 3), its axes in the world: x to the right and y down in the image, z forwards.
            drawing: what it sees.
        """

    def close(self) -> None:
        """Free its resources."""


def rod(start: Array, end: Array, radius: float, colour: Colour) -> Primitive:
    """Return a cylinder between two points (3,), m."""
    along = end - start
    length = float(np.linalg.norm(along))
    R = np.eye(3)
    if length > 0.0:
        z = along / length
        across = np.cross(np.eye(3)[int(np.argmin(np.abs(z)))], z)
        x = across / np.linalg.norm(across)
        R = np.stack([x, np.cross(z, x), z], axis=1)
    return Primitive("cylinder", np.array([radius, length, 0.0]), 0.5 * (start + end), R, colour)
