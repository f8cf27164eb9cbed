"""Foreign text (names of files, robots, plugins, variables) reaches the terminal without control characters."""

from __future__ import annotations

import json
import sys
import warnings

import pytest
import yaml
from conftest import ROOT
from fmu_cases import description, make_fmu, variable

from cdpr.base.errors import CdprError
from cdpr.base.problems import printable
from cdpr.plugins.registry import registry
from cdpr.ui.cli import main
from cdpr.ui.cli.streams import printable_streams

# Clear the screen, colour by one control character, turn the direction of writing, write over the line.
EVIL = "x\x1b[2J\x9b31m\u202e\ry\x07"
SHOWN = r"x\x1b[2J\x9b31m\u202e\ry\x07"
TAIL = r"31m\u202e\ry\x07"  # click leaves out the sequences at the start where there is no terminal
# The part that XML can represent.
XML = "x\x9b2J\u202ey"


@pytest.fixture
def said(monkeypatch, capfd, tmp_path):
    """Run `cdpr ...` and return its complete output, including parts that only a terminal shows."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments, code):
        with monkeypatch.context() as patch:
            patch.setattr(sys, "argv", ["cdpr", *arguments])
            patch.setattr(warnings, "showwarning", warnings.showwarning)
            with pytest.raises(SystemExit) as exit_:
                main()
        streams = capfd.readouterr()
        assert exit_.value.code == code, streams
        text = streams.out + streams.err
        assert [letter for letter in text if not letter.isprintable() and letter not in "\n\t"] == []
        return text

    return run


def test_letters_stay_and_controls_are_escaped():
    assert printable("ä 日本 😀 a\\b") == "ä 日本 😀 a\\b"
    assert printable(EVIL) == SHOWN
    assert printable("a\nb\tc\udcff") == r"a\nb\tc\udcff"


def test_errors_keep_their_lines_only():
    assert str(CdprError(f"{EVIL}\nnext")) == f"{SHOWN}\nnext"


@pytest.mark.parametrize(
    "command", ["validate", "info", "tension", "run", "fmu info", "fmu trust", "export --to csv", "compare"]
)
def test_file_names(command, said):
    assert SHOWN in said(*command.split(), EVIL, code=2)


def test_values_of_a_file(tmp_path, said):
    robot = yaml.safe_load((ROOT / "scenarios/robots/planar.yaml").read_text())
    (tmp_path / EVIL).write_text(yaml.safe_dump(robot))
    assert TAIL in said("validate", EVIL, code=0)
    robot["name"] = robot["cables"][0]["name"] = robot["platform"]["mass"] = robot[EVIL] = EVIL
    (tmp_path / EVIL).write_text(yaml.safe_dump(robot))
    assert said("validate", EVIL, code=2).count(SHOWN) >= 4  # each place begins with the name of the file


def test_every_text_of_an_fmu(tmp_path, said):
    rows = [variable(2, f"{XML}{i}", i, "input", start="0", unit=XML) for i in range(3)]
    rows.append(variable(2, "text", 9, "parameter", kind="String", start=XML))
    xml = description(2, rows, units={XML: {"m": 1}})
    texts = {"description": XML, "generationTool": XML, "version": XML}
    head = "".join(f' {key}="{value}"' for key, value in texts.items())
    xml = xml.replace('guid="{1}"', f'guid="{XML}"{head}').replace('modelName="plant"', f'modelName="{XML}"')
    xml = xml.replace("<ScalarVariable", f'<ScalarVariable description="{XML}"')
    make_fmu(tmp_path / "a.fmu", xml, fmi=2)
    assert r"x\x9b2J\u202ey" in said("fmu", "info", "a.fmu", code=0)
    said("fmu", "check", "a.fmu", str(ROOT / "scenarios/robots/caroca.yaml"), code=2)
    said("fmu", "map", "a.fmu", str(ROOT / "scenarios/robots/caroca.yaml"), code=2)
    for text in ("fmiVersion", "valueReference", "causality", "start"):
        broken = xml.replace(f'{text}="', f'{text}="{XML}', 1)
        make_fmu(tmp_path / "b.fmu", broken, fmi=2)
        said("fmu", "info", "b.fmu", code=0 if text == "causality" else 2)


def test_names_of_plugins(said, monkeypatch):
    monkeypatch.setattr(registry(), "problems", [f"plugin '{EVIL}' of {EVIL}: {EVIL}"])
    assert f"{TAIL}' of " in said("plugins", code=0)
    assert SHOWN in said("run", str(ROOT / "scenarios/caroca.yaml"), "--backend", EVIL, code=3)


def test_the_line_of_progress_is_still_written_anew(capsys):
    with printable_streams():
        sys.stderr.write("1 of 2\r")
        sys.stderr.writelines(["a\rb\n", "c\n"])
    assert capsys.readouterr().err == "1 of 2\ra\\rb\nc\n"
    assert type(sys.stdout).__name__ != "Printable"


def test_json_stays_json(tmp_path, said):
    make_fmu(tmp_path / EVIL)
    assert json.loads(said("fmu", "info", EVIL, "--json", code=0))["file"] == EVIL


class UnprintableError(Exception):
    def __str__(self):
        raise RuntimeError


@pytest.mark.parametrize(
    ("error", "text"),
    [
        (MemoryError("Unable to allocate 9 GiB"), "not enough memory (Unable to allocate 9 GiB): reduce the task"),
        (MemoryError(), "not enough memory: reduce the task"),
        (UnprintableError(), "internal error: UnprintableError\n"),
    ],
)
def test_failures_end_without_a_traceback(monkeypatch, capsys, error, text):
    def fail(**_):
        raise error

    monkeypatch.setattr("cdpr.ui.cli.cli.main", fail)
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == 1
    assert capsys.readouterr().err.startswith(text)
