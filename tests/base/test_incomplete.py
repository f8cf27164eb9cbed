"""Incomplete files: those of killed writers are removed, those in use and those of others stay."""

from __future__ import annotations

import subprocess
import sys

import pytest

from cdpr.base import incomplete as module
from cdpr.base.incomplete import incomplete, sweep
from cdpr.log.files import create, replace, replacing

WRITER = """
import sys
from pathlib import Path
from cdpr.log.files import replacing
with replacing(Path(sys.argv[1])) as file:
    file.write(b"half")
    file.flush()
    print(file.name, flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def first(monkeypatch):
    """Let each writer be the first of its process in a folder."""
    monkeypatch.setattr(module, "_sweep_once", sweep)


def names(folder):
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize("write", [replace, create])
def test_the_file_of_a_killed_writer_is_removed_by_the_next_one(tmp_path, first, write):
    arguments = [sys.executable, "-c", WRITER, str(tmp_path / "w.npz")]
    with subprocess.Popen(arguments, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as writer:
        left = writer.stdout.readline().strip()
        write(tmp_path / "a.txt", "a")
        assert names(tmp_path) == sorted(["a.txt", left.rpartition("/")[2]])  # its writer lives
        writer.kill()
        writer.wait()
    assert len(names(tmp_path)) == 2
    write(tmp_path / "b.txt", "b")
    assert names(tmp_path) == ["a.txt", "b.txt"]


def test_other_files_stay(tmp_path, first):
    others = ["w.npz.tmp", "notes.tmp", "w.npz.0123456789AB.tmp", "w.npz.0123456789ab.tmp.gz"]
    for name in others:
        (tmp_path / name).write_text("mine")
    (tmp_path / "w.npz.0123456789ab.tmp").mkdir()
    (tmp_path / "w.npz.0123456789ac.tmp").symlink_to(tmp_path / "notes.tmp")
    before = names(tmp_path)
    replace(tmp_path / "w.npz", b"w")
    assert names(tmp_path) == sorted([*before, "w.npz"])


def test_a_file_is_locked_until_it_has_its_name(tmp_path, monkeypatch):
    def renamed(temporary, path):
        sweep(str(tmp_path))
        return rename(temporary, path)

    rename = module.os.replace
    monkeypatch.setattr(module.os, "replace", renamed)
    with replacing(tmp_path / "w.npz") as file:
        file.write(b"whole")
    assert names(tmp_path) == ["w.npz"]
    assert (tmp_path / "w.npz").read_bytes() == b"whole"


def test_the_file_of_a_writer_that_raises_is_removed(tmp_path):
    def fail():
        with incomplete(tmp_path / "w.npz") as temporary:
            assert names(tmp_path) == [temporary.name]
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail()
    assert names(tmp_path) == []
