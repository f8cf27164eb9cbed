"""How far a platform can turn: against margins at the ends, and in a file and a command."""

from __future__ import annotations

import json

import numpy as np
import pytest
from workspace_cases import cli, robot_of

from cdpr.analysis.workspace.answers import margin
from cdpr.analysis.workspace.export import export
from cdpr.analysis.workspace.regions import region
from cdpr.analysis.workspace.result import load_workspace, workspace
from cdpr.analysis.workspace.turns import HALVINGS, STEP
from cdpr.base.errors import CdprError
from cdpr.model import rotations

# rad: to which an end is known.
NEAR = 1.01 * STEP / 2**HALVINGS


@pytest.mark.parametrize(("name", "about"), [("cogiro", "rz"), ("cogiro", "rx"), ("ipanema_1", "ry"), ("planar", "ry")])
def test_ends_are_where_the_margin_is_lost(name, about):
    robot = robot_of(name)
    found = workspace(robot, "static", region(robot, cells=7), method="turns", about=about)
    turns, inside = found.detail, found.inside
    assert inside.any()
    assert np.array_equal(np.isfinite(turns.least), inside)
    axis = np.eye(3)[["rx", "ry", "rz"].index(about)]
    places = np.stack(np.meshgrid(*found.region.axes, indexing="ij"), axis=-1)[inside]
    for end, sign in ((turns.least[inside], -1.0), (turns.most[inside], 1.0)):
        assert (sign * end >= 0.0).all()
        stops = np.abs(end) < np.pi - NEAR
        for angle, held in ((end, True), (end + sign * NEAR, False), (0.5 * end, None)):
            turned = [
                rotations.multiply(rotations.from_axis_angle(axis, a), found.region.orientations[0]) for a in angle
            ]
            value = margin(robot, np.hstack([places, turned]), found.question)
            at = value.value >= -1e-9 * value.scale
            if held is not None:
                assert (at[stops] == held).all()
        assert stops.any()


def test_free_turns_end_at_half_a_turn():
    robot = robot_of("cogiro")
    found = workspace(robot, "dexterity", region(robot, cells=3), method="turns")
    assert found.detail.figures() == {"about": "rz", "everywhere": np.pi, "mean": pytest.approx(np.pi), "best": np.pi}


def test_a_file_holds_turns_and_others_read_them(tmp_path):
    robot = robot_of("cogiro")
    found = workspace(robot, "static", region(robot, cells=6), method="turns")
    found.save(tmp_path / "w.npz")
    read = load_workspace(tmp_path / "w.npz")
    assert read.summary() == found.summary()
    assert np.array_equal(read.detail.most, found.detail.most, equal_nan=True)
    assert found.volume == found.inside.sum() * found.region.cell
    export(found, tmp_path / "w.vti")
    assert b'Name="turn_most"' in (tmp_path / "w.vti").read_bytes()


@pytest.mark.slow
def test_the_command_and_what_is_refused():
    asked = ("workspace", "static", "scenarios/robots/cogiro.yaml", "--method", "turns", "--cells", "8")
    told = cli(*asked, "--about", "ry", "--json")
    assert json.loads(told.stdout)["found"]["about"] == "ry"
    assert "turns about rz" in cli(*asked).stdout
    told = cli("workspace", "static", "scenarios/robots/cogiro.yaml", "--about", "rx")
    assert (told.returncode, "--method turns" in told.stderr) == (2, True)
    point, robot = robot_of("point_mass"), robot_of("cogiro")
    with pytest.raises(CdprError, match="this robot does not turn"):
        workspace(point, "static", region(point, cells=3), method="turns")
    with pytest.raises(CdprError, match="expected one of rx, ry, rz"):
        workspace(robot, "static", region(robot, cells=3), method="turns", about="yaw")
    two = region(robot, cells=3, orientations=[[1.0, 0, 0, 0], [0.0, 0, 0, 1]])
    with pytest.raises(CdprError, match="turns begin in one attitude"):
        workspace(robot, "static", two, method="turns")
