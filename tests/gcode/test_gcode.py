"""Motions of G-code files: what their words mean in two dialects, where they lead, and what is refused."""

from __future__ import annotations

import os
import pickle

import numpy as np
import pytest
from click.testing import CliRunner
from scenario_cases import PLUGINS, ROBOT, changed, whole

from cdpr.base.errors import ScenarioError
from cdpr.gcode.program import MAX_MOVES
from cdpr.scenario import Gcode, examples, load_scenario
from cdpr.ui.cli import cli

BEGIN = np.array([0.0, 0.1, 1.2])  # the initial position of the scenario around it
MOTION = "trajectory: {type: gcode, file: a.ngc, limits: {velocity: 1, acceleration: 2, jerk: 20}}\n"
HEAD = "G21 G90 F6000\nG0 X0 Y0 Z1000\n"  # mm, 100 mm/s
PRINTER = ", dialect: reprapfirmware"
PLANAR = changed(ROBOT, "dof: [x, y, z, rx, ry, rz]", "dof: [x, z, ry]")


@pytest.fixture
def folder(tmp_path):
    return tmp_path


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


# Words


def test_the_words_of_a_line_mean_what_they_mean_in_any_form(folder):
    plain = "F6000\nG1 X100 Y-20.5 Z1000\nG1 X.5\n"
    other = "; a comment\n%\nn10 f6000 (and one)\nN20g1x100.y-20.5z+1000;\r\n\n x0.5\n%\nnothing"
    same(points(folder, plain), [100, -20.5, 1000], [0.5, -20.5, 1000])
    same(points(folder, other), [100, -20.5, 1000], [0.5, -20.5, 1000])
    same(points(folder, "\ufeffF6000 G 1 X 1 0 0 Z1\n"), [100, 100, 1])


def test_units_offsets_and_relative_coordinates(folder):
    same(points(folder, HEAD + "G20\nG1 X1 Y2\nG21 G1 X1"), [0, 0, 1000], [25.4, 50.8, 1000], [1, 50.8, 1000])
    same(points(folder, "F100 G1 X1", ", units: m"), [1000, 100, 1200])
    same(points(folder, "F100 G1 X1", ", units: inch"), [25.4, 100, 1200])
    relative = "G91\nG1 X10\nX10 Y5\nG90 X0"
    same(points(folder, HEAD + relative), [0, 0, 1000], [10, 0, 1000], [20, 5, 1000], [0, 5, 1000])
    shifted = "G92 X100 Z0\nG1 X110\nG53 G1 X7\nG92.2\nX8\nG92.3\nX100\nG92.1 G1 X1"
    wanted = [[0, 0, 1000], [10, 0, 1000], [7, 0, 1000], [8, 0, 1000], [0, 0, 1000], [1, 0, 1000]]
    same(points(folder, HEAD + shifted), *wanted)
    same(points(folder, "G91 F100 G1 Z-200"), [0, 100, 1000])


def test_g92_1_forgets_what_g92_2_keeps(folder):
    shifted = HEAD + "G92 X100\n{}\nG92.3\nG1 X110\n"
    same(points(folder, shifted.format("G92.2")), [0, 0, 1000], [10, 0, 1000])
    same(points(folder, shifted.format("G92.1")), [0, 0, 1000], [110, 0, 1000])


def test_an_offset_takes_the_place_of_the_one_before(folder):
    same(points(folder, HEAD + "G92 X100\nG1 X110\nG92 X0\nG1 X5"), [0, 0, 1000], [10, 0, 1000], [15, 0, 1000])


def test_g53_counts_from_the_machine_as_the_dialect_has_it(folder):
    relative = "G91\nG1 X10\nG53 X3\nX1"  # LinuxCNC takes G53 as absolute, RepRapFirmware's axes stay relative
    same(points(folder, HEAD + relative), [0, 0, 1000], [10, 0, 1000], [3, 0, 1000], [4, 0, 1000])
    same(points(folder, HEAD + relative, PRINTER), [0, 0, 1000], [10, 0, 1000], [13, 0, 1000], [14, 0, 1000])
    shifted = HEAD + "G92 X100\nG53 G1 X110"  # in RepRapFirmware the machine itself is then said to be at 100
    same(points(folder, shifted), [0, 0, 1000], [110, 0, 1000])
    same(points(folder, shifted, PRINTER), [0, 0, 1000], [10, 0, 1000])


