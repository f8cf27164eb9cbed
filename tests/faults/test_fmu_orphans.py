"""A parent that is killed leaves no process of an FMU, and a folder only until the next process needs one."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
from pathlib import Path
from time import monotonic, sleep

import pytest

from cdpr.base import processes, temporary
from cdpr.base.errors import OutputError
from cdpr.base.temporary import sweep
from cdpr.fmu.export.cache import fmu_cache
from cdpr.fmu.run.folder import PREFIX, Folder

GONE = 60.0  # s in which a process must be gone; it takes milliseconds, on a quiet machine
# A library that hangs while it is loaded: Python's lock is held meanwhile, so that no thread of the process runs.
HANGS = "struct Hang { Hang() { for (volatile int on = 1; on;) {} } } hang;"
PARENT = """
from cdpr.fmu.run.folder import Folder
from cdpr.fmu.run.instance import Plan
from cdpr.fmu.run.process import Process
Process(Plan("it", "3.0", "", {library!r}, "", (), (), 1e-3, False), Folder(), 60.0)
"""


@pytest.fixture
def root(tmp_path, monkeypatch):
    """A folder for temporary folders, swept anew."""
    path = tmp_path / "tmp"
    path.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(path))
    monkeypatch.setenv("TMPDIR", str(path))
    temporary._sweep_once.cache_clear()
    return path


def until(wanted):
    end = monotonic() + GONE
    while not (found := wanted()):
        assert monotonic() < end
        sleep(0.01)
    return found


def state(pid):
    """Return the state of a process: Z if it has ended and was not waited for; none if it is gone."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return ""


