"""Messages of a single row, identical in topics, types and bytes to those of a log."""

from __future__ import annotations

import math
from collections.abc import Iterator
from time import monotonic

import numpy as np

from cdpr.log.chunk import Chunk, Template, nanoseconds
from cdpr.log.header import Header
from cdpr.log.images import KIND, cameras_of, message, png
from cdpr.log.sensor_topics import frame_of
from cdpr.log.topics import Group, Topic, run_topics
from cdpr.log.visuals import PATH, PATH_RATE, visual_topics
from cdpr.model.robot import Array


def _groups(header: Header) -> list[tuple[Group, Chunk]]:
    own = run_topics(header)
    groups = (own, *visual_topics(header, own.channel + len(own.topics)))
    return [(group, Chunk(Template(group), 1, header.control_step)) for group in groups]


class Messages:
    """Messages of a run.

    Attributes:
        topics: all topics in the order of their channels.
    """

    def __init__(self, header: Header) -> None:
        self._header, self._groups = header, _groups(header)
        topics = [topic for group, _ in self._groups for topic in group.topics]
        self._cameras = cameras_of(header)
        self._imaged = [-1] * len(self._cameras)  # period of the last image of each
        topics += [Topic(camera.topic, KIND, {}) for camera in self._cameras]
        self.topics: tuple[Topic, ...] = tuple(topics)
        self._step = header.control_step
        self._path_due = -math.inf  # clock time

    def amend(self, header: Header) -> None:
        """Draw the cables as broken from now on that are in the run's header after live events. The topics remain."""
        if header.broken != self._header.broken:
            self._header, self._groups = header, _groups(header)
            self._cameras = [camera.revised(header) for camera in self._cameras]

    def of(self, row: Array, sample: int, wanted: list[bool]) -> Iterator[tuple[int, bytes]]:
        """Yield the topic number and bytes of each wanted topic for a row (width,) and its sample number.

        Groups without a wanted topic are skipped. A camera has an image at most once in its period. The constant
        desired path is sent at most once per second of the clock, so new subscribers wait up to a second.
        """
        first, now = 0, monotonic()
        for group, chunk in self._groups:
            numbers = range(first, first + len(group.topics))
            first += len(group.topics)
            wanted_path = any(wanted[k] for k in numbers)
            if group.topics[0].name == PATH:
                if wanted_path and now < self._path_due:
                    continue
                self._path_due = now + 1.0 / PATH_RATE if wanted_path else -math.inf  # at once for the first
            if wanted_path:
                found = chunk.messages(group.source(row[None]), sample)
                yield from ((k, bytes(data)) for k, data in zip(numbers, found, strict=True) if wanted[k])
        for i, camera in enumerate(self._cameras):
            if wanted[first + i] and self._imaged[i] != sample // camera.every:
                self._imaged[i] = sample // camera.every
                time = int(nanoseconds(np.array([sample]), self._step)[0])
                yield first + i, message(time, frame_of(camera.name), png(camera.image(row)))

    def close(self) -> None:
        """Free the renderers of cameras, in the thread that called `of`."""
        for camera in self._cameras:
            camera.close()
        self._cameras = []
