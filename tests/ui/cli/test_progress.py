"""Progress of long commands on stderr, and their end."""

from __future__ import annotations

import io
import os
import signal
import subprocess
import sys

import click
import pytest

from cdpr.ui.cli import progress
from cdpr.ui.cli.progress import STOPPING, Progress, terminating


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
    bar = Progress("cases")
    bar(3, 24, {"finished": 3})
    bar(3, 24, {"finished": 3})
    clock[0] += 60.0
    bar(4, 24, {"finished": 4})
    clock[0] += 20.0
    bar(14, 24, {"finished": 12, "diverged": 2})
    assert stderr.getvalue().splitlines() == ["4 of 24 cases", "14 of 24 cases, 2 diverged, 20 s left"]


def test_a_file_gets_a_line_now_and_then_and_a_terminal_one_that_goes(clock, monkeypatch):
    monkeypatch.setattr("sys.stderr", stderr := Stderr())
    bar = Progress()
    for _ in range(100):
        clock[0] += 0.3
        bar(1, 2)
    assert 2 <= len(stderr.getvalue().splitlines()) <= 3
    monkeypatch.setattr("sys.stderr", stderr := Stderr())
    stderr.terminal = True
    with Progress() as bar:
        clock[0] += 1.0
        bar(1, 2)
    assert stderr.getvalue() == f"{'#' * 12}{'-' * 12} 50%\r{' ' * 28}\r"


@pytest.fixture
def handlers():
    """All signals arrive, for any signal mask of the test process."""
    before = {number: signal.signal(number, signal.default_int_handler) for number in STOPPING}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 143)])
def test_a_signal_ends_in_order(handlers, number, code):
    ended = []

    def command():
        with terminating():
            try:
                os.kill(os.getpid(), number)
            finally:
                ended.append(True)

    with pytest.raises(click.exceptions.Exit) as error:
        command()
    assert ended
    assert error.value.exit_code == code
    assert signal.getsignal(number) == signal.default_int_handler


def test_a_command_that_can_wait_is_ended_by_the_second(handlers):
    heard = []

    def command():
        with terminating() as signals:
            signals.wait = True
            os.kill(os.getpid(), signal.SIGINT)
            heard.append((signals.pending, signals.terminated))
            os.kill(os.getpid(), signal.SIGTERM)
            heard.append("not ended")

    with pytest.raises(click.exceptions.Exit) as error:
        command()
    assert heard == [(True, False)]
    assert error.value.exit_code == 143


def test_an_ignored_signal_stays_ignored(handlers):
    """As nohup has it, and a shell for what it starts in the background."""
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    with terminating() as signals:
        os.kill(os.getpid(), signal.SIGHUP)
    assert not signals.pending
    assert signal.getsignal(signal.SIGHUP) == signal.SIG_IGN


def test_interrupts_converted_by_libraries_are_recognised(handlers):
    def command(*, interrupted):
        with terminating():
            try:
                if interrupted:
                    os.kill(os.getpid(), signal.SIGINT)
            finally:
                raise SystemError("initialization raised unreported exception")

    with pytest.raises(click.exceptions.Exit) as error:
        command(interrupted=True)
    assert error.value.exit_code == 130
    with pytest.raises(SystemError):
        command(interrupted=False)


WITHIN_A_TEXT = """
import cdpr.ui.cli

def interrupted(*words, **more):
    exec("raise KeyboardInterrupt")

cdpr.ui.cli.cli.main = interrupted
cdpr.ui.cli.main()
"""


def test_an_interrupt_within_what_python_made_of_a_text_ends_the_command_in_order(tmp_path):
    """As that which makes a dataclass."""
    (tmp_path / "command.py").write_text(WITHIN_A_TEXT)
    done = subprocess.run([sys.executable, "-m", "command"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "")
