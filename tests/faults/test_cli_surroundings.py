"""The command line in odd surroundings: readers that go, names that are no UTF-8, early signals, loud plugins."""

from __future__ import annotations

import contextlib
import gc
import json
import os
import signal
import subprocess
import sys
import threading
import warnings

import pytest
from conftest import ROOT
from log_cases import make_header
from spread import sampled

from cdpr.base import user_folders as user_cache
from cdpr.base.errors import CdprError, OutputError
from cdpr.base.redirect_output import redirect_output
from cdpr.log.run_folder import RunFolder, claim
from cdpr.plugins.registry import registry
from cdpr.ui.cli import main
from cdpr.ui.cli.streams import printable_streams, streams

CAROCA = str(ROOT / "scenarios" / "caroca.yaml")
CDPR = [sys.executable, "-m", "cdpr"]
RUN = [*CDPR, "run", CAROCA, "--no-report", "--set", "simulation.duration=0.01"]
HEADER = make_header(2)


def test_of_several_runs_into_one_folder_one_begins(tmp_path):
    for k in range(30):
        barrier, begun = threading.Barrier(3), []

        def begin(k=k, barrier=barrier, begun=begun):
            barrier.wait()
            with contextlib.suppress(OutputError):
                begun.append(RunFolder(tmp_path / f"{k}", HEADER))

        threads = [threading.Thread(target=begin) for _ in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert len(begun) == 1


def test_two_commands_never_share_a_folder(tmp_path):
    """Each starts with its own file; of two at the same time neither may continue."""
    listed = iter([[], ["other", "mine"]])

    def listdir(path):
        return next(listed)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("os.listdir", listdir)
        with pytest.raises(OutputError, match="exists and is not empty"):
            claim(tmp_path, "mine")
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_a_reader_that_goes_does_not_change_how_a_run_ends(tmp_path):
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run([*RUN, "--out", tmp_path / "run"], stdout=write, stderr=write, check=False)
    os.close(write)
    assert done.returncode == 0
    assert json.loads((tmp_path / "run" / "run.json").read_text())["status"] == "finished"


@pytest.mark.slow
def test_a_folder_whose_name_is_no_utf_8(tmp_path):
    out = os.fsencode(tmp_path) + b"/run\xff"
    done = subprocess.run([*RUN, "--out", out], capture_output=True, check=False, env={**os.environ, "LC_ALL": "C"})
    assert (done.returncode, done.stdout.splitlines()[-1]) == (0, out), done.stderr
    with open(out + b"/run.json", "rb") as file:
        content = json.load(file)
    assert os.fsencode(content["argv"][-1]) == out


# A controller by which the process receives a signal while its loop is built.
INTERRUPTED = """\
import os
from cdpr.plugins import Controller

class Interrupted(Controller):
    def connect(self, report):
        os.kill(os.getpid(), {number})

    def control(self, time, state, desired, out):
        raise RuntimeError("the first sample was reached")
"""


@pytest.mark.parametrize(
    ("number", "code"),
    [
        pytest.param(signal.SIGTERM, 143, marks=pytest.mark.slow),
        pytest.param(signal.SIGHUP, 143, marks=pytest.mark.slow),
        (signal.SIGINT, 130),
    ],
)
def test_a_signal_before_the_first_sample(tmp_path, number, code):
    out, plugin = tmp_path / "run", tmp_path / "plugin.py"
    plugin.write_text(INTERRUPTED.format(number=int(number)))
    chosen = ["--plugin", plugin, "--set", "controller.type=Interrupted"]
    done = subprocess.run(
        [*CDPR, "run", CAROCA, "--out", out, *chosen],
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(number, signal.SIG_DFL),
        check=False,
    )
    assert (done.returncode, "Traceback" in done.stderr) == (code, False), done.stderr
    assert "stopped: interrupted before the first sample" in done.stderr
    assert json.loads((out / "run.json").read_text())["status"] == "interrupted"


def distribution(folder, name, entry_points, version="Version: 1.0"):
    info = folder / f"{name}-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\n{version}\n")
    (info / "entry_points.txt").write_bytes(entry_points)


