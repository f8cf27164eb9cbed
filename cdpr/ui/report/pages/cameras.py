"""Images of the cameras of a run for its report: which of them are embedded, and their figure."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from cdpr.base.errors import CdprError
from cdpr.log.run import Run
from cdpr.ui.report.pages.page import figure

if TYPE_CHECKING:  # runs without cameras do not need it
    from cdpr.log.images import CameraImages

NAME = "Images"  # of the figure
MOST_BYTES = 6_000_000  # of all embedded PNG files, so that the page opens quickly
MOST_IMAGES = 400  # of one camera: more than a player can distinguish on its slider


@dataclass(frozen=True)
class ShownImages:
    """Images of one camera that a report contains.

    Attributes:
        name: name of the camera.
        size: width and height, px.
        time: times of the embedded images, s.
        files: their PNG files.
        count: number of all images of the run.
        every: one in this number of images is embedded.
        missing: reason why there are none; empty otherwise.
    """

    name: str
    size: tuple[int, int]
    time: tuple[float, ...]
    files: tuple[bytes, ...]
    count: int
    every: int
    missing: str = ""


def shown_images(run: Run, most: int = MOST_BYTES) -> list[ShownImages]:
    """Return the images of all cameras of a run, equally spaced in time and together at most `most` bytes.

    They come from images.mcap in the folder of the run. Without a complete file, as after the run was killed, or
    without a folder, they are rendered from the rows.
    """
    from cdpr.log.image_file import stored_images
    from cdpr.log.images import cameras_of

    cameras = cameras_of(run.header)
    with stored_images(run) as reader:
        return [_shown(run, camera, reader, most // len(cameras)) for camera in cameras]


def _shown(run: Run, camera: CameraImages, reader: Any, most: int) -> ShownImages:
    from cdpr.log.image_file import StoredTopic
    from cdpr.log.images import imaged_rows, png

    samples = [sample for sample, _ in imaged_rows(run, camera)]
    step = run.header.control_step
    file = None if reader is None else StoredTopic(reader, camera.topic)

    def picture(k: int) -> bytes:
        stored = None if file is None else file.at(round(samples[k] * step * 1e9))
        row = samples[k] // run.header.log_every
        return stored or png(camera.image(np.asarray(run.rows[row : row + 1])[0]))

    try:
        every, found = thinned(len(samples), picture, most)
    except CdprError as error:  # no renderer
        return ShownImages(camera.name, camera.camera.size, (), (), len(samples), 1, str(error))
    finally:
        camera.close()
    missing = "" if found else f"one image has more than {most} bytes" if samples else "no image was taken"
    times = tuple(samples[k] * step for k in found)
    return ShownImages(camera.name, camera.camera.size, times, tuple(found.values()), len(samples), every, missing)


def thinned(count: int, picture: Callable[[int], bytes], most: int) -> tuple[int, dict[int, bytes]]:
    """Return n, and every n-th of `count` pictures by their numbers, which have at most `most` bytes in total.

    `picture` is called with ascending numbers, with the first one twice.
    """
    if not count:
        return 1, {}
    first = len(picture(0))
    every = max(1, -(-count * first // max(most, 1)), -(-count // MOST_IMAGES))
    found = {k: picture(k) for k in range(0, count, every)}
    while sum(map(len, found.values())) > most:
        if len(found) == 1:
            return every, {}
        every *= 2
        found = {k: data for k, data in found.items() if k % every == 0}
    return every, found


def player_data(shown: Sequence[ShownImages]) -> list[dict[str, Any]]:
    """Return the images as plain data for the player."""
    return [
        {"name": each.name, "time": list(each.time), "images": [b64encode(data).decode() for data in each.files]}
        for each in shown
        if each.files
    ]


def images_figure(shown: Sequence[ShownImages]) -> str:
    """Return the figure, which shows the last image of each camera until the script shows that of its time."""
    boxes = "".join(_box(each) for each in shown)
    notes = [
        f"Of camera {escape(each.name)}, the report contains one in {each.every} images, {len(each.files)} of "
        f"{each.count}, to limit its size."
        for each in shown
        if each.files and each.every > 1
    ]
    if notes:
        notes.append("The file images.mcap in the folder of a run has all images.")
    caption = " ".join(
        ["The last image of each camera up to the time of the player, rendered from the recorded states.", *notes]
    )
    return figure(NAME.lower(), "Images of cameras", f'<div class="cameras">{boxes}</div>', caption, minor=True)


def _box(each: ShownImages) -> str:
    name = escape(each.name)
    if not each.files:
        return f"<div><p>{name}</p><p>No images: {escape(each.missing)}.</p></div>"
    width, height = each.size
    source = f"data:image/png;base64,{b64encode(each.files[-1]).decode()}"
    image = f'<img src="{source}" width="{width}" height="{height}" alt="Image of camera {name}">'
    return f'<div data-camera="{name}"><p>{name} <output>{each.time[-1]:.3f} s</output></p>{image}</div>'