def test_feeds_are_per_minute_and_g0_is_as_the_dialect_says(folder):
    text = "F6000\nG0 X100\nG1 X0\nG20 F60 X1\n"
    np.testing.assert_allclose(course(folder, text).speed, [np.inf, 0.1, 0.0254])
    np.testing.assert_allclose(course(folder, text, PRINTER).speed, [0.1, 0.1, 0.0254])
    np.testing.assert_allclose(course(folder, "G1 X1\nM220 S50\nX2\n", PRINTER).speed, [0.05, 0.025])
    planned = read(folder, HEAD + "G1 X500\n").planned
    found = max(np.linalg.norm(planned.sample(t)[7:10]) for t in np.linspace(0.9, planned.end, 500))
    assert found == pytest.approx(0.1, rel=1e-9)


def test_pauses_have_the_units_of_the_dialect(folder):
    printer = [("G4 P250", 0.25), ("G4 S2", 2.0), ("G4 P250 S2", 2.0)]
    for text, keys, seconds in [("G4 P2", "", 2.0), *((text, PRINTER, seconds) for text, seconds in printer)]:
        with_it = read(folder, f"F6000\nG1 X100\n{text}\nG1 X200\n", keys).planned.end
        none = "M400" if keys else "G4 P0"  # stops, and goes on
        without = read(folder, f"F6000\nG1 X100\n{none}\nG1 X200\n", keys).planned.end
        assert with_it - without == pytest.approx(seconds)
        twice = read(folder, f"F6000\nG1 X100\n{text}\n{text}\nG1 X200\n", keys).planned.end
        assert twice - without == pytest.approx(2 * seconds)
        at_first = read(folder, f"{text}\nF6000\nG1 X100\n", keys).planned
        assert at_first.start == pytest.approx(seconds)
    straight = read(folder, "F6000\nG1 X200\n", PRINTER).planned.end
    for nothing in ("G4", "G4 P0", "G4 S-1", "G4 P5 S0"):  # as slicers write it
        told = read(folder, f"F6000\nG1 X100\n{nothing} ; wait\nG1 X200\n", PRINTER)
        assert told.planned.end == pytest.approx(straight)
        assert any("as if without motion: G4" in str(one) for one in told.warnings)


def test_where_the_coordinates_lie(folder):
    same(points(folder, "F100 G1 X0 Y0 Z0\nX100", ", origin: [1, 2, 3]"), [1000, 2000, 3000], [1100, 2000, 3000])
    keys = ", origin: [0, 0.1, 1.2], axes: {rpy_deg: [90, 0, 0]}, scale: 2"
    same(points(folder, "F100 G1 X10 Y20 Z30", keys), [20, 40, 1240])
    apart = keys.replace("[0, 0.1, 1.2]", "[0, 0, 1]")
    same(points(folder, "F100 G1 X10", apart), [20, 100, 1200])  # what is left out stays where it was
    same(points(folder, "G91 F100 G1 Y10", keys), [0, 100, 1220])
    rounded = course(folder, "G64 P0.5\nF100 G1 X10\nY20", keys)
    np.testing.assert_allclose(rounded.tolerance, 2 * 0.5e-3)
    helix = course(folder, "F100 G3 X0 Y200 Z30 J100", keys)
    end = helix.pieces.at(np.array([0]), helix.pieces.length)[0]
    same(1e3 * end, [0, 40, 1600])
    arc = course(folder, "F100 G3 X0 Y200 J100", keys)
    middle = arc.pieces.at(np.array([0]), 0.5 * arc.pieces.length)[0][0]
    same(1e3 * middle[None], [200, 100, 1400])
    assert arc.speed[0] == pytest.approx(0.1 / 60)


# Arcs: held to the radius, the sense and the angle that their words say, by points found otherwise


