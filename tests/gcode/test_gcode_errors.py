"""G-code files that are rejected, and the limits of their size."""

from __future__ import annotations

import pytest
from gcode_cases import HEAD, PLANAR, PRINTER, points, read, refused, same

from cdpr.gcode.program import MAX_MOVES


@pytest.mark.parametrize(
    ("text", "line", "what"),
    [
        ("", 1, "no move is in it"),
        ("M3\nG4 X1", 2, "G4: expected P, how long in s"),
        (b"\x80\x81", 1, "this is not a text in UTF-8"),
        ("G1 X1\n\0", 2, "it has a zero byte"),
        ("hi", 1, "H: expected a number after it"),
        ("hello", 1, "HELLO is a command of other firmware, which is not supported; the dialect is linuxcnc; to skip"),
        ("F1 G1 X=2", 1, "expected words of a letter and a number, got '=2'"),
        ("F1 G1 Xnan", 1, "X: expected a number"),
        ("F1 G1 X" + "9" * 400, 1, "X: inf m is farther than 1e+06 m"),
        ("F1 G1 X" + "9" * 2000, 1, "expected a line of at most 1000 characters, got 2007"),
        ("G1 X1", 1, "no feed yet: expected an F before"),
        ("X1", 1, "coordinates without a motion"),
        ("F1 G1 X1\nG80\nX2", 3, "coordinates without a motion"),
        ("F0 G1 X1", 1, "F: expected a feed of 1e-09 m/s or more, got 0 m/s"),
        ("F1 G1 X1 X2", 1, "X occurs twice"),
        ("F1 G0 G1 X1", 1, "G0 and G1 exclude each other"),
        ("F1 G80 X1", 1, "coordinates without a motion"),
        ("F1 G92 X1 G1", 1, "G1 and G92 exclude each other: both use the coordinates of the line"),
        ("F1 G4 P1 G2 I1", 1, "G2 and G4 exclude each other: both use the P of the line"),
        ("G64 P1 G4", 1, "G4 and G64 exclude each other: both use the P of the line"),
        ("F1 G1 X1\nO0002", 2, "O2 begins a subprogram, which is not supported: expected a single program number"),
        ("O1\nO2\nF1 G1 X1", 2, "O2 begins a subprogram"),
        ("O1 G1 X1", 1, "parameters, expressions and O words are not supported"),
        ("F1 G1 X1 R2", 1, "R2 is not supported; the dialect is linuxcnc"),
        (
            "F1 G1 X1 E2",
            1,
            "files for 3D printers, where it is filament, are of reprapfirmware; to skip it, as if without motion",
        ),
        ("F1 G1 X1 A2", 1, "A2 is not supported; the dialect is linuxcnc; to skip it, as if without motion"),
        ("G28", 1, "G28 is not supported, only G0, G1, G2"),
        ("M98 P1", 1, "M98 runs or changes an unsupported function"),
        ("#1=2", 1, "parameters, expressions and O words are not supported"),
        ("o100 sub", 1, "parameters, expressions and O words are not supported"),
        ("F1 G1 X[1+1]", 1, "parameters, expressions and O words are not supported"),
        ("/F1 G1 X1", 1, "depend on a switch"),
        ("G21 (no end", 1, "a comment in brackets must end in its line"),
        ("G4 P-1\nG0 X1", 1, "G4: expected a pause between 0 and 1e+06 s, got -1 s"),
        ("G64 P-1\nG0 X1", 1, "P: expected a tolerance of 0 or more"),
        ("F1 G2 X1 I1\nX0", 2, "an arc needs its centre, I and J, or its radius R; G2 holds until G0 or G1 ends it"),
        ("F1 G18 G2 X1", 1, "an arc needs its centre, K and I, or its radius R"),
        ("F1 G2 X1 I1 R1", 1, "an arc has a centre or a radius R, not both"),
        ("F1 G2 X1 K1 I1", 1, "K1 is not supported"),
        ("F1 G90.1 G2 X1 I1", 1, "expected both coordinates of an arc's centre"),
        ("F1 G2 I1 P0.5", 1, "P: expected a whole number of turns from 1 to 1000, got 0.5"),
        ("F1\nG2 X200 R50", 2, "no arc of radius 0.05 m reaches over 0.2 m"),
        ("F1\nG2 R50", 2, "the arc with a radius R ends at its start"),
        ("F1\nG2 X100 Y100 I0 J0", 2, "the centre of the arc coincides with its start or end"),
        (
            "F1\nG2 X9 Y100 I1 J0",
            2,
            "no arc: its centre is 0.001 m from where it begins and 0.008 m from where it ends",
        ),
        ("F1\nG1 X999999999\nG91 X999999999", 3, "leads 2e+06 m from the origin"),
        ("F1 G1 X1e3", 1, "'X1E3': E behind a digit is an exponent to some, filament to others"),
        ("F1 G1 X1\nG92\nX2", 2, "G92: expected the new position, X, Y or Z"),
        ("F1 G1 X1\nM-3", 2, "M: expected a number of 0 or more after it"),
    ],
)
def test_each_mistake_is_one_line_with_its_place(tmp_path, text, line, what):
    (found,) = refused(tmp_path, text)
    assert found.startswith(f"a.ngc:{line}:1: trajectory.file: "), found
    assert what in found


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("N1 G1 X1*99", "the line was changed: its checksum is"),
        ("if true\nG1 X1", "conditions, loops, variables and expressions are not supported"),
        ("G1 X{a}", "conditions, loops, variables and expressions are not supported"),
        (
            "G1 H1 X1",
            "H1 moves single motors, such as winches, not the platform, which is not supported: remove the line",
        ),
        ("G1 H X1", "H: expected a number after it"),
        ("G6 A10 B-10", "or write ignore: [G6] to skip its coordinates"),
        ("G95 A20", "or write ignore: [G95] to skip its coordinates"),
        (
            "M569.4 P40 T0.1",
            "the dialect is reprapfirmware; to skip it, as if without motion, write ignore: [M569.4]",
        ),
        ("G10 L2 P1 X5", "G10 with L moves the coordinates"),
        ("G10 G91", "G10 or G11 beside other G words: put it on a separate line"),
        ("ECHO_ALL A=1", "ECHO_ALL is a command of other firmware, which is not supported; the dialect is reprapfirm"),
        ("G64 P1\nG1 X1", "G64 is not supported, only G0"),
        ("M220 S0", "M220: expected S, a percentage greater than 0"),
        ('M32 "x.g"', "M32 runs or changes an unsupported function"),
        ("G1 X5 E1e-3", "E behind a digit is an exponent to some, filament to others"),
        ("M104 S200 G1 X5", "G1 is another command behind M104: put it on a separate line"),
        ("T1 G1 X5", "G1 is another command behind T1"),
    ],
)
def test_mistakes_of_the_other_dialect(tmp_path, text, what):
    (found,) = refused(tmp_path, text, PRINTER)
    assert found.startswith("a.ngc:1:1: trajectory.file: "), found
    assert what in found


