"""Renderer of MuJoCo with EGL: no window, a graphics card or Mesa's software."""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr.base.errors import CdprError, one_line
from cdpr.model.robot import Array
from cdpr.sensing.rendering.drawing import BACKGROUND, FAR, NEAR, Drawing, Image, Lens

MOST = 10_000  # primitives of an image
_SKY = " ".join(f"{part:g}" for part in BACKGROUND)


class MujocoEgl:
    """Scene of MuJoCo without a model, drawn into an EGL buffer. One thread must do all calls.

    Raises:
        CdprError: if there is no EGL device, or its driver fails.
    """

    def __init__(self, lens: Lens) -> None:
        width, height = lens.size
        xml = (
            f'<mujoco><visual><global offwidth="{width}" offheight="{height}"/><quality offsamples="4"/></visual>'
            f'<asset><texture type="skybox" builtin="flat" rgb1="{_SKY}" rgb2="{_SKY}" width="8" height="48"/></asset>'
            "<worldbody/></mujoco>"
        )
        try:  # whatever a driver raises, such as AttributeError without its library
            import mujoco
            from mujoco import egl  # directly: MUJOCO_GL decides for mujoco.Renderer only

            self._mujoco = mujoco
            self._egl: Any = egl.GLContext(width, height)
            self._egl.make_current()
            model = mujoco.MjModel.from_xml_string(xml)
            self._scene = mujoco.MjvScene(model, MOST)
            self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
            mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        except Exception as error:
            raise CdprError(
                f"no EGL device for MuJoCo ({one_line(error)}): install EGL of Mesa or of the driver"
            ) from error
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = 0
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SKYBOX] = 1
        self._place_light()
        self._frustum(lens)
        self._size = lens.size

    def draw(self, eye: Array, R: Array, drawing: Drawing) -> Image:
        """Return the image (height, width, 3)."""
        mujoco, scene = self._mujoco, self._scene
        if len(drawing) > MOST:
            raise CdprError(f"an image has {len(drawing)} primitives, expected at most {MOST}")
        self._egl.make_current()
        scene.ngeom = 0
        kinds = mujoco.mjtGeom
        for kind, size, position, attitude, colour, shines in drawing:
            geom = scene.geoms[scene.ngeom]
            if kind == "box":
                form, half = kinds.mjGEOM_BOX, 0.5 * size
            elif kind == "sphere":
                form, half = kinds.mjGEOM_SPHERE, np.repeat(size[0], 3)
            else:
                form, half = kinds.mjGEOM_CYLINDER, np.array([size[0], 0.5 * size[1], 0.0])
            mujoco.mjv_initGeom(geom, form, half, position, attitude.ravel(), np.array([*colour, 1.0], np.float32))
            geom.emission = 1.0 if shines else 0.0
            geom.specular = 0.0
            scene.ngeom += 1
        for camera in scene.camera:
            camera.pos, camera.forward, camera.up = eye, R[:, 2], -R[:, 1]
        scene.lights[0].pos, scene.lights[0].dir = eye, R[:, 2]
        width, height = self._size
        image, whole = np.empty((height, width, 3), np.uint8), mujoco.MjrRect(0, 0, width, height)
        mujoco.mjr_render(whole, scene, self._context)
        mujoco.mjr_readPixels(image, None, whole, self._context)
        return np.ascontiguousarray(image[::-1])  # the first row is the lowest

    def close(self) -> None:
        """Free context and buffers."""
        self._context.free()
        self._egl.free()

    def _place_light(self) -> None:
        """Add a light at the camera."""
        self._scene.nlight = 1
        light = self._scene.lights[0]
        light.type, light.headlight, light.castshadow = int(self._mujoco.mjtLightType.mjLIGHT_DIRECTIONAL), 1, 0
        light.range = FAR
        light.ambient, light.diffuse, light.specular = [[level] * 3 for level in (0.4, 0.6, 0.0)]

    def _frustum(self, lens: Lens) -> None:
        left, right, top, bottom = lens.edges(NEAR)
        for camera in self._scene.camera:
            camera.frustum_near, camera.frustum_far = NEAR, FAR
            camera.frustum_center, camera.frustum_width = 0.5 * (left + right), 0.5 * (right - left)
            camera.frustum_top, camera.frustum_bottom = -top, -bottom
            camera.orthographic = 0


def make(lens: Lens) -> MujocoEgl:
    """Return a renderer; errors as for the class."""
    return MujocoEgl(lens)
