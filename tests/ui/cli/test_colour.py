"""Colours, bar and groups of the command line: on terminals alone, and nowhere where NO_COLOR is set."""

from __future__ import annotations

import io
import os
import subprocess
import sys

import pytest
from click.testing import CliRunner
from conftest import ROOT
from spread import sampled

from cdpr.ui.cli import COMMANDS, GROUPS, cli
from cdpr.ui.cli.colour import bar, coloured
from cdpr.ui.cli.streams import Printable

pty = pytest.importorskip("pty", reason="pseudo-terminals are of POSIX")

ROBOT = ROOT / "scenarios" / "robots" / "caroca.yaml"


class Terminal(io.StringIO):
    """A stream that is a terminal."""

    errors, encoding = "strict", "utf-8"

    def isatty(self):
        return True


def on_a_terminal(*arguments, **environment):
    """Return what a terminal gets of a command."""
    master, slave = pty.openpty()
    known = {key: value for key, value in os.environ.items() if key != "NO_COLOR"} | {"TERM": "xterm"} | environment
    command = [sys.executable, "-m", "cdpr", *map(str, arguments)]
    with subprocess.Popen(command, stdin=slave, stdout=slave, stderr=slave, env=known) as process:
        os.close(slave)
        found = b""
        while True:
            try:
                part = os.read(master, 65536)
            except OSError:  # its other end is closed
                break
            if not part:
                break
            found += part
        process.wait()
    os.close(master)
    return found.decode()


def test_a_terminal_gets_colours_unless_it_wants_none():
    assert "\x1b[" in on_a_terminal("validate", ROBOT, "nothing.yaml", "--help")
    assert "\x1b[" not in on_a_terminal("validate", "--help", NO_COLOR="1")


def test_a_pipe_gets_the_same_text_without():
    done = subprocess.run(
        [sys.executable, "-m", "cdpr", "validate", "--help"], capture_output=True, text=True, check=True
    )
    assert "\x1b" not in done.stdout + done.stderr
    terminal = on_a_terminal("validate", "--help", NO_COLOR="1", COLUMNS="80")
    assert terminal.replace("\r\n", "\n") == done.stdout


@pytest.mark.parametrize(
    ("text", "part", "colour"),
    [
        ("  simulated           4 s, 4001 samples, finished\n", "finished", 32),
        ("  simulated           4 s, 40 samples, diverged\n", "diverged", 31),
        ("warning: so\n", "warning: ", 33),
        ("file.yaml:3:1: mass: must be positive\n", "file.yaml:3:1:", 31),
        ("Options:\n", "Options:", 1),
        ("agree: caroca, 4 s\n", "agree", 32),
        ("solver qp: DISAGREE: so\n", "DISAGREE", 31),
    ],
)
def test_coloured_words(text, part, colour):
    assert f"\x1b[{colour}m{part}\x1b[0m" in coloured(text)


@pytest.mark.parametrize("text", ["  infeasible steps    0 of 4001\n", '{"status": "finished"}\n', "mass: 12 kg\n"])
def test_negative_cases(text):
    assert all(f"\x1b[{colour}m" not in coloured(text) for colour in (31, 32, 33))


def test_no_text_switches_a_colour_on(monkeypatch):
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("TERM", "xterm")
    stream = Terminal()
    Printable(stream).write("a\x1b[31mb, finished\n")
    assert "\\x1b[31m" in stream.getvalue()
    assert "\x1b[31m" not in stream.getvalue()
    assert "\x1b[32mfinished" in stream.getvalue()


def test_a_bar_is_full_in_the_end():
    assert bar(0.0, "utf-8") == "─" * 24
    assert bar(0.5, "utf-8") == "━" * 12 + "─" * 12
    assert bar(2.0, "latin-1") == "#" * 24


@sampled(
    1,
    ("command", "last"),
    [
        (["tension", ROBOT, "--solver", "qp,closed_form"], "2 of 2 solvers"),
        (["size", ROOT / "scenarios" / "planar.yaml", "--broken"], "5 of 5 load cases"),
    ],
)
def test_commands_count_what_they_have_done(command, last, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("cdpr.ui.cli.progress.FILE_SECONDS", 0.0)
    done = CliRunner().invoke(cli, list(map(str, command)))
    assert done.exit_code == 0, done.output
    assert last in done.stderr


def test_every_command_is_in_one_group():
    names = [name for group in GROUPS.values() for name in group]
    assert sorted(names) == sorted(COMMANDS)
    found = CliRunner().invoke(cli, ["--help"]).output
    assert all(f"{heading}:" in found for heading in GROUPS)
    assert all(f"\n  {name} " in found for name in COMMANDS)
