"""What a long command tells on stderr."""

from __future__ import annotations

import io

import pytest

from cdpr.cli import progress
from cdpr.cli.progress import Progress


class Stderr(io.StringIO):
    terminal = False

    def isatty(self):
        return self.terminal


@pytest.fixture
def clock(monkeypatch):
    """A clock to set."""
    now = [100.0]
    monkeypatch.setattr(progress, "monotonic", lambda: now[0])
    return now


def test_time_left_counts_from_the_first_case(clock, monkeypatch):
    """The first takes longer: workers import and compile."""
    monkeypatch.setattr("sys.stderr", stderr := Stderr())
    bar = Progress()
    bar.running(3, 24, {"finished": 3})
    clock[0] += 60.0
    bar.running(4, 24, {"finished": 4})
    clock[0] += 20.0
    bar.running(14, 24, {"finished": 12, "diverged": 2})
    assert stderr.getvalue().splitlines() == ["4 of 24 cases", "14 of 24 cases, 2 diverged, 20 s left"]


def test_a_file_gets_a_line_now_and_then_and_a_terminal_one_that_goes(clock, monkeypatch):
    monkeypatch.setattr("sys.stderr", stderr := Stderr())
    bar = Progress()
    for _ in range(100):
        clock[0] += 0.3
        bar.running(1, 2, {})
    assert 2 <= len(stderr.getvalue().splitlines()) <= 3
    monkeypatch.setattr("sys.stderr", stderr := Stderr())
    stderr.terminal = True
    bar = Progress()
    clock[0] += 1.0
    bar.running(1, 2, {})
    bar.clear()
    assert stderr.getvalue() == f"\r1 of 2 cases\r{' ' * 12}\r"
