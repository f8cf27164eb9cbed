"""Configurations of Hangprinters: RepRapFirmware and Klipper. Expected numbers are computed by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from firmware_cases import KLIPPER, RRF

import cdpr
from cdpr.base.errors import CdprError, FormatError
from cdpr.cables.drums import drum_motion
from cdpr.cables.tables import home_lengths
from cdpr.formats import import_file
from cdpr.formats.read import gcode_commands, klipper, reprap
from cdpr.formats.read.import_files import write
from cdpr.mechanics import kinematics
from cdpr.scenario.template import Sizes
from cdpr.simulation.trial_runs import scenario_with_trials


def imported(tmp_path, text, name="config.g", **options):
    """Return the robot and the result of an import."""
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    found = import_file(path, **options)
    return cdpr.load_robot(write(found, tmp_path / "out", force=True)[0]), found


def told(found):
    return "\n".join([*found.warnings, *found.left_out])


def test_the_numbers_of_reprapfirmware(tmp_path):
    robot, found = imported(tmp_path, RRF)
    assert robot.name == "hangprinter"
    assert robot.dof == ("x", "y", "z")
    assert [cable.name for cable in robot.cables] == ["A", "B", "C", "D"]
    anchors = [[0, -1.61098, -0.13153], [1.31422, 1.26814, -0.12128], [-1.41573, 0.70761, -0.12182], [0, 1e-5, 2.29983]]
    np.testing.assert_allclose([cable.frame for cable in robot.cables], anchors, atol=1e-12)
    assert not np.any([cable.platform for cable in robot.cables])
    assert robot.platform.mass == 1.5
    assert robot.tension_min.tolist() == [5, 5, 5, 0]
    assert robot.tension_max.tolist() == [80, 80, 80, 120]
    radii = [0.075546, 0.075659, 0.076128, 0.075192]
    np.testing.assert_allclose([cable.winch.drum_radius for cable in robot.cables], radii, rtol=1e-12)
    own = {"drum_growth": [0.000128181] * 4, "lines": [1] * 4, "reeving": [2, 2, 2, 4], "gear_ratio": [12.75] * 4}
    for key, values in own.items():
        np.testing.assert_allclose([cable.winch.own.get(key, 1) for cable in robot.cables], values, rtol=1e-12)
    assert {cable.winch.type for cable in robot.cables} == {"position"}
    assert cdpr.cables.commands_of(robot) == ["length"] * 4
    for key in (
        "M669 P",
        "M669 S",
        "M666 J",
        "M203",
        "M98",
        "M584",
        "M550, T0",
    ):
        assert key in told(found), key
    assert "config.g:13: M98: calls another file, which is not read" in told(found)


def test_the_stretch_is_that_of_the_firmwares_flex_compensation(tmp_path):
    robot, _ = imported(tmp_path, RRF)
    found = cdpr.compensated_lengths(robot, [[0.2, 0.1, 0.5, 1, 0, 0, 0]])
    distance = kinematics.lengths(robot, np.array([0.2, 0.1, 0.5, 1, 0, 0, 0, *[0] * 6]))
    # RepRapFirmware: flex = F / (k U), k = S / (U d), so F d / S; cdpr divides by the unstretched length instead of d.
    flex = found.tension[0] * distance / 21000
    np.testing.assert_allclose(distance - found.lengths[0], flex, rtol=1.1 * found.tension.max() / 21000)
    assert min(flex) > 1e-4


def test_drums_turn_as_the_firmware_turns_its_spools(tmp_path):
    robot, _ = imported(tmp_path, RRF.replace("O1:1:1:1", "O1:2:1:1"))
    change = np.array([0.4, -0.3, 0.2, -0.5])  # m, of the distances between anchors and nozzle
    still = np.zeros((1, 4))
    drums = drum_motion(robot, (home_lengths(robot) + change)[None], still, still)
    # HangprinterKinematics::CartesianToMotorSteps, mm: k0 (sqrt(R^2 + x k2) - R), with k2 = -U O Q and
    # k0 = 2 U J H / (2 pi L k2).
    R, falls, lines = np.array([75.546, 75.659, 76.128, 75.192]), np.array([2, 2, 2, 4]), np.array([1, 2, 1, 1])
    k2 = -falls * lines * 0.128181
    steps = 2 * falls * 25 * 255 / (2 * np.pi * 20 * k2) * (np.sqrt(R**2 + 1000 * change * k2) - R)
    np.testing.assert_allclose(drums.angle[0], -steps / 25 * 2 * np.pi * 20 / 255, rtol=1e-9)


def test_missing_parameters_of_spools_are_the_defaults_of_the_firmware(tmp_path):
    """DefaultSpoolRadii, DefaultSpoolBuildupFactor, ... of HangprinterKinematics.cpp, in mm."""
    lines = [line for line in RRF.splitlines() if not line.startswith(("M666 Q", "M666 U", "M666 L"))]
    robot, found = imported(tmp_path, "\n".join(lines))
    winches = [cable.winch for cable in robot.cables]
    np.testing.assert_allclose([winch.drum_radius for winch in winches], 0.075, rtol=1e-12)
    own = {"drum_growth": [7e-6] * 4, "reeving": [2, 2, 2, 4], "gear_ratio": [12.75] * 4}
    for key, values in own.items():
        np.testing.assert_allclose([winch.own[key] for winch in winches], values, rtol=1e-12)
    assert "M666 R 75:75:75:75, U 2:2:2:4, Q 0.007, H 255:255:255:255, L 20:20:20:20" in told(found)
    _, found = imported(tmp_path, RRF.replace("Q0.128181", "Q0").replace("L20:20:20:20 ", ""))
    assert "M666 L 20:20:20:20; other versions" in told(found)
    _, found = imported(tmp_path, RRF)
    assert "defaults of the firmware" not in told(found)


def test_older_versions_have_the_spools_in_m669(tmp_path):
    text = (
        "M669 K6\nM669 J25:25:25:25\nM669 U2:2:2:2\nM669 O1:1:1:1\nM669 G10:10:10:10 H255:255:255:255\n"
        "M669 A0.0:-1616:-116.31 B1333.19:1288.06:-156.91 C-1480.47:759.3:-165.77 D2309.54 "
        "Q0.068069 R65.683:65.395:65.433:65.372\nM666 X0 Y0 Z0\n"
    )
    robot, found = imported(tmp_path, text)
    np.testing.assert_allclose(robot.cables[3].frame, [0, 0, 2.30954], atol=1e-12)
    assert robot.cables[1].winch.drum_radius == pytest.approx(0.065395, rel=1e-12)
    assert robot.cables[1].winch.own["gear_ratio"] == 25.5
    assert robot.platform.mass == 2.0
    assert robot.tension_max.tolist() == [70] * 4
    for key in ("mass of the effector, 2 kg", "axial stiffness of the lines, 20000 N", "tension limits: 0.0 to 70.0 N",
                "M666 X: adjustment of an end stop", "M669 J: steps"):  # fmt: skip
        assert key in told(found), key


def test_parameters_that_the_firmware_saves_on_a_single_line(tmp_path):
    text = (
        "; Hangprinter parameters\nM669 K6 N5A0.000:-2000.000:-100.000 B2000.000:1000.000:-100.000 "
        "C-2000.000:1000.000:-100.000 D0.000:0.000:3000.000 I10.000:0.000:3100.000  P1500.0M666 A1 Q0.007000 "
        "R75.000:75.000:75.000:75.000:75.000 U2.000:2.000:2.000:2.000:4.000 W1.00 S20000.00 "
        "I0.0:0.0:0.0:0.0:1.0 X70.0:70.0:70.0:70.0:90.0 C0.0250:0.0250:0.0250:0.0250:0.0250 F1 B0 P0\n"
    )
    robot, found = imported(tmp_path, text, "config-override.g", tension=(2, 50))
    assert robot.name == "config-override"
    np.testing.assert_allclose(robot.cables[4].frame, [0.01, 0, 3.1], atol=1e-12)
    assert robot.tension_max.tolist() == [70, 70, 70, 70, 90]  # limits of the file, not the given ones
    for key in ("M666 A", "M666 C", "M666 F", "M666 B", "M666 P"):
        assert key in told(found), key


def test_given_limits_are_used_where_the_file_has_none(tmp_path):
    text = RRF.replace(" I5:5:5:0 X80:80:80:120", "")
    robot, found = imported(tmp_path, text, tension=(2, 50))
    assert (robot.tension_min.tolist(), robot.tension_max.tolist()) == ([2] * 4, [50] * 4)
    assert "assumed tension" not in told(found)


def test_lines_without_a_lower_limit_get_advice(tmp_path):
    """The loop of lines that become slack is not stable, and twice a lower limit of 0 is no pretension."""
    text = RRF.replace(" I5:5:5:0 X80:80:80:120", "")
    _, found = imported(tmp_path, text)
    limits = "assumed tension limits: 0.0 to 70.0 N; --tension MIN,MAX sets others"
    assert f"{limits}, recommended with MIN above 0, such as 5, so that the lines stay taut" in told(found)
    source = str(tmp_path / "out" / "hangprinter.yaml")
    trial = scenario_with_trials(str(tmp_path / "s.yaml"), source, Sizes())
    assert not trial.stable
    assert "as the robot's tension.min is 0: set it above 0 in the robot file (cdpr import --tension" in trial.note
    imported(tmp_path, text, tension=(5, 70))
    assert scenario_with_trials(str(tmp_path / "s.yaml"), source, Sizes()).stable


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_only_ends_of_lines_end_a_comment(tmp_path, end):
    """The second byte of the letter is 0x85, a line end of latin-1."""
    text = KLIPPER.replace("[printer]", "# Åke\n[printer]  # Åland").replace("\n", end)
    robot, _ = imported(tmp_path, text, "printer.cfg")
    assert robot.m == 4
    robot, _ = imported(tmp_path, RRF.replace("; Configuration file", "; Åke").replace("\n", end))
    assert robot.m == 4


def test_later_lines_replace_earlier_ones(tmp_path):
    robot, _ = imported(tmp_path, RRF + "M669 D0:0:2500\n")
    np.testing.assert_allclose(robot.cables[3].frame, [0, 0, 2.5], atol=1e-12)


def test_the_numbers_of_klipper(tmp_path):
    robot, found = imported(tmp_path, KLIPPER, "printer.cfg")
    assert robot.name == "winch_printer"
    anchors = [[0, -2, -0.1], [2, 1, -0.1], [-2, 1, -0.1], [0, 0, 2.9]]  # D from the saved block
    np.testing.assert_allclose([cable.frame for cable in robot.cables], anchors, atol=1e-12)
    radii = [0.04 / math.tau, 0.04 / math.tau, 0.05 / math.tau, 0.04 / math.tau]
    np.testing.assert_allclose([cable.winch.drum_radius for cable in robot.cables], radii, rtol=1e-12)
    for key in ("step_pin", "microsteps", "max_velocity", "[include]: this other file", "'gcode_macro X'", "mass"):
        assert key in told(found), key


def test_gears_of_klipper(tmp_path):
    robot, _ = imported(tmp_path, KLIPPER.replace("microsteps: 16", "gear_ratio: 57:11, 2:1"), "printer.cfg")
    assert robot.cables[0].winch.own["gear_ratio"] == pytest.approx(114 / 11, rel=1e-12)
    for wrong in ("57", "57:0", "a:b", "1:2:3"):
        with pytest.raises(FormatError, match=r"printer\.cfg:3: \[stepper_a\] gear_ratio: expected pairs such as"):
            imported(tmp_path, KLIPPER.replace("microsteps: 16", f"gear_ratio: {wrong}"), "printer.cfg")


def test_klipper_does_not_use_steppers_behind_a_gap(tmp_path):
    robot, found = imported(tmp_path, KLIPPER.replace("stepper_d", "stepper_e"), "printer.cfg")
    assert len(robot.cables) == 3
    assert "[stepper_e]: Klipper does not use it, for [stepper_d] is missing" in told(found)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("K6 ", "K3 "), r"config\.g:3: M669 K: expected 6, a Hangprinter, got 3"),
        (("M669 A0.0", "M669 E0.0"), r"config\.g:3: M669: anchor A is missing: expected AX:Y:Z, mm, as N is 4"),
        (("M669 A0.0", "M669 Ainf"), r"config\.g:7: M669 [AN]: expected a number after each letter, got 'AINF:-1"),
        (("1610.98:-131.53", "1610.98"), r"config\.g:7: M669 A: expected X:Y:Z, mm, got 0\.0:-1610\.98"),
        (("1610.98", "16-10.98"), r"config\.g:7: M669 A: expected numbers of at most 1e\+12, got"),
        (("1610.98", "1e999"), r"config\.g:7: M669 A: expected numbers of at most 1e\+12, got"),
        (("A0.0:-1610.98:-131.53", "A{var.a}"), r"config\.g:7: M669 A: expressions are not computed"),
        (("R75.546:", "R"), r"config\.g:8: M666 R: expected 4 values, one per anchor, got 75\.659"),
        (("R75.546:", "R0:"), r"config\.g:8: M666 R: expected values above 0, got 0:"),
        (("U2:", "U-2:"), r"config\.g:9: M666 U: expected values from 1, got -2:"),
        (("I5:", "I-5:"), r"config\.g:11: M666 I: expected values from 0, got -5:"),
        (("W1.5", "W-1"), r"config\.g:11: M666 W: expected one number of at least 0, got -1"),
        (("X80:80:80:120", "X4:4:4:4"), r"config\.g:7: the robot is invalid: tension\.min\[0\]: must not exceed"),
        (("M669 K6", "M669 K6 N12"), r"config\.g:3: M669 N: expected 3 to 9 anchors, got 12"),
        (("M669 K6 ", "M669 N6 K6 "), r"M669: anchor I is missing: expected IX:Y:Z, mm, as N is 6"),
        (("M669 A0", "if true\n  M669 A0"), r"config\.g:8: M669: it is inside a condition or loop"),
    ],
)
def test_errors_of_reprapfirmware_have_their_line(tmp_path, change, said):
    assert change[0] in RRF
    with pytest.raises(FormatError, match=said):
        imported(tmp_path, RRF.replace(*change))


def test_kinematics_without_anchors_is_no_robot(tmp_path):
    with pytest.raises(FormatError, match=r"config\.g:1: M669: expected K6, a Hangprinter, and its anchors"):
        imported(tmp_path, "M669 P200\n")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("[stepper_c]", "[stepper_x]"), r"printer\.cfg: section \[stepper_c\] is missing: .* three or more steppers"),
        (("anchor_y: -2000\n", ""), r"printer\.cfg:1: \[stepper_a\]: anchor_y is missing: expected a number, mm"),
        (("anchor_y: -2000", "anchor_y: low"), r"printer\.cfg:6: \[stepper_a\] anchor_y: expected .* got 'low'"),
        (("anchor_y: -2000", "anchor_y: nan"), r"printer\.cfg:6: \[stepper_a\] anchor_y: expected .* got 'nan'"),
        (("rotation_distance: 50", "rotation_distance: 0"), r"printer\.cfg:14: .* expected a number above 0"),
        (("anchor_x: 2000", "anchor_x 2000"), r"printer\.cfg:10: expected \[section\] or KEY: VALUE"),
    ],
)  # fmt: skip
def test_errors_of_klipper_have_their_line(tmp_path, change, said):
    assert change[0] in KLIPPER
    with pytest.raises(FormatError, match=said):
        imported(tmp_path, KLIPPER.replace(*change), "printer.cfg")


@pytest.mark.parametrize(("text", "name"), [(RRF, "config.g"), (KLIPPER, "printer.cfg")])
def test_damaged_files_end_in_one_line_or_a_robot(tmp_path, text, name):
    random = np.random.default_rng(0)
    content = text.encode()
    variants = [content[:end] for end in range(0, len(content), 60)]
    for _ in range(40):
        damaged = bytearray(content)
        for place in random.integers(0, len(content), 5):
            damaged[place] = random.integers(0, 256)
        variants.append(bytes(damaged))
    path = tmp_path / name
    for module in (reprap, klipper):
        for variant in variants:
            if module.recognise(variant):
                try:
                    module.read(path, variant, reprap.Choice())
                except CdprError as error:
                    assert "\n" not in str(error)  # noqa: PT017


@pytest.mark.parametrize("name", ["config.g", "printer.cfg"])
def test_files_that_are_no_text_or_too_large(tmp_path, name):
    text = RRF if name == "config.g" else KLIPPER
    robot, _ = imported(tmp_path, b"\xef\xbb\xbf; \xb5m \xff\n" + text.replace("\n", "\r\n").encode(), name)
    assert len(robot.cables) == 4
    for content, said in (
        (text.encode("utf-16"), "unknown format; .*; this is text in UTF-16: save it as UTF-8"),
        (bytes(range(256)) * 99, "unknown format"),
        (text.encode() + b" " * 2**24, "larger than 16 MiB"),
    ):
        with pytest.raises(FormatError, match=said):
            imported(tmp_path, content, name)


def test_many_lines_are_no_configuration(tmp_path):
    for text, name in ((RRF + "M1\n" * 250_000, "config.g"), (KLIPPER + "a: 1\n" * 250_000, "printer.cfg")):
        with pytest.raises(FormatError, match=r"expected at most 200000 lines, got 250"):
            imported(tmp_path, text, name)


def test_a_long_line_is_no_configuration(tmp_path):
    with pytest.raises(FormatError, match=r"config\.g:15: expected lines of at most 2000 characters, got 300003"):
        imported(tmp_path, RRF + "M1 " + "A{" * 10**5 + "(" * 10**5 + "\n")


def test_commands_of_a_line():
    text = b'N5 m669 k6 a1:2:3 P"x;y" B{a[0] + 1} ; C1\nG90 M83 G1 X1 T3\nelse\n  M1\nM2 (S1) S2\n'
    found = [(each.code, each.words, each.inside) for each in gcode_commands.commands_of(text, "f").every]
    assert found == [
        ("M669", {"K": "6", "A": "1:2:3", "P": '"x;y"', "B": "{a[0] + 1}"}, False),
        ("G90", {}, False),
        ("M83", {}, False),
        ("G1", {"X": "1", "T": "3"}, False),
        ("M1", {}, True),
        ("M2", {"S": "2"}, False),
    ]
