"""Latest images of the cameras of a running simulation, for the window."""

from __future__ import annotations

from base64 import b64encode
from typing import Any

from cdpr.base.errors import CdprError
from cdpr.log.header import Header
from cdpr.log.images import cameras_of, png
from cdpr.model.robot import Array


class LatestImages:
    """Latest image of each camera; one thread must make and use it."""

    def __init__(self, header: Header) -> None:
        self._cameras = cameras_of(header)
        self._step, self._broken = header.control_step, header.broken
        self._taken = [-1] * len(self._cameras)  # period of the last image of each
        self._shown: list[dict[str, Any]] = [{"name": camera.name, "t": None, "png": ""} for camera in self._cameras]

    @property
    def message(self) -> dict[str, Any]:
        """Message with the images; a camera without one has the time None."""
        return {"kind": "images", "cameras": list(self._shown)}

    def take(self, sample: int, row: Array) -> bool:
        """Render the row (width,) of a sample, for each camera at most once in its period; return True if any has.

        Raises:
            CdprError: if no renderer works on this machine; there are then no more images.
        """
        due = [i for i, camera in enumerate(self._cameras) if self._taken[i] != sample // camera.every]
        for i in due:
            camera = self._cameras[i]
            self._taken[i] = sample // camera.every
            try:
                data = b64encode(png(camera.image(row))).decode()
            except CdprError:
                self.close()
                raise
            self._shown[i] = {"name": camera.name, "t": round(sample * self._step, 9), "png": data}
        return bool(due)

    def amend(self, header: Header) -> None:
        """Draw the cables as broken from now on that are in the run's header after live events."""
        if header.broken != self._broken:
            self._broken = header.broken
            self._cameras = [camera.revised(header) for camera in self._cameras]

    def close(self) -> None:
        """Free the renderers."""
        for camera in self._cameras:
            camera.close()
        self._cameras = []
