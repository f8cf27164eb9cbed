"""Operations of engines on `RigidBodyBackend`: those of the engine, and methods that a derived class overrides."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import GRAVITY

import cdpr
from cdpr.base.errors import PluginError
from cdpr.plugins import RigidBodyBackend
from cdpr.plugins.backend import Phases
from cdpr.tension.operations import Operation, perform
from cdpr.testing import samples


class Point(RigidBodyBackend):
    """Free point mass, whose engine notes what it does."""

    def build(self):
        self.notes = []

    def write(self):
        pass

    def read(self):
        self.notes.append("read")

    def advance(self):
        self.notes.append("advance")
        self.body[7:10] += self.physics_step * (self.applied[:3] / self.frame.mass + self.gravity)
        self.body[:3] += self.physics_step * self.body[7:10]


class Pushed(Point):
    def push(self):
        self.notes.append("push")


class Listed(Point):
    """Engine with a list of its own."""

    def engine_operations(self):
        return [self.advance, self.read, lambda: self.notes.append("listed")]


class Reread(Listed):
    """The list does not contain this `read`."""

    def read(self):
        self.notes.append("read anew")


class Repushed(Listed):
    def push(self):
        self.notes.append("push")


class Phased(Listed):
    """The list does not contain these operations."""

    def engine_phases(self):
        return Phases([], [self.advance], [self.read, lambda: self.notes.append("phased")])


@pytest.mark.parametrize(
    ("kind", "expected"),
    [
        (Point, ["advance", "read"]),
        (Pushed, ["push", "advance", "read"]),
        (Listed, ["advance", "read", "listed"]),
        (Reread, ["advance", "read anew"]),
        (Repushed, ["push", "advance", "read"]),
        (Phased, ["advance", "read", "phased"]),
    ],
)
def test_operations_are_those_of_the_methods(kind, expected):
    backend, other = (kind(samples.ball(), GRAVITY, 1e-3, None) for _ in range(2))
    for each in (backend, other):
        each.reset(np.eye(13)[3])
        each.command[:] = 10.0
        each.notes.clear()
    perform([Operation("", do) for do in backend.operations(2)])
    assert backend.notes == 2 * expected
    other.step(2)
    assert np.linalg.norm(other.state[7:10]) > 0.0
    np.testing.assert_array_equal(backend.state, other.state)


def returning(method, found):
    def wrong(self, *_):
        return found

    wrong.__name__ = method
    return type("Wrong", (Point,), {method: wrong})


@pytest.mark.parametrize("method", ["phases", "engine_phases", "engine_operations", "operations"])
@pytest.mark.parametrize("found", [5, "step", [5], [None], (len, 5)])
def test_wrong_results_of_methods_name_the_plugin(method, found):
    wrong = returning(method, found)
    expected = {"phases": "Phases", "engine_phases": "Phases"}.get(method, "a (list of functions|function)")
    with pytest.raises(PluginError, match=rf"Wrong\.{method}(\[\d\])?: expected {expected}, got "):
        cdpr.simulate("caroca", backend=wrong, overrides={"simulation.duration": 0.01})


def test_phases_without_lists_name_the_phase():
    wrong = returning("engine_phases", Phases([], 5, []))
    with pytest.raises(PluginError, match=r"Wrong\.engine_phases\.step: expected a list of functions, got 5"):
        cdpr.simulate("caroca", backend=wrong, overrides={"simulation.duration": 0.01})
