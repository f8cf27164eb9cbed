"""Client of a driver that records what it shows, for tests of requests."""

from __future__ import annotations

from conftest import ROOT
from fake_clock import FakeClock

import cdpr
from cdpr.simulation.driver import Driver
from cdpr.simulation.requests import Request, Requests

CAROCA = ROOT / "scenarios" / "caroca.yaml"
SHORT = {"simulation.duration": 0.1, "initial.position": [1.0, 0.3, 1.5], "trajectory": {"type": "hold"}}


class Client(Driver):
    """Driver that keeps its reports.

    It executes `script`, functions of it, at given numbers of complete samples, and one of `paused` after each wait in
    a pause.
    """

    def __init__(self, script=(), speed=1.0, paused=(), **overrides):
        simulation = cdpr.Simulation(CAROCA, overrides={**SHORT, **overrides})
        super().__init__(simulation, Requests(FakeClock()), speed=speed)
        self.script, self.while_paused, self.said, self.parameters = list(script), list(paused), [], {}

    def after_turn(self, moved):
        if self.paused and self.while_paused:
            self.while_paused.pop(0)(self)
        while self.script and self.simulation.samples >= self.script[0][0]:
            self.script.pop(0)[1](self)

    def report(self, request, level, text):
        self.said.append((level, text))

    def changed(self, parameters):
        self.parameters |= parameters


def ask(what, **values):
    """Return a function that puts a request."""
    return lambda driver: driver.requests.put(Request(what, values))


def rows(events=(), **overrides):
    return cdpr.simulate(CAROCA, overrides={**SHORT, **overrides, "events": list(events)}).rows.tobytes()


def resume(driver):
    driver.requests.put(Request("pause", {"paused": False}))


def nothing(driver):
    pass
