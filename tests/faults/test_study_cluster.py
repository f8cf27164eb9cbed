"""A study on a Dask cluster on this machine: the same table, to the byte, and the same care for what goes wrong."""

from __future__ import annotations

import subprocess
import sys

import pytest
from conftest import ROOT
from study_cases import command, environment, tables, write_study

from cdpr.errors import ExitCode

pytest.importorskip("distributed")

KINDS = """
axes:
  - key: controller.kd
    values: [20, 30, 40]
  - name: kind
    points:
      sound: {}
      stiff: {controller.kp: 1.0e+6, simulation.control_step: 0.01, robot.tension.max: 1.0e+11}
"""
FAULTS = """
axes:
  - {key: controller.fault, values: [none, kill, raise, hang]}
"""

# Two worker processes of one thread each, as `dask worker` starts them, until its standard input ends.
CLUSTER = """
import sys
from distributed import LocalCluster
if __name__ == "__main__":
    cluster = LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, host="127.0.0.1")
    with cluster:
        print(cluster.scheduler_address, flush=True)
        sys.stdin.read()
"""


@pytest.fixture(scope="module")
def scheduler(tmp_path_factory):
    """The address of a cluster of two workers."""
    folder = tmp_path_factory.mktemp("cluster")
    (folder / "cluster.py").write_text(CLUSTER)
    process = subprocess.Popen(
        [sys.executable, folder / "cluster.py"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        cwd=folder,
        env=environment(),
    )
    yield process.stdout.readline().strip()
    process.communicate(timeout=60)


def run(study, out, *options):
    done = subprocess.run(
        command(study, out, *options), cwd=ROOT, env=environment(), capture_output=True, text=True, timeout=300
    )
    assert "Traceback" not in done.stderr, done.stderr
    return done


def test_the_tables_are_the_same(scheduler, tmp_path):
    study = write_study(tmp_path, KINDS)
    here, there = run(study, tmp_path / "here"), run(study, tmp_path / "there", "--scheduler", scheduler)
    assert here.returncode == there.returncode == 0, there.stderr
    assert tables(tmp_path / "there") == tables(tmp_path / "here")


def test_faults_are_told(scheduler, tmp_path):
    study = write_study(tmp_path, FAULTS)
    study.write_text(study.read_text().replace("changes: {", "changes: {controller.type: faulty, "))
    done = run(study, tmp_path / "out", "--scheduler", scheduler, "--timeout", "2")
    assert done.returncode == ExitCode.BACKEND_DIED
    assert "4 cases: 1 finished, 1 died, 1 failed, 1 hung" in done.stdout
    assert "ended by SIGKILL" in done.stdout


def test_nobody_answers(tmp_path):
    done = run(write_study(tmp_path, KINDS), tmp_path / "out", "--scheduler", "tcp://127.0.0.1:9")
    assert done.returncode == ExitCode.BAD_INPUT
    assert "no Dask scheduler answers there" in done.stderr
