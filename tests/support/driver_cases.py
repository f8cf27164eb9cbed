"""Driver without a window, and a window of Python in place of a browser."""

from __future__ import annotations

import json
import time
from contextlib import contextmanager

from live_cases import CAROCA

from cdpr.scenario import load_scenario
from cdpr.simulation.requests import Request
from cdpr.ui.gui.broadcast import Broadcast
from cdpr.ui.gui.driver import WindowDriver

PATIENCE = 300.0  # s; kernels may have to be compiled on a busy machine
# Here caroca can do without a cable.
QUIET = {"simulation.duration": 0.3, "initial.position": [1.0, 0.3, 1.5], "trajectory": {"type": "hold"}}


def scenario(**changes):
    return load_scenario(CAROCA, overrides={**QUIET, **changes})


def wait(broadcast, kind, such=lambda message: True):
    """Return the first message of a kind on the broadcast that is such."""
    end = time.monotonic() + PATIENCE
    with broadcast.changed:
        while True:
            message = broadcast.latest(kind)
            if message is not None and such(message):
                return message
            assert broadcast.changed.wait(end - time.monotonic()), (kind, message)


def until(done):
    """Wait until a condition without a message is true."""
    end = time.monotonic() + PATIENCE
    while not done():
        assert time.monotonic() < end
        time.sleep(0.001)


class RunningDriver:
    """A driver, and its messages."""

    def __init__(self, *scenarios):
        self.broadcast, self.told, self.log = Broadcast(), [], []
        self.driver = WindowDriver(self.broadcast, self.log.append)
        for each in scenarios:
            self.driver.load(each, self.tell)

    def tell(self, level, text):
        with self.broadcast.changed:
            self.told.append((level, text))
            self.broadcast.changed.notify_all()

    def do(self, what, **arguments):
        self.driver.command(what, arguments, self.tell)

    def phase(self, *phases):
        """Wait until it is in one of these phases; return the status."""
        return wait(self.broadcast, "status", lambda status: status["phase"] in phases)

    def said(self):
        """Wait until all requests are done; return their messages."""
        done = []
        self.driver.requests.put(Request("done", action=lambda: done.append(True)))
        until(lambda: done)
        told, self.told[:] = list(self.told), []
        return told

    def points(self):
        """All samples that a window that joins now is sent."""
        mark, points = self.broadcast.curves.start(), []
        with self.broadcast.changed:
            while True:
                messages, mark = self.broadcast.curves.since(mark)
                if not messages:
                    return points
                for message in messages:
                    points += zip(message["t"], message["tension"], message["position_error"], strict=True)


@contextmanager
def running_driver(*scenarios):
    made = RunningDriver(*scenarios)
    try:
        yield made
    finally:
        made.driver.close()


class FakeWindow:
    """A window: it keeps what it was sent."""

    def __init__(self, socket):
        self.socket, self.seen = socket, []

    def send(self, **words):
        self.socket.send(json.dumps(words))

    def get(self, kind, such=lambda message: True):
        """Return the next message of a kind that is such."""
        end = time.monotonic() + PATIENCE
        while True:
            message = json.loads(self.socket.recv(timeout=end - time.monotonic()))
            self.seen.append(message)
            if message["kind"] == kind and such(message):
                return message
