"""Output files of commands: none replaces an existing file without --force."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import click
import pytest
from click.testing import CliRunner
from conftest import ROOT

import cdpr
from cdpr.analysis.workspace import result as result_module
from cdpr.base.errors import OutputError
from cdpr.ui.cli import cli

CAROCA, ROBOT = str(ROOT / "scenarios" / "caroca.yaml"), str(ROOT / "scenarios" / "robots" / "caroca.yaml")
SHORT = ("--set", "simulation.duration=0.01")
CELLS = ("--cells", "2", "--out")
SLOW = {"view --figure", "bench solvers", "baseline save"}
NEW = {"design", "study", "run", "compare"}  # their output is a new or empty folder, or one that they continue

# Arguments of each command, whose last one is the name of the file or folder to write, and files in it.
FILES = {
    "view": ((ROBOT, "--no-open", "--out"), "page.html", ()),
    "view --figure": (("run", "--figure", "tension", "--out"), "figure.svg", ()),
    "size": ((CAROCA, *SHORT, "--out"), "size.html", ()),
    "workspace static": ((ROBOT, *CELLS), "other.npz", ()),
    "workspace combine": (("space.npz", "and", "space.npz", "--out"), "both.npz", ()),
    "workspace plot": (("space.npz", "--out"), "space.html", ()),
    "workspace export": (("space.npz", "--out"), "space.csv", ()),
    "export": ((ROBOT, "--to", "mjcf", "--out"), "robot.xml", ()),
    "fmu export": ((ROBOT, "--source-only", "--out"), "robot.fmu", ()),
    "info": ((ROBOT, "--out"), "folder", ("info.json", "robot.svg")),
    "tension": ((ROBOT, "--out"), "folder", ("tension.json",)),
    "bench solvers": (
        ("planar", "--poses", "2", "--adversaries", "0", "--solvers", "qp", "--out"),
        "b",
        ("bench.html", "1_planar.svg"),
    ),
    "baseline save": ((CAROCA, *SHORT, "--out"), "kept", ("caroca_reference.baseline.json",)),
}


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    """Return a folder with a run and a workspace."""
    folder = tmp_path_factory.mktemp("inputs")
    cdpr.simulate("caroca", overrides={"simulation.duration": 0.01}, out=folder / "run")
    CliRunner().invoke(cli, ["workspace", "static", ROBOT, *CELLS, str(folder / "space.npz")])
    return folder


def leaves(group=cli, path=()):
    """Yield path and command of all commands."""
    for name in group.list_commands(None):
        each = group.get_command(None, name)
        if isinstance(each, click.Group):
            yield from leaves(each, (*path, name))
        else:
            yield " ".join((*path, name)), each


def test_each_command_with_an_output_file_has_the_option():
    written = {name: each for name, each in leaves() if any(option.name == "out" for option in each.params)}
    lacking = {name for name, each in written.items() if not any(option.name == "force" for option in each.params)}
    assert lacking == NEW


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] * (name in SLOW)) for name in FILES])
def test_existing_files_need_force(name, inputs, tmp_path, monkeypatch):
    monkeypatch.chdir(inputs)
    given, out, inside = FILES[name]
    target = tmp_path / out
    command = [*name.removesuffix(" --figure").split(), *given, str(target)]
    first = CliRunner().invoke(cli, command)
    assert first.exit_code == 0, first.output
    files = [target / each for each in inside] or [target]
    before = [file.read_bytes() for file in files]
    for file, content in zip(files, before, strict=True):
        for other in target.iterdir() if inside else ():
            other.unlink()
        file.write_bytes(content)  # each of them alone is kept
        again = CliRunner().invoke(cli, command)
        assert isinstance(again.exception, OutputError)
        assert "already exists and is not overwritten; choose another --out, or --force" in str(again.exception)
        assert file.read_bytes() == content
    with monkeypatch.context() as patch:  # another process creates the file while this one computes
        patch.setattr("os.path.lexists", lambda path: False)
        late = CliRunner().invoke(cli, command)
    other = file.with_stem(f"{file.stem}-2")
    assert isinstance(late.exception, OutputError)
    assert f"'{file}' was created meanwhile and is not overwritten; this result was written to '{other}'" in str(
        late.exception
    )
    assert file.read_bytes() == content
    assert other.stat().st_size > 0
    forced = CliRunner().invoke(cli, [*command, "--force"])
    assert forced.exit_code == 0, forced.output


def test_a_folder_is_not_replaced(tmp_path):
    for more in ((), ("--force",)):
        result = CliRunner().invoke(cli, ["export", ROBOT, "--to", "mjcf", "--out", str(tmp_path), *more])
        assert str(result.exception) == f"'{tmp_path}' is a folder; choose another name"


def test_force_replaces_a_link_and_not_its_target(tmp_path):
    (tmp_path / "target.xml").write_text("mine")
    (tmp_path / "link.xml").symlink_to(tmp_path / "target.xml")
    command = ["export", ROBOT, "--to", "mjcf", "--out", str(tmp_path / "link.xml"), "--force"]
    assert CliRunner().invoke(cli, command).exit_code == 0
    assert not (tmp_path / "link.xml").is_symlink()
    assert (tmp_path / "target.xml").read_text() == "mine"
    assert (
        "Of a symbolic link, the link is replaced"
        in CliRunner().invoke(cli, ["export", "--help"], terminal_width=200).output
    )


def test_force_replaces_no_file_of_another_kind_by_a_page(tmp_path):
    notes = tmp_path / "notes.html"
    notes.write_text("mine")
    result = CliRunner().invoke(cli, ["view", ROBOT, "--no-open", "--out", str(notes), "--force"])
    assert "is not a page that cdpr wrote: it is not overwritten" in str(result.exception)
    assert Path(notes).read_text() == "mine"


def test_a_signal_to_end_leaves_no_incomplete_workspace(tmp_path, monkeypatch):
    before = signal.signal(signal.SIGTERM, lambda *_: pytest.fail("the command did not handle the signal"))
    monkeypatch.setattr(result_module, "seal_archive", lambda _: os.kill(os.getpid(), signal.SIGTERM))
    try:
        result = CliRunner().invoke(cli, ["workspace", "static", ROBOT, *CELLS, str(tmp_path / "w.npz")])
    finally:
        signal.signal(signal.SIGTERM, before)
    assert result.exit_code == 143
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("name", ["workspace static", "workspace plot", "workspace export", "size"])
def test_a_file_in_place_of_the_folder_is_named(name, inputs, tmp_path, monkeypatch):
    monkeypatch.chdir(inputs)
    (tmp_path / "file").write_text("mine")
    given, out, _ = FILES[name]
    result = CliRunner().invoke(cli, [*name.split(), *given, str(tmp_path / "file" / out)])
    assert str(result.exception) == f"{tmp_path / 'file'}: cannot be written: it is a file, not a folder"
