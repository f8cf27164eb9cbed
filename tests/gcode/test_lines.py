"""Lines of G-code: words that share one, program numbers, commands of other firmware, and what `ignore` skips."""

from __future__ import annotations

import itertools

import pytest
from test_gcode import HEAD, PRINTER, course, points, read, refused, same

from cdpr.gcode.program import _Reader
from cdpr.gcode.words import LineError, read_lines

MODAL_GROUPS = (
    "4 53 92 92.1 92.2 92.3",
    "0 1 2 3",
    "17 18 19",
    "90 91",
    "90.1 91.1",
    "93 94",
    "20 21",
    "98 99",
    "61 61.1 64",
)


@pytest.fixture
def folder(tmp_path):
    return tmp_path


def words_of(line):
    ((_, words),) = read_lines(line.encode(), "linuxcnc")
    return words


def test_modes_beside_an_ignored_word_hold(folder):
    """Only coordinates belong to the ignored word: G91, the feed and the end of the program do not."""
    text = HEAD + "G91 G28 Z0 F60\nG1 X5\nX5\nG28 M2\nX5"
    same(points(folder, text, ", ignore: [G28]")[1:], [5, 0, 1000], [10, 0, 1000])
    made = course(folder, HEAD + "G28 Z0 F60\nG1 X5", ", ignore: [G28]")
    assert made.speed[-1] == pytest.approx(0.001)


def test_commands_of_other_firmware_are_skipped_where_ignore_names_them(folder):
    lines = "EXCLUDE_OBJECT_DEFINE NAME=a POLYGON=[[0,0],[1,0]] ; all of it\nEXCLUDE_OBJECT_START NAME=a\n"
    text = f"{lines}set_velocity_limit ACCEL=3000\n{HEAD}G1 X5\nEXCLUDE_OBJECT_END\n"
    names = "EXCLUDE_OBJECT_DEFINE, EXCLUDE_OBJECT_END, EXCLUDE_OBJECT_START, SET_VELOCITY_LIMIT"
    for dialect in ("", PRINTER):
        scenario = read(folder, text, f"{dialect}, ignore: [{names}]")
        (told,) = [str(one) for one in scenario.warnings if "trajectory.file" in str(one)]
        assert told.endswith(f"skipped, as if without motion: {names}")
        same(points(folder, text, f"{dialect}, ignore: [{names}]"), [0, 0, 1000], [5, 0, 1000])
        found = refused(folder, text, dialect)
        assert len(found) == 4
        assert found[1].startswith("a.ngc:2:1: ")
        assert found[1].endswith("as if without motion, write ignore: [EXCLUDE_OBJECT_START]")


@pytest.mark.parametrize("number", ["O0001", "o1 (part)", "N10 O0001", ":0001", "O1"])
def test_a_program_number_is_skipped_and_reported(folder, number):
    text = f"%\n{number}\nG21 G17 G40 G49 G80 G90\nG0 X1 Y1\nG1 X5 F100\nM30\n%\n"
    same(points(folder, text), [1, 1, 1200], [5, 1, 1200])
    (told,) = [str(one) for one in read(folder, text).warnings if "trajectory.file" in str(one)]
    assert told.endswith("skipped, as if without motion: O1")


@pytest.mark.parametrize("line", ["G0 G80 X1 Y1", "G80 G0 X1 Y1", "G90 G17 G40 G80 G00 G21 X1 Y1"])
def test_g80_beside_a_motion_has_no_effect(folder, line):
    same(points(folder, f"G21 G90\nF600\n{line}\nX2\nM2\n"), [1, 1, 1200], [2, 1, 1200])


def test_pairs_of_g_words_share_a_line_where_linuxcnc_lets_them(folder):
    """All pairs, in both orders, against the modal groups of LinuxCNC's manual, written out here once more."""
    group = {word: k for k, words in enumerate(MODAL_GROUPS) for word in words.split()}
    words = [*group, "40", "49", "54", "80", "97"]
    both = {frozenset(pair) for pair in [*(("92", word) for word in "0123"), ("4", "2"), ("4", "3"), ("4", "64")]}
    needs = {"4": " P1", "92": " X1"}
    for first, second in itertools.product(words, repeat=2):
        allowed = group.get(first, first) != group.get(second, second) and frozenset((first, second)) not in both
        line = f"G{first} G{second}{needs.get(first, '') or needs.get(second, '')}"
        reader = _Reader("linuxcnc", "mm", set())
        reader.line(1, words_of("F600 G90 G21"))
        try:
            reader.line(2, words_of(line))
            said = ""
        except LineError as fault:  # arcs lack their centres, which is another fault
            said = str(fault)
        assert allowed != ("exclude each other" in said or "occurs twice" in said), (line, said)
