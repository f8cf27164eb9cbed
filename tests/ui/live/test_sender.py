"""Common parts of live links: services, parameters, and dropped messages."""

from __future__ import annotations

import numpy as np
from live_link import Quiet

from cdpr.ui.live.sender import BACKLOG


class Kept(Quiet):
    """Its simulation executes requests, or returns the reason."""

    def __init__(self):
        self.asked, self.refusal = [], ""
        super().__init__({"controller.kp": 100.0})

    def submit(self, request):
        self.asked.append((request.what, request.values))
        return self.refusal


def test_services_request_their_namesakes():
    link = Kept()
    for name in ("pause", "resume", "step", "reset", "stop"):
        assert link.call(name) == ""
    assert link.asked == [("pause", {}), ("pause", {"paused": False}), ("step", {}), ("reset", {}), ("stop", {})]
    link.refusal = "no"
    assert link.call("step") == link.set("controller.kp", 5.0) == "no"
    assert link.parameters == {"paused": False, "speed": 1.0, "controller.kp": 100.0}  # reports exceptions


def test_the_oldest_unread_message_is_dropped():
    link = Kept()
    for sample in range(3 * BACKLOG):
        link.show(np.zeros(1), sample, None)
    assert [sample for _, sample, _ in link._shown] == list(range(2 * BACKLOG, 3 * BACKLOG))


def test_set_keys_are_requested():
    link = Kept()
    for name, value in (("paused", True), ("speed", 2.0), ("controller.kp", 50.0)):
        assert link.set(name, value) == ""
    assert link.asked == [
        ("pause", {"paused": True}),
        ("speed", {"value": 2.0}),
        ("set", {"key": "controller.kp", "value": 50.0}),
    ]
    for name, value in (("paused", 1), ("speed", False), ("controller.kp", "50"), ("kp", 1.0)):
        assert link.set(name, value) == link.said[-1] != ""
    assert len(link.asked) == 3