def child(pid):
    try:
        return [int(word) for word in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
    except FileNotFoundError:
        return []


@pytest.mark.skipif(sys.platform != "linux", reason="other systems have no death signal")
@pytest.mark.skipif(shutil.which("c++") is None, reason="no C++ compiler")
@pytest.mark.parametrize("stopped", [False, True], ids=["hanging", "stopped"])
def test_a_worker_ends_with_its_parent(root, tmp_path, stopped):
    (tmp_path / "hangs.cpp").write_text(HANGS)
    library = tmp_path / "hangs.so"
    subprocess.run(["c++", "-shared", "-fPIC", "-o", library, tmp_path / "hangs.cpp"], check=True)
    parent = subprocess.Popen([sys.executable, "-c", PARENT.format(library=str(library))])
    worker = 0
    try:
        (worker,) = until(lambda: child(parent.pid))
        until(lambda: "hangs.so" in Path(f"/proc/{worker}/maps").read_text())
        if stopped:
            os.kill(worker, signal.SIGSTOP)
            until(lambda: state(worker) == "T")
        assert len(list(root.iterdir())) == 1
        parent.kill()
        parent.wait()
        until(lambda: state(worker) in ("", "Z"))
    finally:
        parent.kill()
        parent.wait()
        if worker and state(worker) not in ("", "Z"):
            os.kill(worker, signal.SIGKILL)
    left = list(root.iterdir())
    assert len(left) == 1  # no process could remove it
    made = Folder()
    assert list(root.iterdir()) == [Path(made.path)]
    made.remove()


def test_a_parent_that_ended_before_is_noticed():
    code = f"from cdpr.base.processes import end_with; end_with({os.getpid()}); end_with(1); print('on')"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (1, "")


def test_a_process_outlives_the_thread_that_requested_it():
    """The system's signal comes when the thread that started a process ends, not only when its parent does."""
    code = f"from cdpr.base.processes import end_with; end_with({os.getpid()}); print('on', flush=True); input()"
    started = []
    command = [sys.executable, "-c", code]

    def ask():
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
        started.append(processes.start(lambda: subprocess.Popen(command, text=True, **pipes)))
        assert started[0].stdout.readline() == "on\n"

    thread = threading.Thread(target=ask)
    thread.start()
    thread.join()
    sleep(0.2)
    started[0].communicate("go on\n", timeout=GONE)
    assert started[0].returncode == 0


def test_stale_folders_are_removed_and_live_ones_are_kept(root):
    living = Folder()
    with subprocess.Popen(
        [
            sys.executable,
            "-c",
            "from cdpr.fmu.run.folder import Folder; it = Folder(); print(it.path, flush=True); input()",
        ],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as other:
        theirs = Path(other.stdout.readline().strip())
        (theirs / "sub").mkdir()
        (theirs / "sub/file").write_text("x")
        sweep(str(root), PREFIX)
        assert (theirs / "sub/file").exists()
        assert Path(living.path).exists()
        other.kill()
        other.wait()
    sweep(str(root), PREFIX)
    assert list(root.iterdir()) == [Path(living.path)]
    living.remove()
    living.remove()
    assert not any(root.iterdir())


@pytest.mark.slow
def test_the_next_export_removes_files_of_a_killed_one(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    compiler, started = tmp_path / "cxx", tmp_path / "started"
    compiler.write_text(f"#!/bin/sh\necho on >{started}; exec sleep 5\n")
    compiler.chmod(0o700)
    code = "from cdpr.fmu.export.library import library, sources; library(sources())"
    with subprocess.Popen([sys.executable, "-c", code], env={**os.environ, "CXX": str(compiler)}) as export:
        until(started.exists)
        export.kill()
    cache = tmp_path / "cdpr" / "fmu"
    (cache / "old.fmu.1.tmp").write_text("x")
    os.utime(cache / "old.fmu.1.tmp", (0, 0))
    (cache / "new.fmu.1.tmp").write_text("x")
    assert len(list(cache.iterdir())) >= 3  # one folder of a compiler, or one on each core beside the linker's
    fmu_cache()
    # a lock that nobody holds is a file without content, and removed as old
    assert [path.name for path in cache.iterdir() if not path.name.endswith("lock.tmp")] == ["new.fmu.1.tmp"]
    for path in cache.glob("*lock.tmp"):
        os.utime(path, (0, 0))
    fmu_cache()
    assert [path.name for path in cache.iterdir()] == ["new.fmu.1.tmp"]


def test_only_folders_of_this_user_are_swept(root, tmp_path, monkeypatch):
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere/file").write_text("x")
    (root / f"{PREFIX}link").symlink_to(tmp_path / "elsewhere")
    (root / f"{PREFIX}file").write_text("x")
    os.mkfifo(root / f"{PREFIX}pipe")
    (root / f"{PREFIX}left").mkdir()
    (root / f"{PREFIX}left/link").symlink_to(tmp_path / "elsewhere")
    (root / "cdpr-other").mkdir()
    monkeypatch.setattr(os, "geteuid", lambda: os.getuid() + 1)
    sweep(str(root), PREFIX)
    assert len(list(root.iterdir())) == 5
    monkeypatch.undo()
    sweep(str(root), PREFIX)
    assert sorted(path.name for path in root.iterdir()) == sorted(
        ["cdpr-other", f"{PREFIX}file", f"{PREFIX}link", f"{PREFIX}pipe"]
    )
    assert (tmp_path / "elsewhere/file").read_text() == "x"


def _make_many(root, number):
    tempfile.tempdir = root
    for _ in range(number):
        made = Folder()
        Path(made.path, "file").write_text("x")
        sweep(root, PREFIX)
        assert Path(made.path, "file").read_text() == "x"
        made.remove()


@pytest.mark.slow
def test_many_at_once_never_remove_each_others(root):
    context = multiprocessing.get_context("fork")
    many = [context.Process(target=_make_many, args=(str(root), 60)) for _ in range(4)]
    for each in many:
        each.start()
    for each in many:
        each.join(60)
    assert [each.exitcode for each in many] == [0] * 4
    assert not any(root.iterdir())


def test_a_folder_that_was_swept_before_it_was_locked_is_made_again(root, monkeypatch):
    made, real = [], tempfile.mkdtemp

    def mkdtemp(**options):
        made.append(real(**options))
        if len(made) == 1:
            sweep(str(root), PREFIX)  # another process, at the worst moment
        return made[-1]

    monkeypatch.setattr(tempfile, "mkdtemp", mkdtemp)
    with contextlib.closing(_Closing(Folder())) as held:
        assert held.folder.path == made[1]
        assert list(root.iterdir()) == [Path(made[1])]


class _Closing:
    def __init__(self, folder):
        self.folder, self.close = folder, folder.remove


def test_no_room_for_folders_is_one_clear_error(root):
    root.rmdir()
    with pytest.raises(OutputError, match="No such file or directory; set TMPDIR"):
        Folder()
