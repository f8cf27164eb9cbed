"""A Dask cluster on this machine, as tests start it."""

from __future__ import annotations

import subprocess
import sys

from study_cases import environment

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


def cluster_in(folder):
    """Yield the process of a cluster of two workers, and its address."""
    import psutil  # comes with distributed

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
    yield psutil.Process(process.pid), process.stdout.readline().strip()
    process.communicate(timeout=60)
