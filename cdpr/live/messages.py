"""A row as the messages that a log holds of it: the same topics, types and bytes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from time import monotonic

from cdpr.log.chunk import Chunk, Template
from cdpr.log.run import Header
from cdpr.log.topics import Group, Topic, run_topics
from cdpr.log.visuals import PATH_RATE, visual_topics
from cdpr.model.robot import Array

OTHERS = 3  # groups of a run without a desired path: what its rows hold, frames, the scene


class Messages:
    """What is sent of a run.

    Attributes:
        topics: all, in the order of their channels.
    """

    def __init__(self, header: Header) -> None:
        own = run_topics(header)
        groups = (own, *visual_topics(header, own.channel + len(own.topics)))
        self.topics: tuple[Topic, ...] = tuple(topic for group in groups for topic in group.topics)
        self._groups: list[tuple[Group, Chunk]] = [
            (group, Chunk(Template(group), 1, header.control_step)) for group in groups
        ]
        self._path = len(groups) - 1 if len(groups) > OTHERS else None
        self._path_due = -math.inf  # by the clock
        self._wanted: list[bool] = []

    def of(self, row: Array, sample: int, wanted: list[bool]) -> Iterator[tuple[int, bytes]]:
        """Yield number and bytes of each topic that is wanted, of a row (width,) with its number.

        What takes long is left out for groups of which nothing is wanted; of the desired path, which does not change,
        also where the same listeners have heard of it within a second of the clock.
        """
        if wanted != self._wanted:  # somebody came who has nothing yet
            self._wanted, self._path_due = list(wanted), -math.inf
        first, now = 0, monotonic()
        for number, (group, chunk) in enumerate(self._groups):
            numbers = range(first, first + len(group.topics))
            first += len(group.topics)
            if number == self._path:
                if now < self._path_due:
                    continue
                self._path_due = now + 1.0 / PATH_RATE
            if any(wanted[k] for k in numbers):
                found = chunk.messages(group.source(row[None]), sample)
                yield from ((k, bytes(data)) for k, data in zip(numbers, found, strict=True) if wanted[k])