@pytest.mark.parametrize(
    "spoilt", [(b"[cdpr]\n=\n",), (b"[cdpr]\n\xff = x:y\n",), (b"[cdpr]\nmine = sys\n", "Ver")], ids=str
)
def test_a_corrupt_entry_points_file_is_named_and_affects_no_other(tmp_path, monkeypatch, spoilt):
    distribution(tmp_path, "spoilt", *spoilt)
    monkeypatch.syspath_prepend(tmp_path)
    registry.cache_clear()
    try:
        found = registry()
    finally:
        registry.cache_clear()
    assert "reference" in found.names("backend")
    assert any("spoilt" in problem for problem in found.problems)


def test_a_plugin_that_prints_leaves_the_results_alone(tmp_path):
    distribution(tmp_path, "loud", b"[cdpr]\nloud = loud\n")
    (tmp_path / "loud.py").write_text("import os\nprint('from Python')\nos.system('echo from a process')\n")
    env = {**os.environ, "PYTHONPATH": str(tmp_path)}
    done = subprocess.run([*CDPR, "solvers", "--json"], capture_output=True, text=True, check=True, env=env)
    json.loads(done.stdout)
    assert "from Python" in done.stderr
    assert "from a process" in done.stderr


def test_threads_that_load_plugins_at_once_leave_stdout_alone(monkeypatch, capfd):
    """One enters first and leaves first: what each swapped, the other would put back."""
    monkeypatch.setattr(sys, "argv", ["cdpr"])
    steps = threading.Barrier(2, timeout=10)
    with printable_streams(), streams():
        ours = sys.stdout

        def load():
            with redirect_output():
                print("of a plugin")
                steps.wait()
                steps.wait()
            print("of another thread")
            steps.wait()

        thread = threading.Thread(target=load)
        thread.start()
        steps.wait()
        with redirect_output():
            steps.wait()
            print("of mine")
            steps.wait()
        print("result")
        assert sys.stdout is ours
        thread.join()
    found = capfd.readouterr()
    assert found.out == "result\n"
    assert sorted(found.err.splitlines()) == ["of a plugin", "of another thread", "of mine"]


def test_loading_a_plugin_swaps_no_stream_of_a_program():
    before = sys.stdout
    with redirect_output():
        assert sys.stdout is before


@sampled(1, "size", [10, 100_000])
@pytest.mark.parametrize("error", [None, CdprError("found out")])
def test_a_full_disk_under_the_results_is_reported_once(size, error, monkeypatch, capfd):
    """Data in the buffers must not fail again, nor reach the next user of the descriptor's number."""

    def command(**_):
        print("x" * size)
        if error is not None:
            raise error

    monkeypatch.setattr("cdpr.ui.cli.cli.main", command)
    with open("/dev/full", "wb") as full:
        kept = os.dup(1)
        os.dup2(full.fileno(), 1)
        patch = pytest.MonkeyPatch()
        patch.setattr(sys, "stdout", open(1, "w", closefd=False))  # noqa: SIM115 - as Python makes it
        patch.setattr(warnings, "showwarning", warnings.showwarning)
        try:
            with pytest.raises(SystemExit) as ended:
                main()
        finally:
            patch.undo()
            os.dup2(kept, 1)
            os.close(kept)
    gc.collect()
    lines = capfd.readouterr().err.splitlines()
    expected = "cannot write the output: [Errno 28] No space left on device"
    told_first = size > 10_000  # more than the buffers hold: the command ends there
    assert lines == ([expected] if error is None or told_first else [expected, "found out"])
    assert ended.value.code == (2 if error is not None and not told_first else 8)


def test_only_our_fallback_is_accepted(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    found = []
    for _ in range(2):
        user_cache.fallback.cache_clear()
        found.append(user_cache.fallback())
    assert found == [tmp_path / f"cdpr-{os.geteuid()}"] * 2
    found[0].chmod(0o777)  # anybody may have put anything there
    user_cache.fallback.cache_clear()
    assert user_cache.PASSING in str(user_cache.fallback())
    user_cache.fallback.cache_clear()


def test_a_user_without_home(monkeypatch):
    def unknown():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr("pathlib.Path.home", unknown)
    assert user_cache.user_cache() == user_cache.fallback()
