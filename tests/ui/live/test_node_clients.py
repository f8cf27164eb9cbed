"""Foxglove's own readers and client, in JavaScript: they read our logs and watch our runs without an error.

Needs node, and CDPR_NODE_MODULES: the folder node_modules after `npm install` of the packages in PACKAGES.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from functools import partial
from pathlib import Path

import live_client
import pytest
from conftest import ROOT
from live_client import FILE, RUN_TIMEOUT

import cdpr

foxglove = pytest.importorskip("cdpr.ui.live.foxglove")

PACKAGES = (
    "@foxglove/ws-protocol", "@foxglove/rosmsg", "@foxglove/rosmsg2-serialization", "@mcap/core", "@mcap/support", "ws"
)  # fmt: skip
MODULES = os.environ.get("CDPR_NODE_MODULES", "")
MISSING = [name for name in PACKAGES if not (Path(MODULES) / name).is_dir()] if MODULES else list(PACKAGES)
ROBOTS = os.environ.get("CDPR_NODE_ROBOTS", "caroca winch planar_point_mass").split()  # "all": every example

pytestmark = [
    pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed"),
    pytest.mark.skipif(bool(MISSING), reason=f"CDPR_NODE_MODULES lacks {', '.join(MISSING)}"),
]


def node(script, *words):
    command = ["node", str(ROOT / "tests" / "node" / script), MODULES, *map(str, words)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=10 * RUN_TIMEOUT)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_logs_are_read(tmp_path):
    names = [file.stem for file in sorted((ROOT / "scenarios").glob("*.yaml"))] if ROBOTS == ["all"] else ROBOTS
    logs, runs = [], []
    for name in names:
        overrides = {"simulation.duration": 0.2}
        try:
            run = cdpr.simulate(
                cdpr.load_scenario(FILE.with_name(f"{name}.yaml"), overrides=overrides), out=tmp_path / name
            )
        except cdpr.CdprError as error:
            if error.run is None:
                continue
            run = error.run
        logs.append(tmp_path / name / "log.mcap")
        runs.append(run)
    assert len(logs) > 0.8 * len(names)
    for found, run in zip(node("read_log.cjs", *logs), runs, strict=True):
        assert found["count"] == found["statistics"] > len(run.rows)
        assert [found["pose"][axis] for axis in "xyz"] == run.position[-1].tolist()
        assert found["topics"] > 5


def test_a_run_is_watched_and_steered():
    with live_client.running(partial(foxglove.Foxglove, port=0), 1.5, held=True) as (link, found, said):
        url = link.url
        process = subprocess.Popen(
            ["node", str(ROOT / "tests" / "node" / "watch_run.cjs"), MODULES, url],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
    out, err = process.communicate(timeout=RUN_TIMEOUT)
    assert (process.returncode, err) == (0, "")
    seen = json.loads(out)
    run = found["run"]
    assert said == seen["statuses"] == []
    assert seen["info"]["name"] == "cdpr"
    assert seen["answer"] == {"callId": 7, "encoding": "json", "success": True, "message": ""}
    assert seen["failure"]["callId"] == 8
    assert seen["parameters"]["controller.kp"] == 150.0
    assert seen["parameters"]["paused"] is False
    assert {"/cdpr/platform/pose", "/tf", "/clock", "/cdpr/markers", "/cdpr/desired_path"} <= set(seen["topics"])
    assert seen["messages"] > 100
    assert seen["times"] > 10
    assert [seen["pose"][axis] for axis in "xyz"] == run.position[-1].tolist()
    texts = [event.text for event in run.events]
    assert any("to [0.2, 0.1, 1.3] m" in text for text in texts)
    assert any("controller.kp becomes 150" in text for text in texts)
