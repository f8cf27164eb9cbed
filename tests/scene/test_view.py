"""View model: courses of cables, their drawing, and colours that all readers can distinguish."""

from __future__ import annotations

import re
from itertools import combinations

import numpy as np
import pytest
from conftest import ROOT
from report_cases import LED, diverged_run, infeasible_run, make_run

import cdpr
from cdpr.model import rotations
from cdpr.scenario import load_robot, load_scenario
from cdpr.scene import State, Subject, colours, pictures, solid
from cdpr.scene.path import thinned
from cdpr.scene.pictures import weight_range
from cdpr.scene.shapes import radius_around
from cdpr.simulation.header import desired_path
from cdpr.ui.report.player.arrays import Arrays
from cdpr.ui.report.player.scenes import scene
from cdpr.ui.report.plots.pictures import MOST, frames, pictures_of

CONTRAST = 3.0  # WCAG 2.1, 1.4.11: graphical objects
# Of OKLab: colours this far apart are seen as different side by side and apart; the step to the next shade is 0.02.
APART, STEP = 0.1, 0.02
GROUNDS = ("light", "dark")
# Contrast of a curve with a shade it crosses: beside it, on the background, it has CONTRAST. A shade from
# which all had that would be the ground.
ACROSS = 2.0


SHADES = tuple(colours.SHADES.values())
UNDER = {colours.GROUND, colours.BODY, *colours.BEHIND, *SHADES}
# All other colours of the table, so that none is forgotten.
DRAWN = [
    pair
    for value in vars(colours).values()
    for pair in ([value] if isinstance(value, colours.Pair) else value if isinstance(value, tuple) else ())
    if isinstance(pair, colours.Pair) and pair not in UNDER
]


def linear(colour):
    encoded = np.array(colours.parts(colour))
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def contrast(a, b):
    """Contrast of two colours as WCAG 2.1 defines it."""
    low, high = sorted(float(linear(colour) @ (0.2126, 0.7152, 0.0722)) for colour in (a, b))
    return (high + 0.05) / (low + 0.05)