def swept(folder, words, plane="G17"):
    """Return the angle that an arc turns, seen against its axis, and its radii, from points on the way."""
    pieces = course(folder, f"{HEAD}{plane}\n{words}\n").pieces
    k = len(pieces) - 1
    way = pieces.at(np.full(401, k), np.linspace(0, 1, 401) * pieces.length[k])[0]
    x, y = {"G17": (0, 1), "G18": (2, 0), "G19": (1, 2)}[plane]
    bend = way[:, [x, y]]
    # The centre of the circle through three points.
    a, b, c = bend[0], bend[57], bend[131]
    center = np.linalg.solve(2 * np.array([b - a, c - a]), [b @ b - a @ a, c @ c - a @ a])
    arm = bend - center
    return np.degrees(np.ptp(np.unwrap(np.arctan2(arm[:, 1], arm[:, 0])))) * np.sign(
        arm[0, 0] * arm[5, 1] - arm[0, 1] * arm[5, 0]
    ), np.linalg.norm(arm, axis=1)


@pytest.mark.parametrize(
    ("words", "plane", "angle", "radius"),
    [
        ("G3 X100 Y100 J100", "G17", 90, 100),
        ("G2 X100 Y100 I100", "G17", -90, 100),
        ("G2 X100 Y100 J100", "G17", -270, 100),
        ("G3 I-50", "G17", 360, 50),
        ("G2 X0 Y0 I-50", "G17", -360, 50),
        ("G2 I-50 P3", "G17", -1080, 50),
        ("G3 X200 R100", "G17", 180, 100),
        ("G3 X100 Y100 R100", "G17", 90, 100),
        ("G3 X100 Y100 R-100", "G17", 270, 100),
        ("G2 X100 Y100 R100", "G17", -90, 100),
        ("G2 X100 Y100 R-100", "G17", -270, 100),
        ("G90.1\nG3 X100 Y100 I0 J100", "G17", 90, 100),
        ("G92 X50 Y0\nG90.1\nG3 X150 Y100 I50 J100", "G17", 90, 100),
        ("G3 X100 Z1100 I100", "G18", 90, 100),
        ("G2 X100 Z1100 I100", "G18", -270, 100),
        ("G3 Y100 Z1100 K100", "G19", 90, 100),
        ("G3 X0 Y0 Z1100 I-50 P2", "G17", 720, 50),
    ],
)
def test_arcs(folder, words, plane, angle, radius):
    found, radii = swept(folder, words, plane)
    assert found == pytest.approx(angle)
    np.testing.assert_allclose(1e3 * radii, radius, atol=1e-9)


def test_an_arc_whose_centre_is_rounded_ends_where_it_says(folder):
    text = HEAD + "G3 X70.711 Y70.711 I-0.001 J100.02 F600\nG1 X0"
    assert "no arc: its centre is 0.10002 m" in refused(folder, text)[0]
    same(points(folder, HEAD + "G3 X70.711 Y29.289 J100.02")[1:], [70.711, 29.289, 1000])


# Corners


def test_who_says_how_corners_are_passed(folder):
    text = HEAD + "G1 X100\nG64 P0.5\nG1 Y100\nG61\nG1 X0\nG64\nG1 Y0\n"
    np.testing.assert_allclose(course(folder, text).tolerance, [0, 0, 5e-4, 0, 0])
    np.testing.assert_allclose(course(folder, text, ", tolerance: 0.01").tolerance, [0.01, 0.01, 5e-4, 0, 0.01])
    gentle = HEAD + "G1 X100 F60000\nX200 Y10\nX300 Y0\nX400 Y10\n"
    ends = [read(folder, gentle, f", tolerance: {tolerance}").planned.end for tolerance in (0, 5e-3)]
    assert ends[1] < ends[0]


