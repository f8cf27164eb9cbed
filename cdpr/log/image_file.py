"""File with the images of a run's cameras, beside its log."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from mcap.writer import CompressionType, Writer

from cdpr.log.files import unwritable
from cdpr.log.images import KIND, CameraImages, imaged_rows, message, png
from cdpr.log.ros2 import full_name, schema_text
from cdpr.log.run import Run

IMAGES_NAME = "images.mcap"  # in a run folder


def write_images(path: Path, run: Run, cameras: list[CameraImages]) -> None:
    """Write the images of all cameras as `sensor_msgs/CompressedImage` (PNG) to an MCAP file; they are rendered here.

    Equal runs give equal bytes on one machine.

    Args:
        path: new file.
        run: run with rows.
        cameras: cameras of the run.

    Raises:
        OutputError: if it cannot be written; it is then removed.
        CdprError: if the renderer fails.
    """
    try:
        with path.open("xb") as file:
            writer = Writer(file, compression=CompressionType.NONE)  # PNG is compressed
            writer.start(profile="ros2", library="cdpr")
            schema = writer.register_schema(full_name(KIND), "ros2msg", schema_text(KIND).encode())
            for camera in cameras:
                channel = writer.register_channel(camera.topic, "cdr", schema)
                for sample, row in imaged_rows(run, camera):
                    time = round(sample * run.header.control_step * 1e9)
                    data = message(time, camera.name, png(camera.image(row)))
                    writer.add_message(channel, time, data, time, sample)
            writer.finish()  # type: ignore[no-untyped-call]
    except BaseException as error:
        with suppress(OSError):
            path.unlink()
        if isinstance(error, OSError):
            raise unwritable(path, error) from error
        raise
