"""`cdpr info`, and what it rests on: restraint, conditioning, positive null vectors, motions checked beforehand."""

from __future__ import annotations

import dataclasses
import json
import re

import numpy as np
import pytest
from click.testing import CliRunner
from conftest import GRAVITY, ROOT, crossed_box, make_robot
from scipy.optimize import linprog

from cdpr import simulate
from cdpr.analysis.distribution.describe import describe_pose
from cdpr.base.errors import CdprError, OutputError, ScenarioError
from cdpr.mechanics.kinematics import make_state, wrench_matrix
from cdpr.mechanics.properties import conditioning, free_wrench_matrix, home_pose, unresisted
from cdpr.mechanics.restraint import restraint
from cdpr.model import rotations
from cdpr.scenario import load_robot, load_scenario
from cdpr.tension.closure import positive_null_vector
from cdpr.ui.cli.info import command
from cdpr.ui.report.text.description import lines
from cdpr_solvers.options import QpOptions
from cdpr_solvers.qp import MinimumNorm

SCENARIOS = ROOT / "scenarios"


def info(*arguments, code=0):
    result = CliRunner().invoke(command, [str(a) for a in arguments], catch_exceptions=False)
    assert result.exit_code == code, result.output
    return result


def figures(*arguments):
    return json.loads(info(*arguments, "--json").stdout)


def largest_margin(W):
    """The largest s with W t = 0, s <= t <= 1, by scipy: positive if and only if a positive null vector exists."""
    n, m = W.shape
    A = np.hstack([-np.eye(m), np.ones((m, 1))])
    W0 = np.hstack([W, np.zeros((n, 1))])
    answer = linprog([0.0] * m + [-1.0], A, np.zeros(m), W0, np.zeros(n), [(0, 1)] * m + [(None, 1)])
    return -answer.fun


@pytest.mark.slow
def test_positive_null_vectors_agree_with_a_linear_program():
    rng = np.random.default_rng(3)
    found = {True: 0, False: 0}
    for _ in range(400):
        n = int(rng.integers(1, 7))
        W = rng.normal(size=(n, int(rng.integers(1, n + 8))))
        if rng.random() < 0.3:
            W[-1] = W[0]  # rank-deficient
        t, margin = positive_null_vector(W), largest_margin(W)
        assert (t is not None) == (margin > 1e-7), margin
        found[t is not None] += 1
        if t is not None:
            assert t.min() >= 1.0
            np.testing.assert_allclose(W @ t, 0.0, atol=1e-9 * t.max())
    assert min(found.values()) > 50


@pytest.mark.parametrize(("m", "kind"), [(5, "IRPM"), (6, "IRPM"), (7, "CRPM"), (8, "RRPM")])
def test_restraint_by_number(m, kind):
    assert restraint(make_robot(crossed_box(np.random.default_rng(0), m))) == kind


def test_conditioning_is_free_of_the_unit_of_length():
    anchors = crossed_box(np.random.default_rng(1), 8)
    state = make_state([0.1, 0.0, 2.0], rotations.from_rpy(0.1, 0.2, 0.3))
    large = np.concatenate([1000.0 * state[:3], state[3:]])
    W = free_wrench_matrix(make_robot(anchors), state)
    rank, condition = conditioning(W)
    assert rank == 6
    assert condition == pytest.approx(np.linalg.cond(W), rel=1e-12)
    assert conditioning(free_wrench_matrix(make_robot(1000.0 * anchors), large))[1] == pytest.approx(condition)


def test_a_point_in_the_line_of_its_cables_is_singular():
    anchors = np.array([[-1.0, 0, 0, 0, 0, 0], [1.0, 0, 0, 0, 0, 0]])
    assert conditioning(free_wrench_matrix(make_robot(anchors), make_state([0, 0, 0]))) == (1, np.inf)


