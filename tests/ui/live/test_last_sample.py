"""The last samples of a run reach live clients, however soon the run ends."""

from __future__ import annotations

import live_cases
import numpy as np

from cdpr.ui.live.sender import Sender


class EndsAtOnce(Sender):
    """A link whose run has ended before its thread begins to send."""

    def __init__(self, row, header):
        super().__init__("127.0.0.1", 7, str)
        self.row, self.header, self.sent = row, header, []

    def _open(self, topics):
        self.topics = topics
        self.show(self.row, 0, self.header)
        self.close()

    def _wanted(self):
        return [True] * len(self.topics)

    def _put(self, time, messages):
        self.sent.append((time, len(list(messages))))

    def _shut(self):
        pass


def test_samples_shown_before_the_end_are_sent():
    with live_cases.simulation() as simulation:
        simulation.step(1)
        link = EndsAtOnce(np.array(simulation.row), simulation.header)
        link.begin(simulation.header)
    link.close()
    assert link.sent == [(0, len(link.topics))]