def test_lines_end_as_on_any_system(tmp_path):
    for end in ("\n", "\r\n", "\r"):
        same(points(tmp_path, end.join(["F6000", "G1 X100", "Y5", ""])), [100, 100, 1200], [100, 5, 1200])
    assert refused(tmp_path, "F6000\rG1 X1\rG28\r")[0].startswith("a.ngc:3:1: ")


@pytest.mark.slow
def test_lines_without_end(tmp_path):
    """Ten megabytes are no more than a comment, or a fault in its line."""
    same(points(tmp_path, f"F6000 ;{'a' * 10**7}\nG1 X5 ({'a' * 10**7})"), [5, 100, 1200])
    (found,) = refused(tmp_path, "F6000\nG1 X" + "5" * 10**7)
    assert found.startswith("a.ngc:2:1: trajectory.file: expected a line of at most 1000 characters, got 10000004")


def test_the_number_of_reported_errors_is_limited(tmp_path):
    assert len(refused(tmp_path, "G28\n" * 5000)) <= 10


@pytest.mark.slow
def test_so_many_moves_are_too_many(tmp_path):
    many = "F100\n" + "G1 X1\nX2\n" * (MAX_MOVES // 2)
    read(tmp_path, many + "M2\n")
    (found,) = refused(tmp_path, many + "X3\n")
    assert f"a.ngc:{MAX_MOVES + 2}:1: trajectory.file: 100000 moves at most are allowed" in found


def test_files_that_are_not_there_or_lead_nowhere(tmp_path):
    (found,) = refused(tmp_path, "F1 G1 X0 Y100 Z1200\n")
    assert "it contains no move from the initial position; to stay, use type: hold" in found
    (found,) = refused(tmp_path, HEAD, ", sha256: " + 64 * "0")
    assert "trajectory.sha256: 'a.ngc' has changed: its checksum is" in found
    (tmp_path / "b.ngc").write_text(HEAD)
    (found,) = refused(tmp_path, HEAD, "x")
    assert "there is no file 'a.ngcx'" in found
    (found,) = refused(tmp_path, HEAD, ", ignore: [hello]")
    assert "trajectory.ignore[0]" in found


def test_motions_stay_in_the_guide(tmp_path):
    read(tmp_path, "F100 G1 X100 Z1000\nG18 G2 X0 Z1100 I-50 K50\n", robot=PLANAR)
    (found,) = refused(tmp_path, "F100 G1 X100\nG2 I10\nG1 Y0\n", robot=PLANAR)
    assert found.startswith("a.ngc:3:1: trajectory.file: the robot moves along x, z, ry only")
    assert found.endswith("; 'axes' turns the file's axes, and 'origin' shifts them")
    (found,) = refused(tmp_path, "F100 G1 X100\nG2 I10\n", robot=PLANAR)
    assert found.startswith("a.ngc:2:1: ")