@pytest.mark.parametrize(
    ("name", "constraint"),
    [
        ("caroca", "suspended"),
        ("cogiro", "suspended"),
        ("thesis", "suspended"),
        ("point_mass", "suspended"),
        ("ipanema_1", "fully constrained"),
        ("planar", "fully constrained"),
        ("planar_point_mass", "fully constrained"),
        ("carriage", "fully constrained"),
    ],
)
def test_repository_robots_at_home(name, constraint):
    told = figures(SCENARIOS / "robots" / f"{name}.yaml")
    robot, pose = told["robot"], told["pose"]
    assert pose["source"] == "home"
    assert pose["constraint"] == constraint
    assert pose["rank"] == robot["n"]
    tension = np.array(pose["static_tension_N"])
    assert pose["static_problem"] is None
    W = free_wrench_matrix(load_robot(SCENARIOS / "robots" / f"{name}.yaml"), make_state(pose["position_m"]))
    weight = np.linalg.norm(W @ tension) / 9.81
    assert weight == pytest.approx(robot["platform"]["mass_kg"] if "z" in robot["dof"] else 0.0, rel=1e-3, abs=1e-9)


def test_text_of_cogiro():
    text = info(SCENARIOS / "robots" / "cogiro.yaml").stdout
    for expected in (
        "n = 6: x, y, z, rx, ry, rz (3R3T)",
        "m = 8, redundancy r = m - n = 2",
        "RRPM: redundantly restrained positioning mechanism, m > n + 1",
        "at [0, 0, 2] m, upright (home)",
        "suspended: no t > 0 has W t = 0",
        "moments divided by the characteristic length, 0.944 m",
        "337.66 to 387.27 N",
    ):
        assert expected in text
    assert max(map(len, text.splitlines())) <= 120


def test_pose_from_the_command_line():
    told = figures(SCENARIOS / "robots" / "cogiro.yaml", "--pose", "-1,0.5,2,0.1,-0.1,0.3")["pose"]
    assert told["position_m"] == [-1.0, 0.5, 2.0]
    np.testing.assert_allclose(told["orientation_wxyz"], rotations.from_rpy(0.1, -0.1, 0.3))
    assert (
        "roll pitch yaw [0.1, -0.1, 0.3] rad (--pose)"
        in info(SCENARIOS / "robots" / "cogiro.yaml", "--pose", "-1,0.5,2,0.1,-0.1,0.3").stdout
    )


@pytest.mark.parametrize("pose", ["1,2", "a,b,c", "0,0,nan", "0,0,1,0.1,0,0", ""])
def test_a_bad_pose_is_one_clear_error(pose):
    result = info(SCENARIOS / "robots" / "planar.yaml", "--pose", pose, code=2)
    assert "--pose" in result.stderr
    assert "expected" in result.stderr or "x, z, ry only" in result.stderr


def test_bad_files():
    with pytest.raises(ScenarioError, match=r"nothing\.yaml"):
        info("nothing.yaml")
    with pytest.raises(ScenarioError, match=r"home.orientation: may differ from upright only about"):
        info(SCENARIOS / "robots" / "planar.yaml", "--set", "home.orientation.rpy=[0.1, 0, 0]")
    with pytest.raises(CdprError, match="cable 'cable_1' has no length"):
        info(SCENARIOS / "robots" / "point_mass.yaml", "--pose", "20,0,12")


def test_home_where_the_file_has_none():
    anchors = np.zeros((4, 6))
    anchors[:, :3] = [[-2, -2, 3], [2, -2, 3], [2, 2, 3], [-2, 2, 3]]
    pose, source = home_pose(make_robot(anchors))
    np.testing.assert_allclose(pose, [0, 0, 3 - 0.25 * np.sqrt(32), 1, 0, 0, 0])  # no cable lifts from its own level
    assert "below the middle" in source
    anchors[:2, 2] = 0.0
    pose, source = home_pose(make_robot(anchors))
    np.testing.assert_allclose(pose[:3], [0, 0, 1.5])
    assert source == "no home given: middle of the frame's anchors"


@pytest.mark.parametrize(
    ("anchors", "limits", "reason"),
    [
        ([[-1, 0, 2], [1, 0, 2]], (1, 5), "only tensions of .* N balance the weight"),
        ([[-1, 0, -2], [1, 0, -2]], (1, 500), "only by cables that push"),
        ([[-1, 0, 0], [1, 0, 0]], (1, 500), "not even pushing ones"),
    ],
)
def test_why_there_are_no_static_tensions(anchors, limits, reason):
    robot = make_robot(np.hstack([anchors, np.zeros((2, 3))]), mass=10.0, limits=limits)
    robot = robot.replace(dof=("x", "z"))
    pose = describe_pose(robot, np.array([0.0, 0, 0, 1, 0, 0, 0]), GRAVITY, MinimumNorm(robot, QpOptions()).solve)
    assert pose["static_tension_N"] is None
    assert re.search(reason, pose["static_problem"])


