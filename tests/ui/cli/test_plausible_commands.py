"""Commands report suspicious values once, and reject them with --strict."""

from __future__ import annotations

import json

import numpy as np
import pytest
from command_line import cdpr_here
from plausible_cases import CAROCA, FILES, UNHELD

from cdpr.log.run import Run
from cdpr.ui.report.text.reservations import lost

WRONG = ("--set", "initial.position=[3.6,0,1.2]")


@pytest.mark.parametrize("command", ["validate", "run", "info"])
def test_commands_report_and_reject(command, tmp_path):
    short = ("--set", "simulation.duration=0.01", "--no-report") if command == "run" else ()
    done = cdpr_here(command, CAROCA, *WRONG, *short, cwd=tmp_path)
    lines = done.stderr.splitlines(keepends=True)
    assert "".join(line for line in lines if ": note: " not in line).startswith(
        "warning: --set initial.position=[3.6,0,1.2]: initial.position: lies outside the frame"
    )
    done = cdpr_here(command, CAROCA, *WRONG, *short, "--strict", cwd=tmp_path, code=2)
    assert "initial.position: lies outside the frame" in done.stderr
    assert "warning" not in done.stderr
    assert done.stdout == ""
    if command == "validate":
        cdpr_here(command, *[path for path in FILES if path not in UNHELD][:5], "--strict", cwd=tmp_path)


def test_a_pose_in_millimetres_is_reported(tmp_path):
    pose = ("--pose", "0,0,1250")
    done = cdpr_here("tension", CAROCA, *pose, "--json", cwd=tmp_path)
    assert done.stderr.startswith("warning: --pose: lies beyond reach: 1246 m from the middle of the frame's anchors")
    assert "[0, 0, 1250] in millimetres is [0, 0, 1.25] m" in done.stderr


def test_warnings_in_json(tmp_path):
    (row,) = json.loads(cdpr_here("validate", CAROCA, *WRONG, "--json", cwd=tmp_path).stdout)
    (warning,) = row["warnings"]
    assert warning["key"] == "initial.position"
    assert set(warning) == {"source", "line", "column", "key", "text"}
    (row,) = json.loads(cdpr_here("validate", CAROCA, *WRONG, "--json", "--strict", cwd=tmp_path, code=2).stdout)
    assert not row["ok"]
    assert row["rows"] == [warning]


def test_an_event_after_the_end_is_reported_once(tmp_path):
    late = ("--set", "events=[{type: cable_break, time: 9, cable: 1}]")
    done = cdpr_here("validate", CAROCA, *late, "--json", cwd=tmp_path)
    (row,) = json.loads(done.stdout)
    assert [warning["key"] for warning in row["warnings"]] == ["events[0]"]
    assert (row["unused"], row["notes"]) == ([], [])
    assert done.stderr.count("events[0]: happens at 9 s, after the end") == 1


def test_compare_reports_and_rejects(tmp_path):
    done = cdpr_here("compare", CAROCA, *WRONG, "--strict", "--out", tmp_path / "it", cwd=tmp_path, code=2)
    assert "initial.position: lies outside the frame" in done.stderr
    assert (done.stdout, list(tmp_path.iterdir())) == ("", [])  # nothing has run
    done = cdpr_here("compare", tmp_path, tmp_path, "--strict", cwd=tmp_path, code=2)
    assert "leave out" in done.stderr


def test_a_platform_that_ends_far_away_is_reported(tmp_path):
    from cdpr import simulate

    run = simulate(CAROCA, overrides={"simulation.duration": 0.01})
    size = np.linalg.norm([7.0, 4.0, 2.3])  # m, of the box around anchors and start
    assert list(lost(run)) == []
    for share, count in ((0.999, 0), (1.001, 1)):
        rows = run.rows.copy()
        rows[-1, run.header.layout.columns["position"]] = run.desired_position[-1] + [share * size, 0, 0]
        assert len(list(lost(Run(run.header, rows, "finished", "")))) == count
    wrong = ("controller.kp=0", "controller.kd=0", "solver.type=pseudo_inverse")
    push = "events=[{type: wrench, time: 0, force: [30000, 0, 0]}]"
    words = [word for text in (*wrong, push, "simulation.duration=1.0") for word in ("--set", text)]
    done = cdpr_here("run", CAROCA, *words, "--no-report", cwd=tmp_path)
    assert "WARNING             the platform ends" in done.stdout
    done = cdpr_here("run", CAROCA, *words, "--no-report", "--strict", "--json", cwd=tmp_path, code=2)
    assert "stopped: the platform ends" in done.stderr
    assert any("more than the robot's size" in text for text in json.loads(done.stdout)["reservations"])
