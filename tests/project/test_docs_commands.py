"""Every command in README and docs/ is run, or is listed with a reason among those that are not."""

from __future__ import annotations

import re
import shlex

import click
import pytest
from click.testing import CliRunner
from docs_cases import INSTALLED, NOT_RUN, PAGES, SLOW, WHOLE, code, commands, make_folder, shorter, words

from cdpr.ui.cli import cli

# By the page that shows them first: what several pages show runs once, as its folder is then taken.
SHOWN: dict[str, str] = {}
for _page, _text in PAGES.items():
    for _command in commands(_text):
        SHOWN.setdefault(_command, _page)
ALL = [(page, command) for command, page in SHOWN.items()]
OURS = [
    (page, command)
    for page, command in ALL
    if command.startswith("cdpr ") and page != WHOLE and not INSTALLED.search(command)
]
QUICK = [one for one in OURS if not one[1].removeprefix("cdpr ").startswith(SLOW)]
INLINE = [(page, said) for page, text in PAGES.items() for said in re.findall(r"`(cdpr [^`]+)`", text)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A reader's folder, which all commands share, as each makes what a later one takes."""
    path = tmp_path_factory.mktemp("reader")
    make_folder(path)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(path)
        patch.setenv("XDG_CONFIG_HOME", str(path / "config"))
        patch.setattr("cdpr.ui.cli.gui._hold", lambda signals: None)  # a window runs until it is closed
        for name in ("one", "another"):
            run(["run", "my_scenario.yaml", "--no-report", "--out", f"runs/{name}"])
        run(["fmu", "export", "my_robot.yaml", "-o", "plant.fmu"])
        yield path


def run(arguments, code=0):
    done = CliRunner().invoke(cli, arguments)
    if done.exception and not isinstance(done.exception, SystemExit):
        raise done.exception
    assert done.exit_code == code, done.output


@pytest.mark.slow
@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(("page", "command"), QUICK)
def test_a_command_runs(page, command):
    run([*words(command), *shorter(command)], code(command))


@pytest.mark.slow
@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(("page", "command"), [one for one in OURS if one not in QUICK])
def test_a_slow_command_runs(page, command):
    run([*words(command), *shorter(command)], code(command))


def test_unsupported_cases_are_reported():
    others = [command for _, command in ALL if not command.startswith("cdpr ")]
    assert [command for command in others if not command.startswith(tuple(NOT_RUN))] == []
    assert [start for start in NOT_RUN if not any(command.startswith(start) for command in others)] == []


def test_commands_are_in_console_blocks():
    """So that none escapes: in other places a line of a page begins with no command."""
    for page, text in PAGES.items():
        rest = re.sub(r"^```\w+\n.*?^```$", "", text, flags=re.DOTALL | re.MULTILINE)
        assert re.findall(r"^(?: +|\t)\$? ?(?:cdpr|python|pip|dask) .*$", rest, re.MULTILINE) == [], page


@pytest.mark.parametrize(("page", "said"), dict.fromkeys(INLINE))
def test_a_command_within_a_sentence_is_one(page, said):
    """Its words are commands and its options exist; what is written large or as ... is the reader's."""
    command, (_, *given) = cli, shlex.split(said)
    while isinstance(command, click.Group) and given and not given[0].startswith("-"):
        command, given = command.get_command(click.Context(command), given[0]), given[1:]
        assert command, said
    known = {name for parameter in command.params for name in (*parameter.opts, *parameter.secondary_opts)}
    assert {word for word in given if word.startswith("-")} <= {*known, "--help"}
