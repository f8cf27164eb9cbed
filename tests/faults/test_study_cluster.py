"""A study on a Dask cluster on this machine: the same table, to the byte, and the same care for what goes wrong."""

from __future__ import annotations

import os
import signal
import subprocess
from importlib.util import find_spec

import numpy as np
import pytest
from clusters import cluster_in
from command_line import cdpr_here
from conftest import ROOT
from study_cases import command, environment, faulty_study, tables, wait_until, write_study

import cdpr
from cdpr.base.errors import ExitCode

# Searched, not imported, because an import takes seconds, and each of pytest's processes collects this file.
pytestmark = [
    pytest.mark.skipif(find_spec("distributed") is None, reason="distributed is not installed"),
    pytest.mark.usefixtures("faulty_plugin"),
]

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


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    yield from cluster_in(tmp_path_factory.mktemp("cluster"))


@pytest.fixture
def scheduler(cluster):
    return cluster[1]


def at_work(cluster):
    """The worker processes in which cases run, or ran."""
    servers = [child for child in cluster[0].children(recursive=True) if serves(child)]
    return [child for child in servers if serves(child.parent())]  # a fork is called as that from which it forked


def serves(process):
    return "cdpr.analysis.jobs.worker" in process.cmdline()


def begin(study, out, cluster, files):
    """Start a study on the cluster and wait for these files."""
    process = subprocess.Popen(
        command(study, out, "--scheduler", cluster[1]), cwd=ROOT, env=environment(), stderr=subprocess.PIPE, text=True
    )
    wait_until(lambda: all(file.exists() for file in files))
    return process


def run(study, out, *options):
    return cdpr_here("study", study, "--out", out, "--no-report", *options, code=None)


@pytest.mark.slow
def test_the_tables_are_the_same(scheduler, tmp_path):
    study = write_study(tmp_path, KINDS)
    here, there = run(study, tmp_path / "here"), run(study, tmp_path / "there", "--scheduler", scheduler)
    assert here.returncode == there.returncode == 0, there.stderr
    assert tables(tmp_path / "there") == tables(tmp_path / "here")


@pytest.mark.slow
def test_a_rollout_on_the_cluster_is_the_same_to_the_bit(scheduler):
    vary = {"controller.kp": {"uniform": [90.0, 110.0]}, "robot.platform.mass": [25.0] * 19 + [-1.0]}
    given = {"vary": vary, "overrides": {"simulation.duration": 0.1}}
    here, there = (
        cdpr.rollout(ROOT / "scenarios" / "caroca.yaml", 20, **given, **where)
        for where in ({}, {"scheduler": scheduler})
    )
    assert there.counts == {"finished": 19, "failed": 1}
    assert np.array_equal(here.rows, there.rows, equal_nan=True)
    assert here.outcomes == there.outcomes


@pytest.mark.slow
def test_faults_are_reported(scheduler, tmp_path):
    study = write_study(tmp_path, FAULTS)
    study.write_text(study.read_text().replace("changes: {", "changes: {controller.type: faulty, "))
    done = run(study, tmp_path / "out", "--scheduler", scheduler, "--timeout", "2")
    assert done.returncode == ExitCode.BACKEND_DIED
    assert "4 cases: 1 finished, 1 died, 1 failed, 1 hung" in done.stdout
    assert "ended by SIGKILL" in done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_a_stopped_study_leaves_nothing_at_work_and_continues(cluster, tmp_path, number):
    study = faulty_study(tmp_path, ["hang", "hang", "none"], 0.1, keep="all")
    out = tmp_path / "out"
    process = begin(study, out, cluster, [tmp_path / "faults" / name for name in "01"])
    hanging = at_work(cluster)
    assert len(hanging) == 2
    process.send_signal(number)
    _, errors = process.communicate(timeout=60)
    if number == signal.SIGINT:
        assert process.returncode == ExitCode.INTERRUPTED
        assert f"interrupted; continue by: cdpr study {study} " in errors
        assert f" --out {out}\n" in errors
    wait_until(lambda: not any(child.is_running() for child in hanging), 20)
    assert run(study, out, "--scheduler", cluster[1]).returncode == 0
    assert [cdpr.load_run(folder).status for folder in (out / "runs").iterdir()] == ["finished"] * 3


@pytest.mark.slow
def test_a_case_whose_machine_is_lost_runs_anew(cluster, tmp_path):
    """Also in a folder that it has begun to fill."""
    study = faulty_study(tmp_path, ["hang"], 0.1, keep="all")
    out = tmp_path / "out"
    process = begin(study, out, cluster, [tmp_path / "faults" / "0"])
    (folder,) = (out / "runs").iterdir()
    (case,) = (child for child in at_work(cluster) if any(str(folder) in file.path for file in child.open_files()))
    os.kill(case.parent().ppid(), signal.SIGKILL)  # a worker of the cluster's
    process.communicate(timeout=120)
    assert process.returncode == 0
    assert cdpr.load_run(folder).status == "finished"


@pytest.mark.slow
def test_a_scheduler_that_is_killed_is_reported_and_the_study_continues_elsewhere(cluster, tmp_path):
    """The last of those that share the cluster."""
    study = faulty_study(tmp_path, ["none", "hang", "hang"], 0.1)
    out = tmp_path / "out"
    process = begin(study, out, cluster, [tmp_path / "faults" / name for name in "12"])
    wait_until(lambda: (out / "cases.jsonl").stat().st_size)  # one case has ended
    cluster[0].kill()
    _, errors = process.communicate(timeout=60)
    assert process.returncode == ExitCode.BACKEND_DIED
    assert "; finished cases are kept" in errors
    assert f"continue by: cdpr study {study} " in errors
    assert f" --out {out}\n" in errors
    assert "Traceback" not in errors
    done = run(study, out)
    assert done.returncode == 0
    assert "3 cases: 3 finished" in done.stdout


def test_the_cluster_knows_how_many_at_a_time(tmp_path):
    done = run(write_study(tmp_path, KINDS), tmp_path / "out", "--scheduler", "tcp://127.0.0.1:9", "--jobs", "2")
    assert done.returncode == ExitCode.BAD_INPUT
    assert "--jobs does not go with --scheduler" in done.stderr


@pytest.mark.slow  # Dask tries for twenty seconds
def test_peer_without_an_answer(tmp_path):
    done = run(write_study(tmp_path, KINDS), tmp_path / "out", "--scheduler", "tcp://127.0.0.1:9")
    assert done.returncode == ExitCode.BAD_INPUT
    assert "no Dask scheduler answers there" in done.stderr


@pytest.mark.parametrize("address", ["tls://127.0.0.1:9", "nonsense://x", "tcp://"])
def test_an_address_that_cannot_be_used_is_reported(tmp_path, address):
    """Among them TLS without certificates."""
    done = run(write_study(tmp_path, KINDS), tmp_path / "out", "--scheduler", address)
    assert done.returncode == ExitCode.BAD_INPUT, done.stderr
    assert f"--scheduler {address}: no Dask scheduler answers there" in done.stderr
