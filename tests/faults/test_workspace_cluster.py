"""Workspaces in chunks on a Dask cluster on this machine: the same files, to the byte."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from importlib.util import find_spec

import pytest
from clusters import cluster_in
from command_line import cdpr_here
from conftest import ROOT
from study_cases import wait_until
from workspace_cases import content

import cdpr
from cdpr.analysis.jobs.folder import LEDGER_NAME
from cdpr.analysis.workspace import box, region, workspace
from cdpr.analysis.workspace.chunk_files import SUMMARY
from cdpr.analysis.workspace.chunks import workspace_in_chunks
from cdpr.base.errors import CdprError, ExitCode

# Searched, not imported, because an import takes seconds, and each of pytest's processes collects this file.
pytestmark = [
    pytest.mark.skipif(find_spec("distributed") is None, reason="distributed is not installed"),
    pytest.mark.slow,
]

CAROCA = ROOT / "scenarios" / "robots" / "caroca.yaml"
GIVEN = {"required": box([50.0, 50.0, 50.0, 5.0, 5.0, 5.0])}
LINE = ["workspace", "wrench-feasible", str(CAROCA), "--wrench-box", "50,50,50,5,5,5", "--cells", "200"]


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    yield from cluster_in(tmp_path_factory.mktemp("cluster"))


def begin(folder, cluster, *options):
    """Start a command on the cluster and wait for its first chunk."""
    words = [sys.executable, "-m", "cdpr", *LINE, "--chunks", str(folder), "--scheduler", cluster[1], *options]
    before = lines(folder)
    process = subprocess.Popen(words, stderr=subprocess.PIPE, text=True)
    wait_until(lambda: lines(folder) > before)
    return process


def lines(folder):
    ledger = folder / LEDGER_NAME
    return ledger.read_bytes().count(b"\n") if ledger.exists() else 0


def test_the_files_are_the_same(cluster, tmp_path):
    robot = cdpr.load_robot(CAROCA)
    place = region(robot, cells=110)
    told = [
        workspace_in_chunks(robot, "wrench-feasible", place, tmp_path / name, pieces=1, **GIVEN, **where)
        for name, where in (("here", {"jobs": 2}), ("there", {"scheduler": cluster[1]}))
    ]
    assert told[0] == told[1] == workspace(robot, "wrench-feasible", place, **GIVEN).summary()
    assert content(tmp_path / "here") == content(tmp_path / "there")
    assert lines(tmp_path / "there") == 6


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_a_stopped_command_continues_here(cluster, tmp_path, number):
    folder = tmp_path / "w"
    process = begin(folder, cluster)
    process.send_signal(number)
    _, errors = process.communicate(timeout=60)
    if number == signal.SIGINT:
        assert process.returncode == ExitCode.INTERRUPTED
        assert "interrupted; continue by: cdpr workspace wrench-feasible " in errors
    assert not (folder / SUMMARY).exists()
    cdpr_here(*LINE, "--chunks", folder, "--resume")
    cdpr_here(*LINE, "--chunks", tmp_path / "whole")
    assert content(folder) == content(tmp_path / "whole")


def test_chunks_of_a_worker_that_is_lost_are_computed_by_another(cluster, tmp_path):
    folder = tmp_path / "w"
    process = begin(folder, cluster)
    workers = [child for child in cluster[0].children(recursive=True) if "spawn_main" in " ".join(child.cmdline())]
    os.kill(workers[0].pid, signal.SIGKILL)
    _, errors = process.communicate(timeout=120)
    assert process.returncode == 0, errors
    cdpr_here(*LINE, "--chunks", tmp_path / "whole")
    assert content(folder) == content(tmp_path / "whole")


def test_a_scheduler_that_is_killed_is_reported_and_it_continues_here(cluster, tmp_path):
    """The last of those that share the cluster."""
    folder = tmp_path / "w"
    process = begin(folder, cluster)
    for child in [*cluster[0].children(recursive=True), cluster[0]]:
        child.kill()
    _, errors = process.communicate(timeout=120)
    assert process.returncode == ExitCode.BACKEND_DIED, errors
    assert "Traceback" not in errors
    assert "stopped; continue by: cdpr workspace wrench-feasible " in errors
    cdpr_here(*LINE, "--chunks", folder, "--resume")
    assert (folder / SUMMARY).exists()


def test_peer_without_an_answer(tmp_path):
    robot = cdpr.load_robot(CAROCA)
    with pytest.raises(CdprError, match="no Dask scheduler answers there"):
        workspace_in_chunks(robot, "static", region(robot, cells=4), tmp_path / "w", scheduler="tls://127.0.0.1:9")
