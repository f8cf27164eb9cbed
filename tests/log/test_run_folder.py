"""Folder of a run and contents of run.json."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from datetime import datetime
from pathlib import Path

import pytest
from log_cases import make_header, make_rows, same_bits, write_log

from cdpr.base.checksums import sealed
from cdpr.base.errors import LogError, OutputError
from cdpr.log.event import Event
from cdpr.log.reader import load_run
from cdpr.log.run import Run
from cdpr.log.run_folder import RunFolder

HEADER = make_header(2)


def test_the_default_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    header = make_header(2, scenario="../lift & turn ä", backend="mujoco")
    folder = RunFolder(None, header)
    assert re.fullmatch(r"runs/\d{8}-\d{6}_lift-turn-ä_mujoco", str(folder.path))
    assert (folder.path / "scenario.yaml").read_text(encoding="utf-8") == header.scenario_yaml


def test_default_names_never_meet(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    now = datetime(2026, 1, 2, 3, 4, 5)
    monkeypatch.setattr("cdpr.log.run_json.now", lambda: now)
    names = [RunFolder(None, HEADER).path.name for _ in range(3)]
    first = "20260102-030405_test_reference"
    assert names == [first, f"{first}-2", f"{first}-3"]


def test_a_folder_in_use_is_refused(tmp_path: Path) -> None:
    out = tmp_path / "a" / "b"
    RunFolder(out, HEADER)
    before = (out / "run.json").read_bytes()
    with pytest.raises(OutputError, match="exists and is not empty; choose another folder or remove it"):
        RunFolder(out, HEADER)
    assert (out / "run.json").read_bytes() == before
    (tmp_path / "empty").mkdir()
    assert RunFolder(tmp_path / "empty", HEADER).path == tmp_path / "empty"


def test_run_json_from_start_to_end(tmp_path: Path) -> None:
    folder = RunFolder(tmp_path / "run", HEADER, ["cdpr", "run", "a.yaml"])
    content = json.loads((folder.path / "run.json").read_text(encoding="utf-8"))
    assert (content["status"], content["finished"]) == ("running", None)
    assert content["header"]["cables"] == ["Seil α", "cable_2"]
    assert "scenario_yaml" not in content["header"]
    rows = make_rows(HEADER, 40)
    run = Run(
        header=HEADER,
        rows=rows,
        status="infeasible",
        message="no tensions at 0.02 s",
        events=(Event(0.02, "infeasible", "cable 1 slack", 0.03), Event(0.03, "stopped", "policy stop")),
        timings={"loop_s": 0.5},
        unused=("trajectory.blend",),
        folder=str(folder.path),
    )
    folder.finish(run)
    content = json.loads((folder.path / "run.json").read_text(encoding="utf-8"))
    assert content["argv"] == ["cdpr", "run", "a.yaml"]
    for key in ("started", "finished"):
        assert datetime.fromisoformat(content[key]).utcoffset() is not None
    assert content["summary"] == run.summary()
    write_log(folder.path / "log.mcap", HEADER, rows)
    again = load_run(folder.path)
    assert same_bits(again.rows, rows)
    for name in ("header", "status", "message", "events", "timings", "unused", "folder"):
        assert getattr(again, name) == getattr(run, name)
    assert sorted(path.name for path in folder.path.iterdir()) == ["log.mcap", "run.json", "scenario.yaml"]


def test_the_log_alone_is_enough(tmp_path: Path) -> None:
    rows = make_rows(HEADER, 10)
    run = load_run(str(write_log(tmp_path / "somewhere.mcap", HEADER, rows)))
    assert same_bits(run.rows, rows)
    assert (run.header, run.status, run.folder) == (HEADER, "finished", None)


def test_opening_a_run_imports_nothing_slow(tmp_path: Path) -> None:
    """Imports are most of the time that it takes."""
    folder, rows = RunFolder(tmp_path / "run", HEADER), make_rows(HEADER, 10)
    write_log(folder.path / "log.mcap", HEADER, rows)
    folder.finish(Run(HEADER, rows))
    slow = ("pydantic", "pydantic_core", "scipy", "matplotlib", "logging", "rich", "cdpr.cables", "cdpr.scenario")
    code = f"import sys, cdpr; cdpr.load_run({str(folder.path)!r}); print([*{set(slow)!r} & set(sys.modules)])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


@pytest.mark.parametrize(
    ("key", "value", "told"),
    [
        ("status", 1, "status: expected str, got int"),
        ("status", None, "status: expected str, got NoneType"),
        ("summary", [], "summary: expected dict, got list"),
        ("events", {}, "events: expected tuple, got dict"),
        ("events", [{"time": "1", "kind": "", "text": ""}], "events.0.time: expected float, got str"),
        ("events", [{"time": 10**400, "kind": "", "text": ""}], "events.0.time: expected float, got int"),
        ("events", [{"time": 0, "kind": "", "text": "", "until": []}], "events.0.until: expected float | None"),
        ("events", [{"time": 0.0, "kind": ""}], "events.0.text: it is missing"),
        ("events", [[]], "events.0: expected Event, got list"),
        ("timings", {"setup_s": "1"}, "timings.setup_s: expected float | None, got str"),
        ("unused", [1], "unused.0: expected str, got int"),
        ("log", {"scenario": "", "rows": 1.5, "last_row": None}, "log.rows: expected int, got float"),
        ("log", None, "log: expected LogOf, got NoneType"),
    ],
)
def test_run_json_is_validated(tmp_path: Path, key: str, value: object, told: str) -> None:
    folder, rows = RunFolder(tmp_path / "run", HEADER), make_rows(HEADER, 10)
    write_log(folder.path / "log.mcap", HEADER, rows)
    folder.finish(Run(HEADER, rows))
    path = folder.path / "run.json"
    content = json.loads(path.read_text())
    path.write_text(json.dumps(sealed({**content, "loop": None, "timings": {"setup_s": None, "loop_s": 2}})))
    assert load_run(folder.path).status == "finished"
    path.write_text(json.dumps(sealed({**content, key: value})))
    with pytest.raises(LogError, match=rf"run\.json: cannot be read: {re.escape(told)}.*the log still loads"):
        load_run(folder.path)
