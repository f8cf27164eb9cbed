"""`cdpr equilibrium`: rests, compensated lengths, files and wrong options."""

from __future__ import annotations

import csv
import json
import re

import numpy as np
import pytest
from click.testing import CliRunner
from conftest import ROOT

import cdpr
from cdpr.base.errors import CdprError
from cdpr.ui.cli.equilibrium import command

ROBOTS = ROOT / "scenarios" / "robots"


def run(*arguments, code=0):
    result = CliRunner().invoke(command, [str(a) for a in arguments])
    assert result.exit_code == code, result.output
    return result


@pytest.mark.core
def test_the_rest_is_that_of_python(tmp_path):
    found = cdpr.equilibrium("v_plotter", lengths=[1.2, 1.3])
    text = run(ROBOTS / "v_plotter.yaml", "--lengths", "1.2,1.3").output
    assert "stable: least stiffness" in text
    assert f"{found.pose[0]:.6g}, 0, {found.pose[2]:.6g}] m" in text
    data = json.loads(run("v_plotter", "--lengths", "1.2,1.3", "--json", "--out", tmp_path / "o").output)
    assert data == json.loads((tmp_path / "o" / "equilibrium.json").read_text())
    (one,) = data["equilibria"]
    assert one["pose"]["position_m"] == found.pose[:3].tolist()
    assert [cable["name"] for cable in one["cables"]] == ["left", "right"]
    result = CliRunner().invoke(command, ["v_plotter", "--lengths", "1.2,1.3", "--out", str(tmp_path / "o")])
    assert "equilibrium.json" in str(result.exception)


def test_lists_of_lengths_and_tensions_complete_each_other():
    text = run(ROBOTS / "planar_point_mass.yaml", "--lengths", "1.8,1.8,-", "--tensions", "-,-,30").output
    assert re.search(r"cable_3 +30 ", text)
    assert "1 equilibrium from home" in text


def test_all_equilibria_are_numbered():
    data = json.loads(run("v_plotter", "--lengths", "1.2,1.3", "--all", "--starts", "5", "--json").output)
    assert [one["stability"] for one in data["equilibria"]] == ["stable", "unstable"]
    assert "\n2:\n" in run("v_plotter", "--lengths", "1.2,1.3", "--all", "--starts", "5").output


def test_impossible_lengths_end_with_code_4_and_name_the_cable():
    robot = cdpr.load_robot("crossed")
    pose = np.concatenate([robot.home, np.zeros(6)])
    lengths = cdpr.mechanics.kinematics.lengths(robot, pose)
    lengths[2] -= 0.2
    text = run(ROBOTS / "crossed.yaml", "--lengths", ",".join(map(repr, lengths.tolist())), code=4).output
    assert "not converged" in text
    assert "without cable 'cable_3', the other lengths fit" in " ".join(text.split())
    assert re.search(r"cable_3 +- ", text)


def test_compensation_shows_the_error_without_it():
    text = run("camera_robot", "--pose", "0.8,0.5,1.5", "--compensate").output
    assert "143.3 mm away" in text
    data = json.loads(run("hangprinter", "--pose", "0.4,0.2,0.6", "--compensate", "--json").output)
    assert data["uncompensated"]["error_m"] == pytest.approx(0.01311, abs=1e-5)
    assert data["uncompensated"]["slack"] == ["C"]
    run("hangprinter", "--pose", "0.4,0.2,2.5", "--compensate", code=4)  # above the anchors


def test_lengths_along_a_motion_are_a_table(tmp_path):
    given = ("caroca", "--set", "robot.cable={model: elastic, axial_stiffness: 1e5}")
    given += ("--set", "robot.winch={drum_radius: 0.05, inertia: 0.002}", "--compensate", "--step", "1")
    run(*given, "--out", tmp_path / "o")
    with (tmp_path / "o" / "lengths.csv").open() as file:
        rows = list(csv.DictReader(file))
    scenario = cdpr.load_scenario("caroca")
    assert float(rows[-1]["t"]) == scenario.desired.end
    assert {row["status"] for row in rows} == {"0.0"}
    pose = [float(rows[1][f"position_{axis}_m"]) for axis in "xyz"]
    assert pose == scenario.desired.sample(float(rows[1]["t"]))[:3].tolist()
    assert run(*given).output.startswith("t,position_x_m,")
    data = json.loads(run(*given, "--json").output)
    assert data["lengths_m"][0][0] == float(rows[0]["length_cable_1_m"])
    assert len(data["t"]) == len(rows)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ((), "expected --lengths, --tensions, --drum-angles or --compensate"),
        (("--lengths", "1,2", "--compensate"), "--compensate computes lengths: omit --lengths"),
        (("--all", "--compensate"), "omit --all"),
        (("--lengths", "1,2", "--starts", "3"), "--starts requires --all"),
        (("--lengths", "1,2", "--step", "3"), "--step requires --compensate"),
        (("--lengths", "1,2", "--solver", "qp"), "--solver requires --compensate"),
        (("--compensate", "--step", "1"), "--step requires a scenario"),
        (("--compensate", "--step", "1", "--pose", "0,0,1"), "omit --pose"),
        (("--lengths", "1,2,3"), "expected 2 values, one for each cable, got 3"),
        (("--lengths", "1,a"), "expected numbers with commas, got '1,a'"),
    ],
)
def test_wrong_options_are_refused(options, text):
    assert text in " ".join(run("v_plotter", *options, code=2).output.replace("│", " ").split())


def test_missing_values_are_errors():
    with pytest.raises(CdprError, match="cable 'right': expected one value"):
        CliRunner().invoke(command, ["v_plotter", "--lengths", "1.2,-"], catch_exceptions=False)


def test_lengths_in_millimetres_are_warned_of():
    with pytest.warns(
        UserWarning, match=r"lengths: cable 'left': 1200 m is .* times the size of the robot, .* are in m"
    ):
        run("v_plotter", "--lengths", "1200,1300")
    cdpr.equilibrium("v_plotter", lengths=[5.0, 5.0])  # warnings are errors here


@pytest.mark.parametrize("value", ["nan", "inf", "-inf"])
def test_values_that_are_not_finite_are_no_missing_ones(value):
    text = run("v_plotter", "--lengths", f"{value},1", "--tensions", "1,-", code=2).output
    assert "expected finite numbers, or `-` for a cable of another list, got" in text


def test_the_number_of_starts_has_a_limit():
    text = run("v_plotter", "--lengths", "1.2,1.3", "--all", "--starts", "1000000000", code=2).output
    assert "is not in the range 0<=x<=10000" in text
    with pytest.raises(CdprError, match=r"equilibria\(starts=\): expected a whole number from 0 to 10000"):
        cdpr.equilibria("v_plotter", lengths=[1.2, 1.3], starts=10**9)


def test_poses_that_are_not_finite_have_no_compensated_lengths():
    robot = cdpr.load_robot("caroca_winches")
    poses = np.array([robot.home, robot.home])
    poses[1, 2] = np.nan
    with pytest.raises(CdprError, match=r"poses: .*finite"):
        cdpr.compensated_lengths(robot, poses)
