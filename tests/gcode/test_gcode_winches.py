"""G-code motions of robots whose winches take lengths, and the words that move their motors."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT
from gcode_cases import PRINTER, points, read, refused, same

import cdpr

FILE = """G21
G90
G1 X200 Y0 Z350 F9000
G3 X-200 Y0 I-200 J0
G1 X0 Y0
"""
MOTION = {
    "limits": {"velocity": 0.3, "acceleration": 1.0, "jerk": 20.0},
    "tolerance": 0.001,
    "dialect": "reprapfirmware",
}
OF_LOAD = 1e-9  # unbalanced part of the weight that flex compensation may leave: it solves to round-off
AT_REST = 1e-9  # m, oscillations that remain after two seconds
SWING = 0.02  # m, the carriage tilts and swings on two belts: 11 mm in the example
TURNED = {"origin": [0.0, 0.0, 1.0], "axes": {"rpy_deg": [90, 0, 0]}}  # drawing on a wall


def followed(folder, name, start, compensates, text=FILE, **keys):
    """Run the example `name` along a G-code file."""
    (folder / "part.gcode").write_text(text)
    robot = {"hangprinter": "hangprinter", "plotter": "v_plotter"}[name]
    (folder / "robot.yaml").write_text((ROOT / "scenarios" / "robots" / f"{robot}.yaml").read_text())
    text = (ROOT / "scenarios" / f"{name}.yaml").read_text().replace(f"robots/{robot}.yaml", "robot.yaml")
    (folder / "scenario.yaml").write_text(text)
    changes = {
        "trajectory": {"type": "gcode", "file": "part.gcode", **MOTION, **keys},
        "initial": {"position": start},
        "controller.flex_compensation": compensates,
        "simulation.duration": 10.0,
    }
    return cdpr.simulate(folder / "scenario.yaml", overrides=changes)


def test_flex_compensation_follows_a_path(tmp_path):
    """Commanded lengths balance the weight at the desired poses; the elastic law and the statics are written here."""
    plain, run = (followed(tmp_path, "hangprinter", [0.0, 0.0, 0.3], each) for each in (False, True))
    robot = cdpr.load_robot(tmp_path / "robot.yaml")
    frame = np.array([cable.frame for cable in robot.cables])
    lines = frame[None] - run.desired_position[:, None]
    chord = np.linalg.norm(lines, axis=2)
    assert np.ptp(chord, axis=0).min() > 0.05  # it does move
    unwound = run["winch_command"]
    stiffness = np.array([cable.axial_stiffness for cable in robot.cables])
    tension = stiffness * (chord - unwound) / unwound
    force = (tension[:, :, None] * lines / chord[:, :, None]).sum(axis=1)
    weight = robot.platform.mass * 9.81
    np.testing.assert_allclose(force, np.tile([0.0, 0.0, weight], (len(force), 1)), rtol=0, atol=OF_LOAD * weight)
    error = np.linalg.norm(run.position - run.desired_position, axis=1)
    sunk = np.linalg.norm(plain.position - plain.desired_position, axis=1)
    assert error[-1] < AT_REST
    assert sunk[-1] > 1e-3
    assert error.max() < 0.3 * sunk.max()


def test_a_plotter_draws(tmp_path):
    run = followed(tmp_path, "plotter", [0.0, 0.0, 1.0], True, FILE.replace(" Z350", ""), **TURNED)
    assert run.status == "finished"
    assert np.ptp(run.desired_position[:, 0]) == pytest.approx(0.4, abs=0.005)
    assert np.linalg.norm(run.position - run.desired_position, axis=1).max() < SWING


def test_ignored_motor_moves_do_not_move_the_platform(tmp_path):
    text = "G1 X100 Y0\nG1 H2 X500 Y500\nG6 A10\nG1 Y50\n"
    same(points(tmp_path, text, f"{PRINTER}, ignore: [H, G6]"), [100, 0, 1200], [100, 50, 1200])
    same(points(tmp_path, "G1 H0 X100 Y0\nG1 Y50", PRINTER), [100, 0, 1200], [100, 50, 1200])


def test_motor_moves_are_refused(tmp_path):
    (found,) = refused(tmp_path, "G1 X1\nG1 H2 X10 F600", PRINTER)
    assert found == (
        "a.ngc:2:1: trajectory.file: H2 moves single motors, such as winches, not the platform, which is not "
        "supported: remove the line, or write ignore: [H] to skip its coordinates"
    )
    assert read(tmp_path, "F6000\nG43 H2\nG1 X10", ", ignore: [G43]")  # a tool length in the other dialect
