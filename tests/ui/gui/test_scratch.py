"""Folders of long runs: those of windows that were killed are removed, those of windows that live stay."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

import pytest
from conftest import ROOT

from cdpr.ui.gui.scratch import scratch, sweep

HOLD = """
from pathlib import Path
from cdpr.ui.gui.scratch import scratch
with scratch() as folder:
    path = Path(folder.path)
    (path / "log.mcap").write_text("x")
    print(path, flush=True)
    input()
"""


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    return tmp_path


def test_only_files_of_killed_windows_are_removed(place):
    (place / "cdpr-gui-file").write_text("mine\n")
    (place / "mine").mkdir()
    (place / "cdpr-gui-link").symlink_to(place / "mine")
    killed = subprocess.Popen([sys.executable, "-c", HOLD], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    try:
        left = killed.stdout.readline().strip()
        with scratch() as ours:
            sweep()
            here = {str(path) for path in place.iterdir()}
            assert {left, ours.path} <= here  # both live
            killed.kill()
            killed.wait()
            sweep()
            assert {str(path) for path in place.iterdir()} == here - {left}
    finally:
        killed.kill()
        killed.communicate()
    assert sorted(path.name for path in place.iterdir()) == ["cdpr-gui-file", "cdpr-gui-link", "mine"]


def test_a_folder_that_another_window_swept_before_it_was_locked_is_made_anew(place, monkeypatch):
    plain, made = tempfile.mkdtemp, []

    def make(**options):
        made.append(plain(**options))
        if len(made) == 1:
            sweep()
        return made[-1]

    monkeypatch.setattr("tempfile.mkdtemp", make)
    with scratch() as folder:
        assert folder.path == made[1]
        assert Path(folder.path).is_dir()
    assert list(place.iterdir()) == []


@pytest.mark.slow
def test_a_window_begins_by_removing_what_others_left(place):
    pytest.importorskip("websockets", reason="websockets is not installed: pip install 'cdpr[gui]'")
    from cdpr.ui.gui.editor import Editor
    from cdpr.ui.gui.window import Window

    left = place / "cdpr-gui-left"
    left.mkdir()
    with Window(Editor(str(ROOT / "scenarios" / "caroca.yaml")), print, port=0) as window:
        window.begin()
        assert not left.exists()
