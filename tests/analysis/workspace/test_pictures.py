"""Pictures of workspaces: slices, the page, and the command that draws it."""

from __future__ import annotations

import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from workspace_cases import ROBOTS, cli, robot_of

from cdpr.analysis.workspace import region, workspace
from cdpr.analysis.workspace.combine import combine
from cdpr.ui.report.figures import slices
from cdpr.ui.report.pages.workspace import render_workspace

HEADING = re.compile(r"<h2>At ([xyz]) = ([-0-9.e]+) m</h2>")


@pytest.fixture(scope="module")
def robot():
    return robot_of("caroca")


@pytest.fixture(scope="module")
def static(robot):
    return workspace(robot, "static", region(robot, cells=12))


def drawn(found, robot, axis, place):
    """A slice as text that is XML."""
    text = slices.draw(found, robot, axis, place).markup("a slice")
    ElementTree.fromstring(text)
    return text


def test_a_slice_covers_the_cells_that_are_inside():
    cells = np.random.default_rng(3).random((7, 5)) < 0.5
    x, y = np.linspace(-1.0, 2.5, 8), np.linspace(0.0, 1.0, 6)
    rings = slices._rings(cells, x, y)
    area = sum((ring[1, 0] - ring[0, 0]) * (ring[2, 1] - ring[1, 1]) for ring in rings)
    assert area == pytest.approx(cells.sum() * 0.5 * 0.2)
    for i in range(7):
        for j in range(5):
            middle = 0.5 * (x[i] + x[i + 1]), 0.5 * (y[j] + y[j + 1])
            inside = any(r[0, 0] < middle[0] < r[1, 0] and r[0, 1] < middle[1] < r[2, 1] for r in rings)
            assert inside == cells[i, j]


def test_slices_through_different_cells_differ(static, robot):
    assert drawn(static, robot, 2, 0.5) != drawn(static, robot, 2, 3.2)
    assert drawn(static, robot, 2, 0.5) == drawn(static, robot, 2, 0.51)
    assert "capacity margin (N)" in drawn(static, robot, 0, 0.0)


@pytest.mark.parametrize("kind", ["payload", "closure", "stable", "dexterity"])
def test_any_kind_has_a_page(robot, kind):
    found = workspace(robot, kind, region(robot, cells=6))
    text = render_workspace(found, robot)
    assert len(HEADING.findall(text)) == 3
    assert f"caroca: {kind} workspace" in text


def test_of_two_and_of_nothing(static, robot):
    assert "static minus static" in render_workspace(combine(static, "minus", static), robot)


def test_in_a_plane_there_is_one_slice():
    robot = robot_of("planar")
    text = render_workspace(workspace(robot, "static", region(robot, cells=9)), robot)
    assert HEADING.findall(text) == [("y", "0")]
    assert '"region"' not in text


def test_the_same_file_makes_the_same_page(static, robot):
    assert render_workspace(static, robot) == render_workspace(static, robot)


def test_names_are_not_markup(static, robot):
    text = render_workspace(replace(static, robot="<script>x"), robot)
    assert "<script>x" not in text


@pytest.mark.slow
def test_the_command(tmp_path):
    done = cli("workspace", "static", ROBOTS / "caroca.yaml", "--cells", "8", "--out", tmp_path / "w.npz")
    assert done.returncode == 0, done.stderr
    done = cli("workspace", "plot", tmp_path / "w.npz")
    assert (done.returncode, done.stdout) == (0, f"{tmp_path / 'w.html'}\n")
    done = cli(
        *("workspace", "plot", tmp_path / "w.npz", "--slice", "z=1.0", "--slice", "x=-1"),
        *("--out", tmp_path / "b" / "p.html"),
    )
    assert done.returncode == 0, done.stderr
    found = HEADING.findall((tmp_path / "b" / "p.html").read_text())
    assert [axis for axis, _ in found] == ["z", "x"]
    assert [float(at) for _, at in found] == pytest.approx([1.0, -1.0], abs=0.45)  # the cells' middles


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--slice", "up=1"], "expected an axis and a position (m), such as z=1.0, got 'up=1'"),
        (["--slice", "z"], "such as z=1.0, got 'z'"),
        (["--out", "page.svg"], "page.svg: --out: expected the name of a page that ends in .html"),
    ],
)
def test_invalid_words_are_reported(tmp_path, static, words, said):
    static.about["source"] = {"robot": (ROBOTS / "caroca.yaml").read_text(), "changes": [], "file": "caroca.yaml"}
    static.save(tmp_path / "w.npz")
    done = cli("workspace", "plot", tmp_path / "w.npz", *words)
    assert done.returncode in (2, 8)
    assert said in done.stderr


def test_without_the_robot_in_it_a_file_cannot_be_drawn(tmp_path, robot):
    workspace(robot, "static", region(robot, cells=3)).save(tmp_path / "w.npz")
    done = cli("workspace", "plot", tmp_path / "w.npz")
    assert done.returncode == 2
    assert "does not contain the robot" in done.stderr
