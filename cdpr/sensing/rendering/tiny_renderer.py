"""Renderer of Bullet: software, without a graphics card or driver."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from cdpr.base.redirect_output import discarded_output
from cdpr.model import rotations
from cdpr.model.robot import Array
from cdpr.sensing.rendering.drawing import FAR, NEAR, Drawing, Image, Lens

OFFSET = 0.5, -0.5  # px, of its images to the right and down, measured with spheres
LIGHT = dict(lightAmbientCoeff=0.5, lightDiffuseCoeff=0.5, lightSpecularCoeff=0.0)  # noqa: C408 - arguments


class TinyRenderer:
    """World of Bullet with the primitives of one image at a time."""

    def __init__(self, lens: Lens) -> None:
        with discarded_output():  # the import prints its build time
            import pybullet
        self._bullet: Any = pybullet
        self._client = pybullet.connect(pybullet.DIRECT)
        self._size = lens.size
        (cx, cy), (right, up) = lens.center, OFFSET
        left, right, top, bottom = replace(lens, center=(cx - right, cy - up)).edges(NEAR)
        self._projection = pybullet.computeProjectionMatrix(left, right, -bottom, -top, NEAR, FAR)

    def draw(self, eye: Array, R: Array, drawing: Drawing) -> Image:
        """Return the image (height, width, 3)."""
        bullet, client = self._bullet, self._client
        bullet.resetSimulation(physicsClientId=client)
        for kind, size, position, attitude, colour, _ in drawing:
            sizes: dict[str, Any] = {"radius": float(size[0])}
            form = bullet.GEOM_SPHERE
            if kind == "box":
                form, sizes = bullet.GEOM_BOX, {"halfExtents": (0.5 * size).tolist()}
            elif kind == "cylinder":
                form, sizes = bullet.GEOM_CYLINDER, {"radius": float(size[0]), "length": float(size[1])}
            look = bullet.createVisualShape(form, rgbaColor=[*colour, 1.0], physicsClientId=client, **sizes)
            w, x, y, z = rotations.from_matrix(attitude).tolist()
            bullet.createMultiBody(0.0, -1, look, position.tolist(), (x, y, z, w), physicsClientId=client)
        view = bullet.computeViewMatrix(eye.tolist(), (eye + R[:, 2]).tolist(), (-R[:, 1]).tolist())
        width, height = self._size
        image = bullet.getCameraImage(
            width,
            height,
            view,
            self._projection,
            lightDirection=(-R[:, 2]).tolist(),
            shadow=0,
            renderer=bullet.ER_TINY_RENDERER,
            flags=bullet.ER_NO_SEGMENTATION_MASK,
            physicsClientId=client,
            **LIGHT,
        )[2]
        return np.ascontiguousarray(np.asarray(image, np.uint8).reshape(height, width, 4)[:, :, :3])

    def close(self) -> None:
        """Disconnect."""
        self._bullet.disconnect(self._client)


def make(lens: Lens) -> TinyRenderer:
    """Return a renderer."""
    return TinyRenderer(lens)