@pytest.mark.parametrize(("duration", "cut"), [(1, True), (7, False)])
def test_a_motion_that_the_run_does_not_finish_is_reported(duration, cut):
    text = info(SCENARIOS / "cogiro.yaml", "--set", f"simulation.duration={duration}").stdout
    assert f"motion: quintic, {duration} s" in text
    assert ("of the 6 s until it ends: simulation.duration stops it on its way" in text) == cut


def test_the_end_of_a_motion_is_shown_if_the_run_is_longer():
    """The end of a G-code motion follows from its limits, so that no file contains it."""
    scenario = load_scenario(SCENARIOS / "gcode.yaml", overrides={"simulation.duration": 60.0})
    text = info(SCENARIOS / "gcode.yaml", "--set", "simulation.duration=60").stdout
    assert f"motion: gcode, 60 s (it ends at {scenario.planned.end:.6g} s), " in text
    assert "(it ends" not in info(SCENARIOS / "caroca.yaml", "--set", "trajectory={type: hold}").stdout


def test_a_preview_agrees_with_the_run():
    told = figures(SCENARIOS / "cogiro.yaml")["motion"]
    run = simulate(SCENARIOS / "cogiro.yaml")
    assert told["feasible_share"] == 1.0
    assert told["duration_s"] == 7.0
    assert told["smallest_margin_N"] == pytest.approx(run.margin.min(), abs=0.01)
    way = np.linalg.norm(np.diff(run.position, axis=0), axis=1).sum()
    assert told["path_length_m"] == pytest.approx(way, rel=1e-4)
    assert told["speed_max_m_per_s"] == pytest.approx(np.linalg.norm(run.velocity, axis=1).max(), rel=1e-3)
    for i, cable in enumerate(told["cables"]):
        np.testing.assert_allclose(cable["length_m"], [run.length[:, i].min(), run.length[:, i].max()], atol=1e-4)
        np.testing.assert_allclose(cable["tension_N"], [run.tension[:, i].min(), run.tension[:, i].max()], atol=0.1)


def test_exceeded_limits_and_infeasible_samples_are_named():
    slow = ["--set", "robot.cables[0].speed_max=1", "--set", "robot.cables[1].length.max=20"]
    told = figures(SCENARIOS / "point_mass.yaml", *slow)["motion"]
    assert [text.split(" (")[0][:56] for text in told["exceeded"]] == [
        "cables longer than allowed: cable_2 up to 28.36 of 20 m",
        "cables wound faster than allowed: cable_1 up to 3.288 of",
    ]
    text = info(SCENARIOS / "point_mass.yaml", *slow, "--set", "robot.tension.max=190").stdout
    assert "exceeded: cables wound faster than allowed: cable_1 up to 3.288 of 1 m/s (" in text
    assert "first not at 0 s" in text
    assert "none: only tensions of" in text
    assert "fastest (m/s)        1, unknown, unknown" in text


def test_out_holds_a_drawing_and_the_figures(tmp_path):
    pytest.importorskip("matplotlib")
    folder = tmp_path / "new" / "folder"
    text = info(SCENARIOS / "planar.yaml", "--out", folder).stdout
    assert text.splitlines()[-1] == str(folder / "robot.svg")
    svg = (folder / "robot.svg").read_text()
    assert svg.startswith("<svg xmlns=")
    assert ">path<" in svg
    assert json.loads((folder / "info.json").read_text()) == figures(SCENARIOS / "planar.yaml")
    info(SCENARIOS / "robots" / "planar.yaml", "--out", folder, "--force")
    assert ">path<" not in (folder / "robot.svg").read_text()
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="cannot be written"):
        info(SCENARIOS / "robots" / "planar.yaml", "--out", tmp_path / "file")


CONCURRENT = """\
platform: {mass: 1, inertia: [1, 1, 1, 0, 0, 0]}
tension: {min: 0.0001, max: 1000}
cables:
- {frame: [1, 0, 2], platform: [0, 0, 0]}
- {frame: [-1, 0, 2], platform: [0, 0, 0]}
- {frame: [0, 1, 2], platform: [0, 0, 0]}
- {frame: [0, -1, 2], platform: [0, 0, 0]}
- {frame: [0, 0, 3], platform: [0, 0, 0]}
- {frame: [0.3, 0.4, -2], platform: [0, 0, 0.3]}
"""