# Machado, Oliveira, Fernandes (2009), deuteranomaly of severity 1.0, on linear red, green and blue.
DEUTERANOPIA = np.array(
    [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
)


def lab(rgb):
    return np.linalg.inv(colours._CONES) @ np.cbrt(np.linalg.inv(colours._SRGB) @ rgb)


@pytest.mark.parametrize("ground", GROUNDS)
def test_all_colours_contrast_with_their_ground(ground):
    paper = getattr(colours.GROUND, ground)
    drawn = [getattr(pair, ground) for pair in DRAWN] + colours.tension_steps(ground)
    assert min(contrast(colour, paper) for colour in drawn) >= CONTRAST


@pytest.mark.parametrize("ground", GROUNDS)
def test_hidden_surfaces_and_shades_are_correct(ground):
    def shown(pairs):
        return [getattr(pair, ground) for pair in pairs]

    for behind in shown((*colours.BEHIND, *colours.SHADES.values())):
        assert min(contrast(colour, behind) for colour in shown(DRAWN)) >= ACROSS
    assert min(contrast(*shown((colours.INK, fill))) for fill in (*colours.SHADES.values(), colours.BODY)) >= CONTRAST
    shades, paper = ([lab(linear(colour)) for colour in shown(pairs)] for pairs in (SHADES, [colours.GROUND]))
    assert min(np.linalg.norm(shade - paper[0]) for shade in shades) > APART
    assert min(np.linalg.norm(a - b) for a, b in combinations(shades, 2)) > 2.0 * STEP


def test_figures_and_pages_have_no_colours_of_their_own():
    """Those of the colour table alone are held against their grounds; a page's style sheets colour what is around."""
    report = ROOT / "cdpr" / "ui" / "report"
    files = [*report.rglob("*.py"), *report.rglob("*.js")]
    assert len(files) > 50
    own = {file.name: re.findall(r"""["']#[0-9a-fA-F]{3,8}["']""", file.read_text()) for file in files}
    assert {name: found for name, found in own.items() if found} == {}


@pytest.mark.parametrize("ground", GROUNDS)
@pytest.mark.parametrize("seen", [np.eye(3), DEUTERANOPIA], ids=["all", "deuteranopia"])
def test_cables_are_distinguished(ground, seen):
    places = [lab(np.clip(seen @ linear(getattr(pair, ground)), 0.0, 1.0)) for pair in colours.CABLES]
    assert min(np.linalg.norm(a - b) for a, b in combinations(places, 2)) > APART


@pytest.mark.parametrize("ground", GROUNDS)
def test_larger_tensions_have_more_contrast(ground):
    """For all readers: lightness goes one way."""
    paper = getattr(colours.GROUND, ground)
    steps = [contrast(colour, paper) for colour in colours.tension_steps(ground)]
    assert (np.diff(steps) > 0.0).all()


def test_cables_run_from_the_frame_to_the_platform():
    run = make_run(rows=20)
    shown = pictures_of(run)
    anchors = np.array(run.header.anchors)
    for k in (0, 7, 19):
        R = rotations.matrix(run.orientation[k])
        assert shown.ends[k, :, 0] == pytest.approx(anchors[:, :3])
        assert shown.ends[k, :, 1] == pytest.approx(run.position[k] + anchors[:, 3:] @ R.T)
    assert shown.force is None  # none acts


def test_a_run_that_diverged_is_coloured_by_what_came_before():
    low, high = pictures_of(diverged_run()).range
    assert 0.0 < low < high < 1e4


def test_with_pulleys_cables_leave_where_they_do():
    robot = load_robot(str(ROOT / "scenarios" / "robots" / "cogiro_pulleys.yaml"))
    subject = Subject.of_robot(robot)
    assert robot.home is not None
    (ends,) = subject.ends(robot.home[None, :3], robot.home[None, 3:7])
    away = np.linalg.norm(ends[:, 0] - robot.anchors[:, :3], axis=1)
    radii = np.array([cable.exit.radius for cable in robot.cables])
    assert (away > 0.0).all()
    assert (away <= 2.0 * radii).all()
    assert len(subject.exit_lines(ends)) == len(robot.cables)


def test_states_of_cables():
    run = make_run(rows=4, limits=(20.0, 650.0))
    subject = run.header.subject
    t = np.array([0.0, 1.0, 2.0, 3.0])
    tension = np.full((4, 8), 100.0)
    tension[1, 0], tension[1, 1], tension[1, 2], tension[3, 1] = 20.0, 650.0, 0.0, 650.0
    broken = Subject(**{**vars(subject), "broken": ((3, 2.0),)})
    pose = run.position, run.orientation
    found = pictures(broken, t, *pose, tension=tension, limits_until=2.5).state
    assert found[1, :4].tolist() == [State.LOWEST, State.HIGHEST, State.SLACK, State.TAUT]
    assert found[:, 3].tolist() == [State.TAUT, State.TAUT, State.BROKEN, State.BROKEN]
    assert found[3, 1] == State.TAUT  # the limit that was known then holds no more
    # A winch may give other than it was commanded: what is at a limit is the command, what is slack the cable.
    command = np.full((4, 8), 650.0)
    assert pictures(subject, t, *pose, tension=tension, command=command).state[1, 2] == State.SLACK
    assert pictures(subject, t, *pose, tension=tension, command=command).state[0, 0] == State.HIGHEST


def test_legs_that_push_are_not_slack():
    run = make_run(rows=2, limits=(-1000.0, 1000.0))
    tension = np.full((2, 8), -200.0)
    tension[1, 0] = -1000.0
    found = pictures(run.header.subject, run.time, run.position, run.orientation, tension=tension).state
    assert (found[0] == State.TAUT).all()
    assert found[1, 0] == State.LOWEST


def test_the_range_of_colours_is_that_of_cables_that_pull():
    run = make_run(rows=3)
    tension = np.full((3, 8), 100.0)
    tension[0, 0], tension[1, 1], tension[2, 2] = 0.0, 40.0, np.nan
    assert pictures(run.header.subject, run.time, run.position, run.orientation, tension=tension).range == (40.0, 100.0)


@pytest.mark.parametrize("shape", [{"box": [1.0, 2.0, 3.0]}, {"sphere": 0.5}, {"cylinder": [0.5, 2.0]}])
def test_solids_are_closed_and_look_outwards(shape):
    body = solid(shape)
    a, b, c = (body.vertices[body.triangles[:, i]] for i in range(3))
    volume = float(np.sum(np.cross(a, b) * c)) / 6.0  # of the tetrahedra to the origin
    exact = {"box": 6.0, "sphere": np.pi / 6.0, "cylinder": np.pi / 2.0}[next(iter(shape))]
    assert volume == pytest.approx(exact, rel=0.02)  # of round ones corners are cut
    edges = [tuple(pair) for triangle in body.triangles for pair in zip(triangle, np.roll(triangle, -1), strict=True)]
    assert len(set(edges)) == len(edges)
    assert {(j, i) for i, j in edges} == set(edges)  # each edge once in each direction
    assert radius_around(shape, np.zeros((1, 3))) == pytest.approx(np.linalg.norm(body.vertices, axis=1).max())


def test_of_a_mesh_the_box_around_it():
    body = solid({"mesh": [[0.0, 0.0, 1.0], [1.0, 2.0, 3.0]]})
    assert body.vertices.min(axis=0).tolist() == [0.0, 0.0, 1.0]
    assert body.vertices.max(axis=0).tolist() == [1.0, 2.0, 3.0]
    assert solid(None) is None


@pytest.mark.slow
def test_rows_that_are_drawn_are_few_and_hold_each_event():
    run = infeasible_run()
    rows = frames(run)
    assert rows[0] == 0
    assert rows[-1] == len(run.rows) - 1
    assert (np.diff(rows) > 0).all()
    assert len(rows) < 60 * 4 + 12  # no more than 60 a second, and two an event
    assert {899, 900, 1299, 1300, 3199, 3200} <= set(rows.tolist())
    assert len(frames(make_run(rows=100_000))) <= MOST


@pytest.mark.parametrize(("weight", "tension"), [(1470.0, (82.0, 809.0)), (170.0, (21.0, 117.0))])
def test_the_range_that_is_known_before_a_run_holds_usual_tensions_apart(weight, tension):
    """Tensions of CAROCA of 150 kg and of the thesis's 17 kg, from 1 or 50 N to 10 kN: not all in one colour."""
    subject = make_run(rows=2, limits=(1.0, 10_000.0)).header.subject
    low, high = weight_range(subject, weight)
    shares = np.log(np.array(tension) / low) / np.log(high / low)
    assert 0.0 < shares[0] < shares[1] < 1.0
    assert shares[1] - shares[0] > 0.25


def test_the_desired_path_of_a_long_run_keeps_its_corners():
    """Around a square, with a stop at each corner, for minutes."""
    corners = [[0.4, 0.4, 1.0], [-0.4, 0.4, 1.0], [-0.4, -0.4, 1.0], [0.4, -0.4, 1.0]]
    limits = {"velocity": 0.5, "acceleration": 1.0, "jerk": 5.0}
    motion = {"type": "jerk_limited", "points": [{"position": corners[k % 4]} for k in range(1, 101)], "limits": limits}
    changes = {"trajectory": motion, "initial.position": corners[0], "simulation.duration": 300.0}
    path = np.array(desired_path(load_scenario(ROOT / "scenarios" / "caroca.yaml", overrides=changes)))
    for corner in corners:
        assert np.linalg.norm(path - corner, axis=1).min() < 1e-3


def test_of_a_tool_that_is_led_the_way_is_drawn():
    """In reports, pages, logs and windows: it is straight, where the origin's is not."""
    run = cdpr.simulate(ROOT / "scenarios" / "caroca.yaml", overrides=LED)
    shown = pictures_of(run)
    np.testing.assert_allclose(shown.way, run.tool("nozzle"), atol=1e-12)
    assert np.abs(shown.way - shown.desired_way).max() < 1e-4
    path = np.array(run.header.path)
    np.testing.assert_allclose(path[[0, -1]], shown.desired_way[[0, -1]], atol=1e-6)
    straight = (path[-1] - path[0]) / np.linalg.norm(path[-1] - path[0])
    assert np.abs(np.cross(path - path[0], straight)).max() < 1e-5
    drawn = scene(shown, Arrays())
    assert (drawn["led"], list(drawn["tools"])) == ("nozzle", ["nozzle", "eye"])
    low, high = drawn["bounds"]
    assert np.all(np.array(low) <= path.min(axis=0) + 1e-6)
    assert np.all(np.array(high) >= path.max(axis=0) - 1e-6)
    assert run.header.from_dict(run.header.to_dict()).tool == "nozzle"


def test_a_path_keeps_its_corners_and_no_more():
    t = np.linspace(0.0, 1.0, 50)[:, None]
    legs = np.concatenate([t * [1.0, 0.0, 0.0], [1.0, 0.0, 0.0] + t * [0.0, 2.0, 0.0]])
    assert thinned(legs, 1e-9).tolist() == [[0, 0, 0], [1, 0, 0], [1, 2, 0]]
    circle = np.stack([np.cos(6.3 * t[:, 0]), np.sin(6.3 * t[:, 0]), 0.0 * t[:, 0]], axis=1)
    few = thinned(circle, 0.02)
    assert len(few) < 25
    there = np.linspace(few[:-1], few[1:], 20).reshape(-1, 3)
    assert np.linalg.norm(circle[:, None] - there, axis=2).min(axis=1).max() < 0.03
