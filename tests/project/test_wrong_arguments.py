"""Wrong types of the arguments of classes and functions in Python: each gives one error that names the argument."""

from __future__ import annotations

import inspect
from itertools import product

import numpy as np
import pytest

import cdpr
from cdpr import model, trajectory
from cdpr.base.errors import CdprError
from cdpr.cables import Pulley
from cdpr.model.shapes import Hull, Obstacle
from cdpr.plugins import Column, Environment
from cdpr.scenario import Initial, World
from cdpr.scenario.events import EVENTS
from cdpr.scenario.motions import MOTIONS
from cdpr.scenario.schema import Simulation

UPRIGHT = [1.0, 0.0, 0.0, 0.0]
BOX = model.Box((1.0, 1.0, 1.0))
CORNERS = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]]
PLATFORM = model.Platform(1.0, [1.0, 1.0, 1.0])

# Valid arguments of each class that users make in Python. None of them may be a set or an object.
CLASSES = {
    model.Box: {"size": (1.0, 1.0, 1.0)},
    model.Sphere: {"radius": 1.0},
    model.Cylinder: {"radius": 1.0, "height": 1.0},
    model.Mesh: {"file": "a", "lower": (0.0, 0.0, 0.0), "upper": (1.0, 1.0, 1.0)},
    Hull: {"file": "a", "corners": ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)), "dent": 0.0},
    Obstacle: {"name": "a", "shape": BOX, "position": [0.0, 0.0, 0.0], "attitude": UPRIGHT},
    model.Frame: {"edges": np.zeros((1, 6)), "colour": "red"},
    model.Winch: {"drum_radius": 0.1, "inertia": 0.1},
    model.Cable: {"frame": [0.0, 0.0, 1.0], "platform": [0.0, 0.0, 0.0]},
    model.Platform: {"mass": 1.0, "inertia": [1.0, 1.0, 1.0]},
    model.Robot: {"platform": PLATFORM, "cables": [model.Cable([0.0, 0.0, 1.0], [0.0, 0.0, 0.0])]},
    model.Robot.from_points: {"frame": CORNERS, "platform": 0.1 * np.array(CORNERS), "mass": 1.0},
    Environment: {"obstacles": ()},
    Column: {"name": "a", "width": 1, "unit": "m", "text": "Length"},
    Pulley: {"radius": 0.1},
    Initial: {},
    World: {},
    Simulation: {"duration": 1.0},
    cdpr.Scenario: {"robot": "caroca", "simulation": {"duration": 0.01}},
    cdpr.Simulation: {"scenario": "caroca"},
    cdpr.Batch: {"scenario": "caroca", "lanes": 1},
    cdpr.simulate: {"scenario": "caroca"},
    cdpr.rollout: {"scenario": "caroca", "n": 1, "vary": {"controller.kp": [80.0]}},
    trajectory.Knot: {"time": 0.0, "position": [0.0, 0.0, 0.0], "orientation": UPRIGHT},
    trajectory.Limits: {"velocity": 1.0, "acceleration": 1.0, "jerk": 1.0},
    trajectory.Stop: {"position": [0.0, 0.0, 0.0], "orientation": UPRIGHT, "pause": 0.0},
    **{kind: {} for kind in (*EVENTS.values(), *MOTIONS.values())},
}


def names_of(made):
    """Return the names of the arguments of a class or function."""
    if hasattr(made, "model_fields"):
        return [name for name in made.model_fields if name != "type"]
    signature = inspect.signature(made.__init__ if made is cdpr.Scenario else made)
    return [name for name in signature.parameters if name not in ("self", "sections")]


@pytest.mark.parametrize("made", CLASSES, ids=lambda made: made.__qualname__)
def test_an_argument_of_a_wrong_type_is_named(made):
    expected = (TypeError, ValueError) if made is Column else CdprError  # as the interface of plugins documents
    names = names_of(made)
    assert names
    for name, wrong in product(names, (object(), {1}, [object()])):
        try:
            made(**{**CLASSES[made], name: wrong})
            found = "no error"
        except expected as error:
            found = str(error)
        assert name.rstrip("_") in found or (name, "expected a file") == ("scenario", found[:15]), (name, wrong)


@pytest.mark.parametrize("wrong", [5, "post", {"name": "post"}, [5]])
def test_obstacles_of_an_environment(wrong):
    with pytest.raises(CdprError, match=r"Environment\(obstacles=\): expected a tuple of Obstacle, got"):
        Environment(obstacles=wrong)


def test_an_environment_keeps_a_list_of_obstacles_as_tuple():
    post = Obstacle("post", BOX, [0.0, 0.0, 1.0], UPRIGHT)
    assert Environment([post]).obstacles == (post,)
    assert post.position.dtype == np.float64


@pytest.mark.parametrize("verb", [cdpr.simulate, cdpr.Simulation, cdpr.size, cdpr.compare])
@pytest.mark.parametrize("wrong", [0, False, np.zeros(2)])
def test_overrides_that_count_as_false_are_no_overrides(verb, wrong):
    with pytest.raises(CdprError, match="overrides: expected"):
        verb("caroca", overrides=wrong)


def test_plugins_by_arrays():
    with pytest.raises(CdprError, match="solver: expected a name or a class"):
        cdpr.Simulation("caroca", solver=np.zeros(2))


class Tensor:
    """Numbers of a package that refuses to convert them."""

    def __array__(self, *_, **__):
        raise RuntimeError("requires grad")


def test_numbers_that_cannot_be_converted():
    endless = []
    endless.append(endless)
    with pytest.raises(CdprError, match=r"Cable\(frame=\): expected numbers: requires grad"):
        model.Cable(Tensor(), [0.0, 0.0, 0.0])
    for made in (lambda: model.Cable(endless, [0.0, 0.0, 0.0]), lambda: model.Frame(edges=endless)):
        with pytest.raises(CdprError, match=r"\((frame|edges)=\): expected numbers: "):
            made()