def test_short_lines_of_a_curve_are_passed_as_the_curve_is(folder):
    """A circle in chords of 1 mm, to the micron, at a feed for each line, and the same as an arc."""
    angle = np.linspace(0, 2 * np.pi, 629)
    chords = "".join(f"G1 X{100 * np.cos(a):.3f} Y{100 * np.sin(a):.3f} F24000\n" for a in angle[1:])
    begin = "F24000\nG1 X100 Y0 Z1000\nG4 P0\n"
    arc = read(folder, begin + "G3 I-100\n").planned.end
    assert read(folder, begin + chords, ", tolerance: 0.0001").planned.end < 1.1 * arc
    assert read(folder, begin + "G64 P0.1\n" + chords).planned.end < 1.1 * arc
    assert read(folder, begin + chords).planned.end > 10 * arc


# What is no motion


def test_what_moves_nothing_is_told_once(folder):
    text = 'M104 S200\nT0\nM117 Printing; G1\nG92 E0\nG10\nG1 X10 E5\nG11\nM106 S255\necho "G1 X5"\nG1 X20 E9\nM84\n'
    scenario = read(folder, text, PRINTER)
    (told,) = [str(warning) for warning in scenario.warnings if "trajectory.file" in str(warning)]
    assert told.endswith("trajectory.file: skipped, as if without motion: E, G10, M84, M104, M106, M117, M118, T")
    same(points(folder, text, PRINTER), [10, 100, 1200], [20, 100, 1200])
    milled = "G17 G20 G40 G49 G54 G64 G80 G90 G94\nG21\nT1 M6\nM3 S1000\nM8\n" + HEAD + "M66 P0 L2\nM5 M9\nG1 X5\n"
    (told,) = [str(one) for one in read(folder, milled).warnings if "trajectory.file" in str(one)]
    assert told.endswith(": L, M3, M5, M6, M8, M9, M66, S, T")


def test_the_end_ends(folder):
    same(points(folder, HEAD + "M30\nG1 X5\nnonsense"), [0, 0, 1000])
    same(points(folder, "G1 X5\nM0\nG28\n", PRINTER), [5, 100, 1200])


def test_what_is_to_be_ignored(folder):
    same(points(folder, HEAD + "G92 A0\nG1 X5 A3\n", ", ignore: [A]"), [0, 0, 1000], [5, 0, 1000])
    post = "G43 Z1010 H1\nG41 D2 G1 X5\nG55 X6\nG28 Z0\n"
    same(
        points(folder, HEAD + post, ", ignore: [G28, G41, G43, G55]"),
        [0, 0, 1000],
        [0, 0, 1010],
        [5, 0, 1010],
        [6, 0, 1010],
    )
    same(points(folder, "G28 X Y\nG1 X5 A3\nM98 P5\n", PRINTER + ", ignore: [G28, A, M98]"), [5, 100, 1200])


def test_inverse_times(folder):
    """G93: F is how often the move fits into a minute; G0 is as fast as ever, and neither mode knows the other's F."""
    moves = "G93\nG1 X30 F60\nG2 X50 I10 F30\nG0 X0\nG91 G1 Y7 F1.5\nG90 G94 F600 G1 Y0\n"
    made = course(folder, HEAD + moves)
    np.testing.assert_allclose(made.speed[1:], [0.03, 0.005 * np.pi, np.inf, 0.007 / 40.0, 0.01], rtol=1e-12)
    scaled = course(folder, HEAD + moves, ", scale: 2.0")  # the same times
    np.testing.assert_allclose(scaled.speed[1:], [0.06, 0.01 * np.pi, np.inf, 0.014 / 40.0, 0.01], rtol=1e-12)
    (told,) = [str(one) for one in read(folder, HEAD + "G93 G1 X3000 F60\n").warnings if "velocity" in str(one)]
    assert "feeds of up to 3 m/s, as in line 3 of a.ngc, are kept" in told
    needed = "under G93 each line with G1, G2 or G3 has an F, how often it fits into a minute: 6e-05 or more"
    for text in (
        "G93 F60 G1 X30\nX40",
        "G93 G1 X30 F0",
        "G93 G1 X30 F-1",
        "F600 G93 G0 X30\nG1 X40",
        "G93 G1 X30 F.00001",
    ):
        line, said = refused(folder, f"G0 X1\n{text}\n")[-1].split(": ", 1)
        assert needed in said, (line, said)
    assert "no feed yet" in refused(folder, "F600 G1 X9\nG93 G1 X30 F60\nG94 G1 X40")[-1]
    assert "G93 and G94 exclude each other" in refused(folder, "G93 G94 G1 X40 F60")[-1]
    assert "G93 is not known here" in refused(folder, "G93 G1 X40 F60", PRINTER)[-1]


