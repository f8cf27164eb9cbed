"""Tables of text: the same wherever they go, whole, and aligned as a terminal shows their letters."""

from __future__ import annotations

import pytest
from command_line import cdpr_here
from rich.cells import cell_len

from cdpr.ui.report.text.aligned import table, vector

ROWS = [["cable", "what it is", "N"], ["a", "short", "1"], ["left", "x" * 300, "12.5"]]


@pytest.mark.parametrize(
    "environment",
    [{}, {"COLUMNS": "20"}, {"NO_COLOR": "1"}, {"FORCE_COLOR": "1"}, {"TERM": "dumb"}, {"TTY_INTERACTIVE": "1"}],
    ids=str,
)
def test_nothing_wraps_is_cut_or_coloured(environment, monkeypatch):
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    wide = 300 - len("what it is")
    assert list(table(ROWS, left=2)) == [
        f"  cable  what it is{' ' * wide}     N",
        f"  a      short{' ' * (wide + 5)}     1",
        f"  left   {'x' * 300}  12.5",
    ]


def test_letters_count_as_wide_as_they_are_shown():
    """Letters of two columns, a combining mark, and control characters."""
    lines = list(table([["索", "1"], ["cable", "2"], ["e\u0301", "3"], ["\x1b[31m", "4"]]))
    assert {cell_len(line) for line in lines} == {cell_len("  \\x1b[31m  4")}
    assert lines[3] == "  \\x1b[31m  4"


def test_a_ruled_table_has_its_titles_word_below_word():
    rule = "─" * len("solver  coverage  found")
    assert list(table([["solver", "coverage", "inf. found"], ["qp", "100 %", "-"]], indent="", ruled=True)) == [
        "                   inf.",
        "solver  coverage  found",
        rule,
        "qp         100 %      -",
    ]


def test_commands_print_no_other_table_into_a_file(monkeypatch):
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("COLUMNS", "30")
    lines = cdpr_here("solvers").stdout.splitlines()
    assert "\x1b" not in "".join(lines)
    assert next(line for line in lines if line.startswith("  qp ")).split()[-1] not in ("", "…")
    assert max(map(len, lines)) > 100


def test_vectors_are_reported_without_their_rounding():
    assert vector([1.2, -1.38778e-17, 1e-3]) == "[1.2, 0, 0.001]"
    assert vector([3e-20, 0.0, -1e-20]) == "[3e-20, 0, -1e-20]"
    assert vector([float("nan"), 2.0]) == "[nan, 2]"
    assert vector([]) == "[]"
