"""Bounds on reading files of others: CPU time, memory, a process that dies, Ctrl-C."""

from __future__ import annotations

import errno
import os
import resource
import signal
import subprocess
import sys

import pytest
from plugin_cases import SUCCESSOR

from cdpr.base.errors import CdprError, FormatError, PluginError, one_line
from cdpr.formats import import_file
from cdpr.formats.read import limits
from cdpr.formats.read.import_files import import_folder
from cdpr.formats.read.limits import bounded


@pytest.fixture(autouse=True)
def apart(monkeypatch):
    monkeypatch.setattr(limits, "APART", True)


def forever():
    while True:
        pass


def raises(error):
    def call():
        raise error

    return call


def test_results_and_errors_come_through():
    assert bounded(lambda: {"a": [1.5, None]}, "a.xml") == {"a": [1.5, None]}
    with pytest.raises(PluginError, match="no such thing"):
        bounded(raises(PluginError("no such thing")), "a.xml")
    with pytest.raises(RuntimeError) as caught:
        bounded(raises(ValueError("no number")), "a.xml")
    assert one_line(caught.value) == "ValueError: no number"
    assert "Traceback" in caught.value.__notes__[0]


@pytest.mark.parametrize("call", ["fork", "pipe"])
def test_no_process_to_read_in_is_an_error(monkeypatch, call):
    def fails():
        raise BlockingIOError(errno.EAGAIN, os.strerror(errno.EAGAIN))

    before = os.listdir("/proc/self/fd")
    monkeypatch.setattr(os, call, fails)
    with pytest.raises(CdprError, match=r"a\.xml: cannot start a process to read it: Resource temporarily"):
        bounded(forever, "a.xml")
    assert os.listdir("/proc/self/fd") == before


def test_its_memory_is_limited(monkeypatch):
    monkeypatch.setattr(limits, "MEMORY", 2**28)
    with pytest.raises(FormatError, match=r"a\.xml: reading it takes more than 0 GiB of memory"):
        bounded(lambda: bytes(2**33), "a.xml")  # more than the process can have free in its heap
    assert bounded(lambda: resource.getrlimit(resource.RLIMIT_AS)[0], "a.xml") > 2**28


def test_a_process_that_dies_is_reported():
    with pytest.raises(
        FormatError, match=r"a\.xml: the process that reads it was ended by SIGKILL; nothing was imported"
    ):
        bounded(lambda: os.kill(os.getpid(), signal.SIGKILL), "a.xml")


@pytest.mark.slow
def test_its_cpu_time_is_limited():
    with pytest.raises(FormatError, match=r"a\.xml: reading it takes more than 1 s of CPU time.*--seconds N"):
        bounded(forever, "a.xml", 1.0)


@pytest.mark.parametrize("seconds", [0.0, -1.0, float("nan"), float("inf")])
def test_seconds_that_are_no_bound_are_refused(seconds):
    with pytest.raises(CdprError, match="seconds: expected a number greater than 0"):
        bounded(forever, "a.xml", seconds)


@pytest.mark.slow
def test_a_file_that_takes_long_costs_the_others_of_its_folder_nothing(tmp_path, monkeypatch):
    for name in ("a", "b"):
        (tmp_path / f"{name}.yaml").write_text(SUCCESSOR)
    whole = __import__("cdpr.formats.read.gazebo", fromlist=["read"])
    read = whole.read
    monkeypatch.setattr(whole, "read", lambda path, *rest: forever() if path.stem == "a" else read(path, *rest))
    first, second = import_folder(tmp_path, seconds=1.0)
    assert "takes more than 1 s of CPU time" in first.error
    assert second.error == ""
    with pytest.raises(FormatError, match="takes more than 1 s of CPU time"):
        import_file(tmp_path / "a.yaml", seconds=1.0)


def test_ctrl_c_ends_it(tmp_path):
    (tmp_path / "a.yaml").write_text(SUCCESSOR)
    program = (
        "from cdpr.formats.read import gazebo; from cdpr.ui.cli import main\n"
        "def read(*given):\n    print('begun', flush=True)\n    while True: pass\n"
        f"gazebo.read = read\nimport sys; sys.argv = ['cdpr', 'import', {str(tmp_path / 'a.yaml')!r}]\nsys.exit(main())"
    )
    with subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True
    ) as process:
        assert process.stdout.readline() == b"begun\n"
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does: also the process that reads
        assert process.wait(60) == 130  # not the error of the CPU time limit, which is another code
