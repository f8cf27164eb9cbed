"""The last samples of a run reach live clients, however soon the run ends."""

from __future__ import annotations

import live_cases
import numpy as np

from cdpr.ui.live.sender import Sender


class EndsAtOnce(Sender):
    """A link whose run has ended before its thread begins to send."""

    def __init__(self, row, header):
        super().__init__("127.0.0.1", 7, str)
        self.row, self.header, self.sent, self.markers = row, header, [], b""

    def _open(self, topics):
        self.topics = topics
        self.show(self.row, 0, self.header)
        self.close()

    def _wanted(self):
        return [True] * len(self.topics)

    def _put(self, time, messages):
        found = dict(messages)
        self.sent.append((time, len(found)))
        self.markers = found[[topic.name for topic in self.topics].index("/cdpr/markers")]

    def _shut(self):
        pass


def test_samples_shown_before_the_end_are_sent():
    with live_cases.simulation() as simulation:
        simulation.step(1)
        link = EndsAtOnce(np.array(simulation.row), simulation.header)
        link.begin(simulation.header)
    link.close()
    assert link.sent == [(0, len(link.topics))]


def test_a_cable_that_was_cut_after_the_begin_is_not_drawn():
    drawn = []
    with live_cases.simulation() as simulation:
        start = simulation.header
        simulation.cut(3)
        simulation.step(1)
        for header in (start, simulation.header):
            link = EndsAtOnce(np.array(simulation.row), header)
            link.begin(start)
            link.close()
            drawn.append(link.markers)
    assert drawn[0] != drawn[1] != b""
