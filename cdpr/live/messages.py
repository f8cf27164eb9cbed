"""A row as the messages that a log holds of it: the same topics, types and bytes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from time import monotonic

from cdpr.log.chunk import Chunk, Template
from cdpr.log.run import Header
from cdpr.log.topics import Group, Topic, run_topics
from cdpr.log.visuals import PATH, PATH_RATE, visual_topics
from cdpr.model.robot import Array


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
        self._path_due = -math.inf  # by the clock

    def of(self, row: Array, sample: int, wanted: list[bool]) -> Iterator[tuple[int, bytes]]:
        """Yield number and bytes of each topic that is wanted, of a row (width,) with its number.

        What takes long is left out for groups of which nothing is wanted; of the desired path, which does not change,
        also for who has heard of it within a second of the clock: who comes meanwhile waits so long at most.
        """
        first, now = 0, monotonic()
        for group, chunk in self._groups:
            numbers = range(first, first + len(group.topics))
            first += len(group.topics)
            heard = any(wanted[k] for k in numbers)
            if group.topics[0].name == PATH:
                if heard and now < self._path_due:
                    continue
                self._path_due = now + 1.0 / PATH_RATE if heard else -math.inf  # the first has it at once
            if heard:
                found = chunk.messages(group.source(row[None]), sample)
                yield from ((k, bytes(data)) for k, data in zip(numbers, found, strict=True) if wanted[k])
