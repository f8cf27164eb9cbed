"""Robots own their data: callers' arrays and mappings are checked, copied, and cannot be changed later."""

from __future__ import annotations

import copy
import math
import pickle

import numpy as np
import pytest

import cdpr
from cdpr.model import Box, Cylinder, Frame, Mesh, Sphere, Winch

pytestmark = pytest.mark.core

HUGE = 10**400


def read_only(values):
    array = np.array(values, dtype=np.float64)
    view = array.view()
    view.flags.writeable = False
    return array, view


def cable(**changes):
    return cdpr.Cable(**{"frame": [0.0, 0.0, 1.0], "platform": [0.0, 0.0, 0.0]} | changes)


def platform(**changes):
    return cdpr.Platform(**{"mass": 1.0, "inertia": [1.0, 1.0, 1.0]} | changes)


def robot(**changes):
    return cdpr.Robot(**{"platform": platform(), "cables": [cable()]} | changes)


def test_read_only_arrays_are_checked():
    for make in (
        lambda: cable(frame=read_only([0.0, math.nan, 1.0])[1]),
        lambda: platform(inertia=read_only(np.diag([1.0, math.inf, 1.0]))[1]),
        lambda: robot(home=read_only([0.0, 0.0, 1.0, 3.0, 0.0, 0.0, 0.0])[1]),
        lambda: Frame(read_only([[0.0, 0.0, 0.0, 0.0, 0.0, math.nan]])[1]),
    ):
        with pytest.raises(cdpr.CdprError):
            make()


def test_read_only_arrays_are_copied():
    base, view = read_only([0.0, 0.0, 1.0])
    found = cable(frame=view)
    base[0] = 7.0
    assert found.frame.tolist() == [0.0, 0.0, 1.0]
    base, view = read_only(np.eye(3))
    body = platform(inertia=view)
    base[0, 0] = 7.0
    assert body.inertia[0, 0] == 1.0


def test_a_copy_keeps_the_bits_of_its_home():
    half = math.sqrt(0.5)
    one = robot(home=[0, 0, 1, half, half, 0, 0])
    other = one.replace(name="other")
    assert one.home.tobytes() == other.home.tobytes()


def test_mappings_and_arrays_are_copied_and_cannot_be_changed():
    edges = np.zeros((4, 6))
    frame = Frame(edges)
    edges[0, 0] = 5.0
    assert frame.edges[0, 0] == 0.0
    body = platform(tools={"tip": [0, 0, 1]})
    own = {}
    winch = Winch(drum_radius=0.1, own=own)
    own["b"] = 5
    assert winch.own == {}
    for mapping in (body.tools, cable().own, winch.own):
        with pytest.raises(TypeError, match="cannot be changed"):
            mapping["b"] = 5
        with pytest.raises(TypeError, match="cannot be changed"):
            mapping.clear()
    for other in (copy.deepcopy(body), copy.copy(body), pickle.loads(pickle.dumps(body))):
        assert other == body
        assert not other.tools["tip"].flags.writeable
        with pytest.raises(TypeError, match="cannot be changed"):
            other.tools["b"] = 5


WRONG = {
    "mass": (lambda: platform(mass=HUGE), "Platform(mass=): expected a number greater than 0, got 1000"),
    "tension": (lambda: cable(tension_max=HUGE), "Cable(tension_max=): expected a number of at least 0, got 1000"),
    "digits": (lambda: cable(diameter=10**9999), "Cable(diameter=): expected a number of at least 0, got an int with"),
    "own": (lambda: cable(own=3), "Cable(own=): expected numbers by key, got 3"),
    "own-list": (lambda: cable(own=[1]), "Cable(own=): expected numbers by key, got a list of 1"),
    "own-frame": (lambda: cable(own={"frame": [9, 9, 9]}), "Cable(own=): unknown key 'frame'; allowed: strain_1, "),
    "own-winch": (lambda: Winch(own={"slip": 1.0}), "Winch(own=): unknown key 'slip'; allowed: gear_ratio, "),
    "model": (
        lambda: cable(model="foo"),
        "Cable(model=): expected one of ideal, rigid, elastic, catenary, tabulated, viscoelastic, got 'foo'",
    ),
    "models": (
        lambda: robot(cable_model="foo"),
        "Robot(cable_model=): expected one of ideal, rigid, elastic, catenary, tabulated, viscoelastic",
    ),
    "models-array": (lambda: robot(cable_model=np.zeros(3)), "Robot(cable_model=): expected a text"),
    "frame": (lambda: Frame("abc"), "Frame(edges=): expected real numbers"),
    "frame-shape": (lambda: Frame([[[0, 0, 0, 1, 1, 1]]]), "Frame(edges=): expected any number x 6 numbers, got 1 x 1"),
    "frame-empty": (lambda: Frame(np.zeros((0, 6))), "Frame(edges=): expected at least one edge"),
    "winch": (lambda: Winch(drum_radius="a"), "Winch(drum_radius=): expected a number of at least 0, got 'a'"),
    "winch-negative": (lambda: Winch(inertia=-1.0), "Winch(inertia=): expected a number of at least 0, got -1.0"),
    "winch-type": (
        lambda: Winch(type="rope"),
        "Winch(type=): expected one of torque, position, velocity, stepper, got 'rope'",
    ),
    "box": (lambda: Box("abc"), "Box(size=): expected real numbers"),
    "box-negative": (lambda: Box((1.0, -1.0, 1.0)), "Box(size=): expected a number greater than 0, got -1.0"),
    "sphere": (lambda: Sphere("a"), "Sphere(radius=): expected a number greater than 0, got 'a'"),
    "cylinder": (lambda: Cylinder(1.0, math.nan), "Cylinder(height=): expected a number greater than 0, got nan"),
    "mesh": (lambda: Mesh(3, (0, 0, 0), (1, 1, 1)), "Mesh(file=): expected a text, got 3"),
    "colour": (lambda: platform(colour=3), "Platform(colour=): expected a text, got 3"),
    "colour-name": (lambda: platform(colour="nope"), "Platform(colour=): expected a colour, '#rrggbb' or one of"),
    "tools": (lambda: platform(tools={1: [0, 0, 0]}), "Platform(tools=): expected a text, got 1"),
    "home": (lambda: robot(home=[0, 0, 1, True, 0, 0, 0]), "Robot(home=): expected real numbers, got True or False"),
    "home-shape": (lambda: robot(home=[[0, 0, 1]]), "Robot(home=): expected 3 or 7 numbers, got 1 x 3"),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_arguments(name):
    make, text = WRONG[name]
    with pytest.raises(cdpr.CdprError) as caught:
        make()
    assert text in str(caught.value)


def test_numbers_of_numpy_become_those_of_python():
    assert type(Winch(inertia=np.float32(0.5)).inertia) is float
    assert type(Sphere(np.float32(0.5)).radius) is float
    box = Box(np.array([1.0, 2.0, 3.0]))
    assert box == Box([1, 2, 3]) == Box((1.0, 2.0, 3.0))
    assert box.size == (1.0, 2.0, 3.0)


def test_colours_are_normalised():
    assert platform(colour="red").colour == "#ff0000"
    assert Frame(np.zeros((4, 6)), "#AABBCC").colour == "#aabbcc"
