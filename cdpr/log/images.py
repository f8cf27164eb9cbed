"""Images of the cameras of a run, rendered from its rows, and their messages."""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.log.header import Header
from cdpr.log.ros2 import ENCAPSULATION
from cdpr.log.sensor_topics import PREFIX
from cdpr.model import rotations
from cdpr.model.robot import Array
from cdpr.scene import State, colours, pictures
from cdpr.sensing.camera import Camera
from cdpr.sensing.rendering import Lens, Renderer, make_renderer
from cdpr.sensing.rendering.drawing import Drawing, Image, Primitive, rod

if TYPE_CHECKING:
    from cdpr.log.run import Run

KIND = "sensor_msgs/CompressedImage"
CABLE, EDGE = 0.005, 0.01  # m, radii of cables and of edges of the frame
PIECES = 12  # of a cable that sags
RED, STEEL, CONCRETE = (0.85, 0.1, 0.1), (0.25, 0.26, 0.28), (0.55, 0.5, 0.45)  # markers, cables, obstacles
COMPRESSION = 6  # of zlib
BEGINS = b"\x89PNG\r\n\x1a\n"  # of a PNG file


@dataclass(frozen=True)
class CameraImages:
    """Images of one camera of a run.

    Args:
        header: header of the run.
        camera: the camera.
    """

    header: Header
    camera: Camera

    @property
    def name(self) -> str:
        """Name of the camera."""
        return self.camera.title

    @property
    def topic(self) -> str:
        """Topic of its images."""
        return f"{PREFIX}{self.name}/compressed"

    @property
    def every(self) -> int:
        """Number of samples from one image to the next."""
        return round(self.camera.period / self.header.control_step)

    @property
    def lens(self) -> Lens:
        """Pinhole model."""
        return Lens(self.camera.focal, self.camera.principal_point, self.camera.size)

    @cached_property
    def renderer(self) -> Renderer:
        """Renderer, made at the first image; one thread must make and use it."""
        return make_renderer(self.camera.renderer, self.lens)

    def image(self, row: Array) -> Image:
        """Return the image (height, width, 3), red, green and blue, of a row (width,)."""
        columns = self.header.layout.columns
        position, R = row[columns["position"]], rotations.matrix(row[columns["orientation"]])
        place, axes = np.array(self.camera.position), rotations.matrix(self.camera.axes)
        eye, camera = (position + R @ place, R @ axes) if self.camera.carried else (place, axes)
        return self.renderer.draw(eye, camera, self._drawing(row, position, R))

    def revised(self, header: Header) -> CameraImages:
        """Return the same camera, with its renderer, for another header of the run."""
        other = CameraImages(header, self.camera)
        if "renderer" in vars(self):
            vars(other)["renderer"] = self.renderer
        return other

    def close(self) -> None:
        """Free the renderer."""
        if "renderer" in vars(self):
            vars(self).pop("renderer").close()

    def _drawing(self, row: Array, position: Array, R: Array) -> Drawing:
        return [*self._still, *self._platform(position, R), *self._cables(row), *self._markers(position, R)]

    def _platform(self, position: Array, R: Array) -> Iterator[Primitive]:
        built_in = self.camera.carried and _inside(self.header.shape, np.array(self.camera.position))
        if self.header.shape is not None and not built_in:
            colour = colours.parts(self.header.colours.get("platform", colours.BODY.light))
            yield _shape(self.header.shape, position, R, colour)

    @cached_property
    def _still(self) -> Drawing:
        """Obstacles, and edges of the frame."""
        drawing = [
            _shape(each["shape"], np.array(each["pose"][:3]), rotations.matrix(np.array(each["pose"][3:])), CONCRETE)
            for each in self.header.imaging["obstacles"]
        ]
        colour = colours.parts(self.header.colours.get("frame", colours.PALE.light))
        edges = np.array(self.header.frame, dtype=float).reshape(-1, 2, 3)
        return [*drawing, *(rod(edge[0], edge[1], EDGE, colour) for edge in edges)]

    def _cables(self, row: Array) -> Iterator[Primitive]:
        columns = self.header.layout.columns
        command = row[None, columns["tension"]]
        shown = pictures(
            self.header.subject,
            row[columns["time"]],
            row[None, columns["position"]],
            row[None, columns["orientation"]],
            tension=row[None, columns["cable_tension"]] if "cable_tension" in columns else command,
            command=command,
            unwound=row[None, columns["unstretched_length"]] if self.header.spans else None,
        )
        lines = shown.cable_lines(PIECES + 1 if self.header.spans else 2)[0]
        for line, state in zip(lines, shown.state[0] if shown.state is not None else [None] * len(lines), strict=True):
            if state != State.BROKEN and np.isfinite(line).all():
                yield from (rod(start, end, CABLE, STEEL) for start, end in pairwise(line))

    def _markers(self, position: Array, R: Array) -> Iterator[Primitive]:
        size = np.array([self.camera.marker_radius, 0.0, 0.0])
        for each in self.header.subject.sensors if size[0] > 0.0 else ():
            for point in each.marks:  # of a sensor on the other body
                place = point if each.carried else position + R @ point
                yield Primitive("sphere", size, place, np.eye(3), RED, shines=True)


