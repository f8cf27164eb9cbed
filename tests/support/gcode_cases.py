"""Scenarios around G-code files, and the paths they lead along."""

from __future__ import annotations

import os

import numpy as np
import pytest
from scenario_cases import PLUGINS, ROBOT, changed, whole

from cdpr.base.errors import ScenarioError
from cdpr.scenario import Gcode, load_scenario

BEGIN = np.array([0.0, 0.1, 1.2])  # the initial position of the scenario around it
MOTION = "trajectory: {type: gcode, file: a.ngc, limits: {velocity: 1, acceleration: 2, jerk: 20}}\n"
HEAD = "G21 G90 F6000\nG0 X0 Y0 Z1000\n"  # mm, 100 mm/s
PRINTER = ", dialect: reprapfirmware"
PLANAR = changed(ROBOT, "dof: [x, y, z, rx, ry, rz]", "dof: [x, z, ry]")


def read(folder, text, keys="", robot=ROBOT):
    """Load a scenario around a file with this text, and more keys of its motion."""
    content = text if isinstance(text, bytes) else text.encode()
    (folder / "a.ngc").write_bytes(content)
    given = whole(changed(MOTION, "a.ngc", f"a.ngc{keys}"), robot)
    if robot is PLANAR:
        given = changed(given, "angular_velocity: [0, 0.1, 0]", "angular_velocity: [0, 0, 0]")
    return load_scenario(folder / "a.yaml", text=given, plugins=PLUGINS)


def refused(folder, text, keys="", robot=ROBOT):
    """Return the lines of the error, without the folder."""
    with pytest.raises(ScenarioError) as caught:
        read(folder, text, keys, robot)
    return str(caught.value).replace(f"{folder}{os.sep}", "").splitlines()


def course(folder, text, keys=""):
    """Return what is to be followed."""
    motion = read(folder, text, keys).trajectory
    assert isinstance(motion, Gcode)
    return motion._path(tuple(BEGIN)).course


def points(folder, text, keys=""):
    """Return the ends of all moves in mm, without the first one's beginning, which is the initial position."""
    pieces = course(folder, text, keys).pieces
    every = np.arange(len(pieces))
    begin, end = (pieces.at(every, share * pieces.length)[0] for share in (0.0, 1.0))
    np.testing.assert_allclose(begin[0], BEGIN, atol=1e-12)
    np.testing.assert_allclose(begin[1:], end[:-1], atol=1e-12)
    return 1e3 * end


def same(found, *expected):
    np.testing.assert_allclose(found, np.array(expected, dtype=float), atol=1e-9)