def test_inverse_times_are_kept_where_limits_let_them(folder):
    """A move that is long against its changes of speed lasts about as long as it says, and never less."""
    motion = read(folder, HEAD + "G93 G1 X300 F6\nG0 X0\nG1 X300 F3\n", ", tolerance: 0").trajectory
    quick = read(folder, HEAD + "G0 X300\n", ", tolerance: 0").trajectory
    assert 30.0 < motion.ends() - quick.ends() < 31.0


def test_a_feed_beyond_the_limits_is_told(folder):
    told = [str(one) for one in read(folder, "F6000\nG1 X5\nF90000 X9\n").warnings]
    assert any(
        "trajectory.limits.velocity: feeds of up to 1.5 m/s, as in line 3 of a.ngc, are kept" in one for one in told
    )


# What is refused


@pytest.mark.parametrize(
    ("text", "line", "what"),
    [
        ("", 1, "no move is in it"),
        ("M3\nG4 X1", 2, "G4: P, how long in s, is expected"),
        (b"\x80\x81", 1, "this is not a text in UTF-8"),
        ("G1 X1\n\0", 2, "it has a zero byte"),
        ("hi", 1, "H: a number is expected after it"),
        ("hello", 1, "HELLO is a command of other firmware, which is not known here; the dialect is linuxcnc; to skip"),
        ("F1 G1 X=2", 1, "words of a letter and a number are expected, got '=2'"),
        ("F1 G1 Xnan", 1, "X: a number is expected"),
        ("F1 G1 X" + "9" * 400, 1, "X: inf m is farther than 1e+06 m"),
        ("F1 G1 X" + "9" * 2000, 1, "the line has 2007 characters, 1000 at most"),
        ("G1 X1", 1, "no feed yet: an F is expected"),
        ("X1", 1, "coordinates without a motion"),
        ("F1 G1 X1\nG80\nX2", 3, "coordinates without a motion"),
        ("F0 G1 X1", 1, "F: a feed of 1e-09 m/s or more is expected, got 0 m/s"),
        ("F1 G1 X1 X2", 1, "X occurs twice"),
        ("F1 G0 G1 X1", 1, "G0 and G1 exclude each other"),
        ("F1 G80 X1", 1, "coordinates without a motion"),
        ("F1 G92 X1 G1", 1, "G1 and G92 exclude each other: both use the coordinates of the line"),
        ("F1 G4 P1 G2 I1", 1, "G2 and G4 exclude each other: both use the P of the line"),
        ("G64 P1 G4", 1, "G4 and G64 exclude each other: both use the P of the line"),
        ("F1 G1 X1\nO0002", 2, "O2 begins a subprogram, and these are not run here: a program number is expected once"),
        ("O1\nO2\nF1 G1 X1", 2, "O2 begins a subprogram"),
        ("O1 G1 X1", 1, "parameters, expressions and O words are not computed here"),
        ("F1 G1 X1 R2", 1, "R2 means nothing here; the dialect is linuxcnc"),
        (
            "F1 G1 X1 E2",
            1,
            "files for 3D printers, where it is filament, are of reprapfirmware; to skip it, as if without motion",
        ),
        ("F1 G1 X1 A2", 1, "A2 means nothing here; the dialect is linuxcnc; to skip it, as if without motion"),
        ("G28", 1, "G28 is not known here, only G0, G1, G2"),
        ("M98 P1", 1, "M98 runs or changes what is not known here"),
        ("#1=2", 1, "parameters, expressions and O words are not computed here"),
        ("o100 sub", 1, "parameters, expressions and O words are not computed here"),
        ("F1 G1 X[1+1]", 1, "parameters, expressions and O words are not computed here"),
        ("/F1 G1 X1", 1, "depends on a switch"),
        ("G21 (no end", 1, "a comment in brackets must end in its line"),
        ("G4 P-1\nG0 X1", 1, "G4: a pause between 0 and 1e+06 s is expected, got -1 s"),
        ("G64 P-1\nG0 X1", 1, "P: a tolerance of 0 or more"),
        ("F1 G2 X1 I1\nX0", 2, "an arc needs its centre, I and J, or its radius R; G2 holds until G0 or G1 ends it"),
        ("F1 G18 G2 X1", 1, "an arc needs its centre, K and I, or its radius R"),
        ("F1 G2 X1 I1 R1", 1, "an arc has a centre or a radius R, not both"),
        ("F1 G2 X1 K1 I1", 1, "K1 means nothing here"),
        ("F1 G90.1 G2 X1 I1", 1, "both coordinates of an arc's centre are expected"),
        ("F1 G2 I1 P0.5", 1, "P: a whole number of turns from 1 to 1000 is expected, got 0.5"),
        ("F1\nG2 X200 R50", 2, "no arc of radius 0.05 m reaches over 0.2 m"),
        ("F1\nG2 R50", 2, "an arc with a radius R ends where it begins"),
        ("F1\nG2 X100 Y100 I0 J0", 2, "the arc's centre is where it begins or ends"),
        (
            "F1\nG2 X9 Y100 I1 J0",
            2,
            "no arc: its centre is 0.001 m from where it begins and 0.008 m from where it ends",
        ),
        ("F1\nG1 X999999999\nG91 X999999999", 3, "leads 2e+06 m from the origin"),
        ("F1 G1 X1e3", 1, "'X1E3': E behind a digit is an exponent to some, filament to others"),
        ("F1 G1 X1\nG92\nX2", 2, "G92: expected the new position, X, Y or Z"),
        ("F1 G1 X1\nM-3", 2, "M: a number of 0 or more is expected after it"),
    ],
)
def test_each_mistake_is_one_line_with_its_place(folder, text, line, what):
    (found,) = refused(folder, text)
    assert found.startswith(f"a.ngc:{line}:1: trajectory.file: "), found
    assert what in found


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("N1 G1 X1*99", "the line was changed: its checksum is"),
        ("if true\nG1 X1", "conditions, loops, variables, expressions are not computed here"),
        ("G1 X{a}", "conditions, loops, variables, expressions are not computed here"),
        ("G1 H1 X1", "H1 means nothing here"),
        ("G10 L2 P1 X5", "G10 with L moves the coordinates"),
        ("G10 G91", "G10 or G11 beside other G words: put it on a separate line"),
        ("ECHO_ALL A=1", "ECHO_ALL is a command of other firmware, which is not known here; the dialect is reprapfirm"),
        ("G64 P1\nG1 X1", "G64 is not known here, only G0"),
        ("M220 S0", "M220: S, a percentage greater than 0"),
        ('M32 "x.g"', "M32 runs or changes what is not known here"),
        ("G1 X5 E1e-3", "E behind a digit is an exponent to some, filament to others"),
        ("M104 S200 G1 X5", "G1 is another command behind M104: put it on a separate line"),
        ("T1 G1 X5", "G1 is another command behind T1"),
    ],
)
def test_mistakes_of_the_other_dialect(folder, text, what):
    (found,) = refused(folder, text, PRINTER)
    assert found.startswith("a.ngc:1:1: trajectory.file: "), found
    assert what in found


