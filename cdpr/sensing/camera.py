"""Camera, on the platform or in the hall, whose images are rendered from the recorded states."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, field_validator

from cdpr.base.column import Column
from cdpr.base.fields import NonNegative, unit
from cdpr.base.needs import Needs, left_out, of_sensor
from cdpr.sensing.pinhole import Pinhole
from cdpr.sensing.sensor import LONGEST, Sources, Truth

LARGEST = 4096  # px, width and height
NO_IMAGES = "rollouts render no images"


class Camera(Pinhole):
    """Camera that renders images of the platform, its cables, the obstacles and the markers.

    The images depend on the recorded states only, so they are the same for all backends up to the differences of the
    states. They are rendered outside the control loop, off screen, and differ between renderers and graphics drivers by
    more than round-off. They go to `images.mcap` in the folder of the run and to live links. Images do not affect the
    controller.

    Example:
        >>> import cdpr
        >>> cdpr.sensing.Camera(position=[0, 0, 5], attitude=[0, 1, 0, 0], period=0.05).size
        (640, 480)
    """

    needs: ClassVar[Needs] = replace(
        of_sensor(controller_fmu=left_out("images are not exported")),
        rollout=left_out(NO_IMAGES),
        threads=left_out(NO_IMAGES),
    )

    type: Literal["camera"] = "camera"
    size: tuple[Annotated[int, Field(ge=1, le=LARGEST)], Annotated[int, Field(ge=1, le=LARGEST)]] = Field(
        (640, 480), description="width and height of the image", json_schema_extra=unit("px")
    )
    period: Annotated[float, Field(gt=0.0, le=LONGEST)] = Field(
        0.05,
        description="time from one image to the next: an integer multiple of control_step and of log.step",
        json_schema_extra=unit("s"),
    )
    renderer: Literal["auto", "mujoco", "bullet"] = Field(
        "auto",
        description="renderer: MuJoCo with EGL, or Bullet's software renderer; auto: the first that is installed",
    )
    marker_radius: NonNegative = Field(
        0.02,
        description="radius of the spheres that show the markers of other sensors; 0: none",
        json_schema_extra=unit("m"),
    )

    @field_validator("delay", "jitter", "dropout")
    @classmethod
    def _exact(cls, value: float) -> float:
        if value:
            raise ValueError(f"must be 0 for a camera, got {value:g}: images are recorded at the times of their states")
        return value

    @field_validator("believed")
    @classmethod
    def _known(cls, value: dict[str, Any] | None) -> dict[str, Any] | None:
        if value:
            raise ValueError(
                "must be omitted for a camera: no estimator or controller uses its images. Use a sensor of the type "
                "markers for a camera that is mounted elsewhere than assumed"
            )
        return value

    @property
    def columns(self) -> tuple[Column, ...]:
        """No columns: images are not part of the rows."""
        return ()

    def truth(self, sources: Sources) -> Truth:
        """Return no values: images are not part of the rows."""
        return Truth(np.empty(0))
