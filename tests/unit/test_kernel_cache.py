"""Compiled kernels: never stale, and no folder to keep them in is no reason to fail."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys

import pytest
from conftest import ROOT

from cdpr.model import kernel_cache

RUN = "import cdpr; print(cdpr.simulate({!r}, overrides={{'simulation.duration': 0.01}}).rows[-1].tolist())"


def run(tree, **env):
    return subprocess.run(
        [sys.executable, "-c", RUN.format(str(tree / "scenarios" / "caroca.yaml"))],
        env={**os.environ, "PYTHONPATH": str(tree), **env},
        cwd=tree,
        capture_output=True,
        text=True,
        check=True,
    )


@pytest.mark.slow
def test_a_change_in_a_called_kernel_is_seen(tmp_path):
    """numba looks only at the file of the kernel itself; this one is called from others."""
    for name in (*kernel_cache.PACKAGES, "scenarios"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    cache = {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    before = run(tmp_path, **cache).stdout
    kernels = tmp_path / "cdpr" / "model" / "kernels.py"
    text = kernels.read_text()
    changed = text.replace("scale = tension[i] /", "scale = 0.9 * tension[i] /")
    assert changed != text
    kernels.write_text(changed)
    assert run(tmp_path, **cache).stdout != before
    kernels.write_text(text)
    assert run(tmp_path, **cache).stdout == before


@pytest.mark.slow
def test_without_a_place_for_kernels_it_still_runs(tmp_path):
    done = run(ROOT, NUMBA_CACHE_DIR="/dev/null/nowhere")
    assert "cannot be written" in done.stderr
    assert done.stdout == run(ROOT).stdout


def test_other_states_of_the_sources_are_kept_but_not_for_ever(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    for i in range(20):
        old = tmp_path / f"kernels-{i}"
        old.mkdir()
        os.utime(old, (i, i))
    for i in range(20, 30):  # of checkouts that are in use
        (tmp_path / f"kernels-{i}").mkdir()
    (tmp_path / "mine").mkdir()
    chosen = kernel_cache.folder()
    assert chosen == str(tmp_path / f"kernels-{kernel_cache.digest()}")
    kept = {f"kernels-{i}" for i in range(20 - kernel_cache.KEPT, 30)} | {f"kernels-{kernel_cache.digest()}"}
    assert {path.name for path in tmp_path.glob("kernels-*")} == kept
    assert (tmp_path / "mine").exists()


def test_what_is_used_stays_however_old_it_is(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    chosen = kernel_cache.folder()
    os.utime(chosen, (0, 0))
    for i in range(20):
        (tmp_path / f"kernels-{i}").mkdir()
    assert kernel_cache.folder() == chosen
    assert os.stat(chosen).st_mtime > 0