def test_lines_end_as_on_any_system(folder):
    for end in ("\n", "\r\n", "\r"):
        same(points(folder, end.join(["F6000", "G1 X100", "Y5", ""])), [100, 100, 1200], [100, 5, 1200])
    assert refused(folder, "F6000\rG1 X1\rG28\r")[0].startswith("a.ngc:3:1: ")


def test_lines_without_end(folder):
    """Ten megabytes are no more than a comment, or a fault in its line."""
    same(points(folder, f"F6000 ;{'a' * 10**7}\nG1 X5 ({'a' * 10**7})"), [5, 100, 1200])
    (found,) = refused(folder, "F6000\nG1 X" + "5" * 10**7)
    assert found.startswith("a.ngc:2:1: trajectory.file: the line has 10000004 characters")


def test_what_is_text_is_no_command(folder):
    text = 'M117 G1 X9\nM291 P"then G1 X9" S1\nM104 S200 T0\nG1X5Y6E.5\n'
    same(points(folder, text, PRINTER), [5, 6, 1200])


def test_a_right_checksum(folder):
    total = 0
    for byte in b"N1 G1 X5":
        total ^= byte
    for comment in ("", " ; a * b", " (a * b) (c*d)"):
        same(points(folder, f"N1 G1 X5*{total}{comment}", PRINTER), [5, 100, 1200])