def cameras_of(header: Header) -> list[CameraImages]:
    """Return the cameras of a run, with which images are rendered; none without cameras."""
    return [CameraImages(header, sensor) for sensor in header.sensor_objects if isinstance(sensor, Camera)]


def images(run: Run, name: str | None = None) -> Iterator[tuple[float, Image]]:
    """Yield the images of a camera of a run, rendered from its rows.

    Args:
        run: run, also one that was read from a folder.
        name: name of the camera; by default the first one.

    Yields:
        Time, s, and image (height, width, 3), red, green and blue.

    Raises:
        CdprError: if the run has no such camera, or no renderer works on this machine.
    """
    found = cameras_of(run.header)
    names = [camera.name for camera in found]
    if not found or (name is not None and name not in names):
        wanted = "a camera" if name is None else f"a camera named '{name}'"
        raise CdprError(f"the run has no {wanted[2:]}: expected {' or '.join(names) or 'a sensor of the type camera'}")
    camera = found[0 if name is None else names.index(name)]
    try:
        for sample, row in imaged_rows(run, camera):
            yield sample * run.header.control_step, camera.image(row)
    finally:
        camera.close()


def imaged_rows(run: Run, camera: CameraImages) -> Iterator[tuple[int, Array]]:
    """Yield number and row of the samples of which a camera takes images, if their poses are finite."""
    return every_row(run, [camera])


def every_row(run: Run, cameras: Sequence[CameraImages]) -> Iterator[tuple[int, Array]]:
    """Yield number and row of the samples of which one of the cameras takes an image."""
    for k in range(0, len(run.rows), rows_apart(run.header, cameras)):
        row = np.asarray(run.rows[k : k + 1])[0]
        if takes_images(run.header, row, cameras):
            yield round(float(row[0]) / run.header.control_step), row


def rows_apart(header: Header, cameras: Sequence[CameraImages]) -> int:
    """Return the number of rows from one with an image to the next."""
    return math.gcd(*(max(1, camera.every // header.log_every) for camera in cameras))


def takes_images(header: Header, row: Array, cameras: Sequence[CameraImages]) -> bool:
    """Return True if one of the cameras takes an image of a row (width,)."""
    sample = sample_of(header, row)
    return sample is not None and any(sample % camera.every == 0 for camera in cameras)


def sample_of(header: Header, row: Array) -> int | None:
    """Return the number of the sample in a row (width,); None if its pose is not finite."""
    if not np.isfinite(row[: header.layout.columns["orientation"].stop]).all():
        return None
    return round(float(row[0]) / header.control_step)


def png(image: Image) -> bytes:
    """Return an image (height, width, 3) as PNG (ISO/IEC 15948), each row as the difference from the one above."""
    height, width, _ = image.shape
    lines = image.reshape(height, -1)
    filtered = np.full((height, 1 + 3 * width), 2, np.uint8)  # filter 2: "up"
    filtered[0, 1:] = lines[0]
    filtered[1:, 1:] = lines[1:] - lines[:-1]

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)  # 8 bits, red, green and blue
    parts = (b"IHDR", head), (b"IDAT", zlib.compress(filtered.tobytes(), COMPRESSION)), (b"IEND", b"")
    return BEGINS + b"".join(chunk(*part) for part in parts)


def message(time: int, frame: str, data: bytes) -> bytes:
    """Return a `sensor_msgs/CompressedImage` as CDR.

    Args:
        time: ns, simulation time.
        frame: name of the camera's frame.
        data: PNG file.
    """
    parts = bytearray(ENCAPSULATION + struct.pack("<iI", *divmod(time, 10**9)))
    for content in (frame.encode() + b"\0", b"png\0", data):
        parts += bytes(-len(parts) % 4)  # the encapsulation has four bytes
        parts += struct.pack("<I", len(content)) + content
    return bytes(parts)


def _shape(shape: dict[str, Any], position: Array, R: Array, colour: tuple[float, float, float]) -> Primitive:
    """Return the primitive of a shape in the format of `Platform.outline`; for meshes and hulls, the bounding box."""
    (kind, size), *_ = shape.items()
    if kind == "sphere":
        return Primitive("sphere", np.array([size, 0.0, 0.0]), position, R, colour)
    if kind == "cylinder":
        return Primitive("cylinder", np.array([*size, 0.0]), position, R, colour)
    lower, upper = np.array(size if kind == "mesh" else np.outer((-0.5, 0.5), size), dtype=float)
    return Primitive("box", upper - lower, position + R @ (0.5 * (lower + upper)), R, colour)


def _inside(shape: dict[str, Any] | None, point: Array) -> bool:
    """Return True if a point of the platform is inside its shape."""
    if shape is None:
        return False
    (kind, size), *_ = shape.items()
    if kind == "sphere":
        return bool(np.linalg.norm(point) < size)
    if kind == "cylinder":
        return bool(np.hypot(*point[:2]) < size[0] and abs(point[2]) < 0.5 * size[1])
    lower, upper = np.array(size if kind == "mesh" else np.outer((-0.5, 0.5), size), dtype=float)
    return bool(((lower < point) & (point < upper)).all())