def test_the_motion_that_meets_no_resistance_is_named(tmp_path):
    (tmp_path / "r.yaml").write_text(CONCURRENT)
    text = info(tmp_path / "r.yaml", "--pose", "0,0,0.5").stdout
    assert "  rank of W            4 of n = 6\n" in text
    assert text.count("no resistance to") == 2
    assert "no resistance to     turning about z: it changes no cable's length" in text
    assert "no resistance to     turning about x at 0.75 rad/s, y at 1 rad/s: it changes no cable's length" in text


@pytest.mark.parametrize("dof", [("x", "y", "z", "rx", "ry", "rz"), ("x", "z", "ry"), ("x", "y", "z")])
def test_twists_that_change_no_length(dof):
    """As many as the rank leaves, independent of each other, and the lengths' rates under them are round-off."""
    rng = np.random.default_rng(2)
    for _ in range(50):
        anchors = np.hstack([rng.normal(size=(4, 3)), 0.2 * rng.normal(size=(4, 3))])
        if "y" not in dof:
            anchors[:, [1, 4]] = 0.0
        anchors[1:3, 3:] = anchors[0, 3:]
        anchors[2] = anchors[rng.integers(2)]
        robot = dataclasses.replace(make_robot(anchors), dof=dof)
        state = make_state(np.array([0.3, 0.0, 0.2]))
        W = free_wrench_matrix(robot, state)
        twists = np.array(unresisted(W, robot)).reshape(-1, 6)
        full = wrench_matrix(robot, state)
        assert len(twists) == robot.n - conditioning(W)[0] == np.linalg.matrix_rank(twists)
        assert np.abs(full.T @ twists.T).max(initial=0.0) < 1e-6
        assert not np.delete(twists, robot.rows, axis=1).any()


@pytest.mark.slow
def test_a_preview_regards_events():
    """A push is balanced, a broken cable is left out, changed limits hold, a stop shortens the path."""
    events = (
        "events=[{type: wrench, time: 0.2, duration: 0.3, force: [300, 0, 0]}, {type: cable_break, time: 1.0, "
        "cable: cable_2, detected_after: 0.1}, {type: limits, time: 2.0, max: 5000}, "
        "{type: emergency_stop, time: 2.5}]"
    )
    motion = figures(SCENARIOS / "caroca.yaml", "--set", events)["motion"]
    calm = figures(SCENARIOS / "caroca.yaml")["motion"]
    assert motion["events"] == ["wrench at 0.2 s", "cable_break at 1 s", "limits at 2 s", "emergency_stop at 2.5 s"]
    assert motion["cables"][1]["tension_N"][0] == 0.0
    assert motion["smallest_margin_N"] > 0.0  # the broken cable does not count
    assert motion["path_length_m"] < calm["path_length_m"] - 0.005
    assert max(cable["tension_N"][1] for cable in motion["cables"][2:]) > 450.0
    text = info(SCENARIOS / "caroca.yaml", "--set", events).stdout
    assert "  with its events      wrench at 0.2 s, cable_break at 1 s, limits at 2 s, emergency_stop at 2.5 s" in text
    tight = events.replace("max: 5000", "max: 300")
    assert figures(SCENARIOS / "caroca.yaml", "--set", tight)["motion"]["first_infeasible_s"] == pytest.approx(2.0)


def test_small_tensions_are_not_shown_as_none(tmp_path):
    (tmp_path / "r.yaml").write_text(CONCURRENT.replace("[0.3, 0.4, -2]", "[0, 0, -3]"))
    lines = info(tmp_path / "r.yaml", "--pose", "0,0,0.5").stdout.splitlines()
    assert [line.split()[-1] for line in lines if line.startswith("  cable_6")] == ["0.0001"]


def test_tensions_are_reported_without_their_rounding():
    told = figures(ROOT / "scenarios" / "robots" / "ipanema_1.yaml")
    told["pose"]["static_tension_N"] = [160.32, *[3.7303e-14] * (told["robot"]["m"] - 1)]  # as solvers leave them
    text = "\n".join(lines(told))
    assert "e-14" not in text
    assert "0 to 160.32 N" in text
