"""Workspaces in chunks: the same bits as in memory, whoever computes them, wherever they were stopped."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from command_line import cdpr_here
from conftest import ROOT
from scipy import ndimage
from sealed_files import edit_file
from spread import sampled
from study_cases import wait_until
from workspace_cases import content

from cdpr import load_robot
from cdpr.analysis.jobs.folder import LEDGER_NAME, JobFolder
from cdpr.analysis.workspace import chunk_files
from cdpr.analysis.workspace import chunks as computing
from cdpr.analysis.workspace import required as sets
from cdpr.analysis.workspace.chunk_files import CHUNKS, MANIFEST, SUMMARY, chunk_path
from cdpr.analysis.workspace.chunks import Chunk, Task, run_chunk, workspace_in_chunks
from cdpr.analysis.workspace.connected import Connected
from cdpr.analysis.workspace.question import Question
from cdpr.analysis.workspace.regions import PIECE, Region, region
from cdpr.analysis.workspace.result import load_workspace, workspace
from cdpr.base.errors import CdprError, ExitCode, Interrupted, LogError, OutputError

ROBOTS = ROOT / "scenarios" / "robots"
CAROCA = ROBOTS / "caroca.yaml"
TURNED = [[1.0, 0.0, 0.0, 0.0], [0.99, 0.0, 0.0, np.sqrt(1.0 - 0.99**2)]]


@pytest.fixture(scope="module")
def robot():
    return load_robot(CAROCA)


@pytest.fixture(scope="module")
def place(robot):
    found = region(robot, cells=80)  # three chunks of a piece, the last one not full
    assert 2 * PIECE < found.cells < 3 * PIECE
    return found


@pytest.fixture(scope="module")
def whole(robot, place, tmp_path_factory):
    """A folder of an uninterrupted run."""
    folder = tmp_path_factory.mktemp("whole") / "w"
    workspace_in_chunks(robot, "static", place, folder, jobs=1, pieces=1)
    return folder


def chunks(robot, place, folder, **given):
    return workspace_in_chunks(robot, "static", place, folder, **{"jobs": 1, "pieces": 1, **given})


def stopped_after(count, robot, place, folder, **given):
    """Stop after this number of chunks, as Ctrl-C does."""

    def progress(done, total):
        if done >= count * PIECE:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        chunks(robot, place, folder, progress=progress, **given)


def same(one, other):
    return json.dumps(one) == json.dumps(other)


@pytest.mark.slow
@sampled(
    1,
    ("kind", "given"),
    [
        ("static", {}),
        ("wrench-feasible", {"required": sets.box([50.0, 50.0, 50.0, 5.0, 5.0, 5.0]), "at_least": 20.0}),
        ("ifcow", {"diameter": 0.01}),
        ("static", {"over": "any"}),
    ],
)
def test_the_bits_are_those_of_memory(robot, place, tmp_path, kind, given):
    """Of the summary and of all tables, whatever the threads and the size of the chunks."""
    if "over" in given:
        place = replace(place, orientations=np.array(TURNED))
    memory = workspace(robot, kind, place, **given)
    for jobs, pieces in ((1, 1), (2, 1), (2, 2), (3, 8)):
        folder = tmp_path / f"{jobs}_{pieces}"
        told = workspace_in_chunks(robot, kind, place, folder, jobs=jobs, pieces=pieces, **given)
        assert same(told, memory.summary())
        assert len(list((folder / CHUNKS).iterdir())) == -(-place.cells // (pieces * PIECE))
        read = load_workspace(folder)
        assert same(read.summary(), memory.summary())
        for name in ("value", "inside", "boundary", "limit", "evaluated"):
            one, other = getattr(read, name), getattr(memory, name)
            assert one.dtype == other.dtype
            assert np.array_equal(one, other, equal_nan=one.dtype == np.float64)
        assert (read.kind, read.robot, read.about["limited_by"]) == (
            memory.kind,
            memory.robot,
            memory.about["limited_by"],
        )
        assert read.question.to_dict(robot) == memory.question.to_dict(robot)
    assert content(tmp_path / "1_1") == content(tmp_path / "2_1")


def test_figures_are_those_of_the_table(robot, place, whole):
    read, told = load_workspace(whole), load_workspace(whole).summary()
    values = read.value[read.inside]
    assert told["value"]["mean"] == pytest.approx(values.mean(), rel=1e-12)
    assert (told["value"]["min"], told["value"]["max"]) == (values.min(), values.max())
    assert told["volume"] == read.inside.sum() * place.cell
    here = np.argwhere(read.inside)
    assert np.allclose(told["bounds"][0], place.lower + here.min(axis=0) * place.spacing)
    assert np.allclose(told["bounds"][1], place.lower + (here.max(axis=0) + 1) * place.spacing)
    assert told["components"] == ndimage.label(read.inside)[1]
    assert sum(told["outside_by"].values()) == (~read.inside & (read.limit >= 0)).sum()
    assert told["on_boundary"] == read.boundary.sum()


SHAPES = [(7, 6, 5), (1, 30, 20), (40, 1, 1), (1, 1, 9), (20, 1, 30), (2, 50, 3), (1, 1, 1), (30, 20, 10)]


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("share", [0.0, 0.1, 0.4, 0.6, 0.8, 1.0])
def test_components_against_scipy(shape, share):
    """Written in parts of any length."""
    rng = np.random.default_rng(0)
    table = rng.random(shape) < share
    counted, cells, at = Connected(shape), table.ravel(), 0
    while at < len(cells):
        count = int(rng.integers(1, 60))
        counted.add(cells[at : at + count])
        at += count
    assert counted.pieces == ndimage.label(table)[1]


def test_components_are_reported(robot, place):
    found = workspace(robot, "static", region(robot, cells=8))
    assert found.summary()["components"] == ndimage.label(found.inside)[1] == 1
    inside = np.zeros(found.inside.shape, dtype=bool)
    inside[0, 0, 0] = inside[1, 1, 0] = inside[2, 1, 0] = True  # the first two share an edge alone
    apart = replace(found, inside=inside)
    assert apart.summary()["components"] == 2
    from cdpr.ui.report.text.workspace import lines

    assert any("in pieces" in line and "2," in line for line in lines(apart.summary()))
    assert not any("in pieces" in line for line in lines(found.summary()))


@pytest.mark.slow
@pytest.mark.parametrize("jobs", [1, 2])
def test_it_continues_where_it_stopped(robot, place, whole, tmp_path, jobs):
    folder = tmp_path / "w"
    stopped_after(1, robot, place, folder)
    assert [file.name for file in (folder / CHUNKS).iterdir()] == ["000000.npz"]
    assert not (folder / SUMMARY).exists()
    with pytest.raises(LogError, match="is not finished: 1 of 3 chunks exist"):
        load_workspace(folder)
    first = chunk_path(folder, 0).stat().st_ino
    with pytest.raises(OutputError, match="contains 1 of 3 chunks of this workspace: continue by --resume"):
        chunks(robot, place, folder)
    seen = []
    chunks(robot, place, folder, resume=True, jobs=jobs, progress=lambda done, total: seen.append(done))
    assert (seen[0], seen[-1]) == (PIECE, place.cells)
    assert chunk_path(folder, 0).stat().st_ino == first  # not computed again
    assert content(folder) == content(whole)
    again = []
    chunks(robot, place, folder, resume=True, progress=lambda done, total: again.append(done))
    assert again == [place.cells]
    assert content(folder) == content(whole)


def test_it_may_resume_what_never_began(robot, place, whole, tmp_path):
    chunks(robot, place, tmp_path / "w", resume=True)
    assert content(tmp_path / "w") == content(whole)


def test_a_chunk_ends_without_waiting_clients(robot, place):
    task = Task(robot, "static", Question(), place, "all", 1)
    with pytest.raises(Interrupted):
        run_chunk(Chunk(task, 0, range(10)), lambda: True)


def _flip(file):
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 1
    file.write_bytes(content)


DAMAGE = {
    "flipped": _flip,
    "half": lambda file: os.truncate(file, file.stat().st_size // 2),
    "empty": lambda file: os.truncate(file, 0),
    "gone": lambda file: file.unlink(),
    "half a temporary": lambda file: file.rename(f"{file}.tmp"),
}


@pytest.mark.slow
@sampled(2, "how", DAMAGE)
def test_damaged_chunks_are_computed_again(robot, place, whole, tmp_path, how):
    folder = tmp_path / "w"
    chunks(robot, place, folder)
    DAMAGE[how](chunk_path(folder, 1))
    with pytest.raises(LogError, match=r"000001\.npz: is damaged; the command that wrote it computes it again"):
        load_workspace(folder)
    seen = []
    chunks(robot, place, folder, resume=True, progress=lambda done, total: seen.append(done))
    assert seen == [place.cells - PIECE, place.cells]
    assert content(folder) == content(whole)


def test_a_torn_line_of_the_ledger_is_computed_again(robot, place, whole, tmp_path):
    folder = tmp_path / "w"
    chunks(robot, place, folder)
    os.truncate(folder / LEDGER_NAME, (folder / LEDGER_NAME).stat().st_size - 10)
    chunks(robot, place, folder, resume=True)
    assert content(folder) == content(whole)


def test_another_workspace_is_rejected_with_the_difference(robot, place, tmp_path):
    folder = tmp_path / "w"
    stopped_after(1, robot, place, folder)
    before = content(folder) if (folder / SUMMARY).exists() else (folder / LEDGER_NAME).read_bytes()
    heavier = load_robot(CAROCA, overrides={"platform.mass": 99.0})
    weaker = load_robot(CAROCA, overrides={"tension.max": 400.0})
    cases = {
        "robot.platform.mass is 150.0 there, 99.0 here": lambda: chunks(heavier, place, folder, resume=True),
        r"robot.cables.0.tension_max is .* there, 400.0 here": lambda: chunks(weaker, place, folder, resume=True),
        "question.at_least is null there, 3.0 here": lambda: chunks(robot, place, folder, resume=True, at_least=3.0),
        "region.cells.0 is 80 there, 79 here": lambda: chunks(robot, region(robot, cells=79), folder, resume=True),
        "region.orientations is": lambda: chunks(
            robot, replace(place, orientations=np.array(TURNED)), folder, resume=True
        ),
        'over is "all" there, "any" here': lambda: chunks(robot, place, folder, resume=True, over="any"),
        'kind is "static" there, "payload" here': lambda: workspace_in_chunks(robot, "payload", place, folder),
        "cells of a chunk is 65536 there, 131072 here": lambda: chunks(robot, place, folder, resume=True, pieces=2),
    }
    for text, call in cases.items():
        with pytest.raises(OutputError, match=f"contains another workspace: {text}.*; choose another folder"):
            call()
    assert (folder / LEDGER_NAME).read_bytes() == before


def test_versions_that_may_compute_other_bits_are_refused(robot, place, tmp_path):
    folder = tmp_path / "w"
    stopped_after(1, robot, place, folder)
    text = (folder / MANIFEST).read_text()

    def older(content):
        content["versions"]["numpy"] = "0.1"
        content["digest"] = chunk_files.digest(content)

    edit_file(folder / MANIFEST, older)
    with pytest.raises(OutputError, match=r"versions.numpy is .0\.1. there"):
        chunks(robot, place, folder, resume=True)
    (folder / MANIFEST).write_text(text[:50])
    with pytest.raises(LogError, match=r"workspace\.json: cannot be read as a workspace in chunks"):
        chunks(robot, place, folder, resume=True)


def test_two_at_once_are_refused(robot, place, tmp_path):
    folder = tmp_path / "w"
    stopped_after(1, robot, place, folder)
    known = json.loads((folder / MANIFEST).read_text())
    other = JobFolder(folder, chunk_files.KIND, known)
    try:
        with pytest.raises(OutputError, match="another cdpr workspace is at work there"):
            chunks(robot, place, folder, resume=True)
    finally:
        other.close()


def test_folders_that_are_taken_are_refused(robot, place, tmp_path):
    (tmp_path / "mine").write_text("x")
    with pytest.raises(OutputError, match="exists, is not empty and contains no workspace; choose another folder"):
        chunks(robot, place, tmp_path)
    with pytest.raises(OutputError, match="is a file, not a folder; choose another name"):
        chunks(robot, place, tmp_path / "mine")


def test_insufficient_memory_or_disk_is_reported(robot, place, whole, tmp_path, monkeypatch):
    monkeypatch.setattr(chunk_files, "MEMORY", 0.0)
    with pytest.raises(
        LogError, match=r"cells need .* GiB of memory.*summary\.json contains its figures; choose fewer"
    ):
        load_workspace(whole)
    huge = region(robot, cells=[10**7, 3000, 3000])
    with pytest.raises(CdprError, match="which a table in memory holds; in chunks"):
        workspace(robot, "static", huge)
    with pytest.raises(OutputError, match="more than its disk has: fewer --cells"):
        chunks(robot, huge, tmp_path / "w")
    wide = Region(place.lower, place.upper, (2, 10_000, 1_001), place.orientations)
    with pytest.raises(CdprError, match="in a layer across the first"):
        chunks(robot, wide, tmp_path / "w")


@pytest.mark.slow
def test_commands_read_folders(whole, robot, tmp_path):
    done = cdpr_here("workspace", "static", CAROCA, "--cells", "20", "--chunks", tmp_path / "w", "--json")
    told = json.loads(done.stdout)
    assert told.pop("file") == str(tmp_path / "w")
    memory = json.loads(cdpr_here("workspace", "static", CAROCA, "--cells", "20", "--json").stdout)
    assert told == memory
    cdpr_here("workspace", "plot", tmp_path / "w")
    assert (tmp_path / "w.html").is_file()
    cdpr_here("workspace", "export", tmp_path / "w", "--out", tmp_path / "w.vti")
    compared = cdpr_here("workspace", "compare", tmp_path / "w", "--count", "20", "--json")
    assert json.loads(compared.stdout)["different"] == []
    cdpr_here("workspace", "combine", tmp_path / "w", "minus", tmp_path / "w", "--out", tmp_path / "n.npz")
    assert load_workspace(tmp_path / "n.npz").volume == 0.0


@pytest.mark.parametrize(
    ("options", "text"),
    [
        (["--resume"], "--resume requires --chunks"),
        (["--scheduler", "tcp://127.0.0.1:9"], "--scheduler requires --chunks"),
        (["--chunks", "w", "--method", "octree"], "--chunks requires --method grid, got octree"),
        (["--chunks", "w", "--out", "w.npz"], "--out does not go with --chunks"),
        (["--chunks", "w", "--jobs", "2", "--scheduler", "tcp://127.0.0.1:9"], "--jobs does not go with --scheduler"),
        (["--chunks", ""], "expected a name"),
    ],
)
def test_options_that_do_not_go_together(tmp_path, options, text):
    done = cdpr_here("workspace", "static", CAROCA, *options, cwd=tmp_path, code=ExitCode.BAD_INPUT)
    assert text in done.stderr
    assert not list(tmp_path.iterdir())


def test_an_interrupted_command_prints_how_to_continue(tmp_path, monkeypatch):
    def interrupted(*given):
        raise KeyboardInterrupt

    monkeypatch.setattr(computing, "beside", interrupted)
    words = ["static", CAROCA, "--cells", "20", "--chunks", tmp_path / "w"]
    for more in ([], ["--resume"]):
        done = cdpr_here("workspace", *words, *more, code=ExitCode.INTERRUPTED)
        line = " ".join(map(str, ["cdpr workspace", *words, "--resume"]))
        assert done.stderr.endswith(f"interrupted; continue by: {line}\n")
    monkeypatch.undo()
    cdpr_here("workspace", *words, "--resume")


@pytest.mark.slow
def test_killed_and_interrupted_commands_continue(tmp_path):
    """SIGKILL, then Ctrl-C, which prints how to continue; the bits are those of an uninterrupted run."""
    folder = tmp_path / "w"
    line = [sys.executable, "-m", "cdpr", "workspace", "static", str(CAROCA), "--cells", "170", "--chunks"]
    for count, number in enumerate((signal.SIGKILL, signal.SIGINT), 1):
        words = [*line, str(folder), "--jobs", "1", *(["--resume"] if count > 1 else [])]
        process = subprocess.Popen(words, stderr=subprocess.PIPE, text=True)
        ledger = folder / LEDGER_NAME
        wait_until(lambda: ledger.exists() and ledger.read_bytes().count(b"\n") >= count)  # noqa: B023 - called here
        process.send_signal(number)
        _, errors = process.communicate(timeout=60)
        if number == signal.SIGINT:
            assert process.returncode == ExitCode.INTERRUPTED
            assert f"interrupted; continue by: cdpr workspace static {CAROCA} " in errors
            assert "--resume" in errors
            assert "Traceback" not in errors
    assert not (folder / SUMMARY).exists()
    cdpr_here(*line[3:], folder, "--resume")
    cdpr_here(*line[3:], tmp_path / "whole")
    assert content(folder) == content(tmp_path / "whole")