def test_not_more_faults_are_told_than_anyone_reads(folder):
    assert len(refused(folder, "G28\n" * 5000)) <= 10


@pytest.mark.slow
def test_so_many_moves_are_too_many(folder):
    many = "F100\n" + "G1 X1\nX2\n" * (MAX_MOVES // 2)
    read(folder, many + "M2\n")
    (found,) = refused(folder, many + "X3\n")
    assert f"a.ngc:{MAX_MOVES + 2}:1: trajectory.file: 100000 moves at most are allowed" in found


def test_files_that_are_not_there_or_lead_nowhere(folder):
    (found,) = refused(folder, "F1 G1 X0 Y100 Z1200\n")
    assert "it contains no move from the initial position; to stay, use type: hold" in found
    (found,) = refused(folder, HEAD, ", sha256: " + 64 * "0")
    assert "trajectory.sha256: 'a.ngc' has changed: its checksum is" in found
    (folder / "b.ngc").write_text(HEAD)
    (found,) = refused(folder, HEAD, "x")
    assert "there is no file 'a.ngcx'" in found
    (found,) = refused(folder, HEAD, ", ignore: [hello]")
    assert "trajectory.ignore[0]" in found


def test_motions_stay_in_the_guide(folder):
    read(folder, "F100 G1 X100 Z1000\nG18 G2 X0 Z1100 I-50 K50\n", robot=PLANAR)
    (found,) = refused(folder, "F100 G1 X100\nG2 I10\nG1 Y0\n", robot=PLANAR)
    assert found.startswith("a.ngc:3:1: trajectory.file: the robot moves along x, z, ry only")
    assert found.endswith("; 'axes' turns the file's axes, and 'origin' shifts them")
    (found,) = refused(folder, "F100 G1 X100\nG2 I10\n", robot=PLANAR)
    assert found.startswith("a.ngc:2:1: ")


# The scenario around it


def test_the_resolved_text_is_equal(folder):
    scenario = read(folder, HEAD + "G1 X100\n")
    again = load_scenario(folder / "a.yaml", text=scenario.resolved_yaml(), plugins=PLUGINS)
    assert again == scenario
    assert pickle.loads(pickle.dumps(scenario)) == scenario
    assert again.planned.end == scenario.planned.end
    elsewhere = folder / "out"
    elsewhere.mkdir()
    moved = scenario.yaml_in(str(elsewhere))
    assert load_scenario(elsewhere / "a.yaml", text=moved, plugins=PLUGINS).planned.end == scenario.planned.end
    (folder / "a.ngc").write_text(HEAD + "G1 X200\n")
    with pytest.raises(ScenarioError, match="has changed: its checksum"):
        load_scenario(folder / "a.yaml", text=scenario.resolved_yaml(), plugins=PLUGINS)


def test_the_example_moves_as_it_says(tmp_path):
    copies = examples.copy("gcode", tmp_path)
    assert {path.name for path in copies} == {"gcode.yaml", "caroca.yaml", "outline.ngc"}
    done = CliRunner().invoke(cli, ["info", str(tmp_path / "gcode.yaml")])
    assert done.exit_code == 0, done.output
    assert "feasible             100 % of the samples" in done.output
    scenario = load_scenario(tmp_path / "gcode.yaml")
    assert scenario.warnings == ()
    np.testing.assert_allclose(scenario.planned.sample(scenario.planned.end)[:3], [0, 0, 1.2], atol=1e-12)
