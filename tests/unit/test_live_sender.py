"""What live links share: parameters that follow what was done, whoever asked for it."""

from __future__ import annotations

import numpy as np
import pytest

from cdpr.live.sender import BACKLOG, Sender


class Kept(Sender):
    """A link to nobody, whose simulation does what it is asked for, or says why not."""

    def __init__(self):
        self.said, self.asked, self.told, self.refusal = [], [], 0, ""
        super().__init__("127.0.0.1", 0, self.said.append, {"controller.kp": 100.0})

    def ask(self, request):
        self.asked.append((request.what, request.values))
        return self.refusal

    def _changed(self):
        self.told += 1

    def _open(self, topics):
        pass

    def _wanted(self):
        return []

    def _put(self, time, messages):
        pass

    def _shut(self):
        pass


def test_paused_is_a_parameter_that_services_change():
    link = Kept()
    for name, paused in (("pause", True), ("resume", False), ("step", True), ("resume", False)):
        assert link.call(name) == ""
        assert link.parameters["paused"] is paused
    assert link.asked[:3] == [("pause", {}), ("pause", {"paused": False}), ("step", {})]
    assert link.told == 4
    for name in ("reset", "stop"):
        assert link.call(name) == ""
    assert link.told == 4


@pytest.mark.parametrize("name", ["pause", "step"])
def test_what_is_refused_changes_no_parameter(name):
    link = Kept()
    link.refusal = "no"
    assert link.call(name) == "no"
    assert link.set("controller.kp", 5.0) == "no"
    assert (link.parameters["paused"], link.parameters["controller.kp"], link.told) == (False, 100.0, 0)


def test_of_what_nobody_takes_the_oldest_is_dropped():
    link = Kept()
    for sample in range(3 * BACKLOG):
        link.show(np.zeros(1), sample)
    assert [sample for _, sample in link._shown] == list(range(2 * BACKLOG, 3 * BACKLOG))


def test_what_is_set_is_asked_for_and_kept():
    link = Kept()
    for name, value in (("paused", True), ("speed", 2.0), ("controller.kp", 50.0)):
        assert link.set(name, value) == ""
        assert link.parameters[name] == value
    assert link.asked == [
        ("pause", {"paused": True}),
        ("speed", {"speed": 2.0}),
        ("set", {"key": "controller.kp", "value": 50.0}),
    ]
    for name, value in (("paused", 1), ("speed", False), ("controller.kp", "50"), ("kp", 1.0)):
        assert link.set(name, value) == link.said[-1] != ""
    assert len(link.asked) == 3
