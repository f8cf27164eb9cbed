"""Repairs beside runs and other repairs, and repairs that are killed."""

from __future__ import annotations

import contextlib
import json
import os
import threading
from pathlib import Path
from typing import Any

import pytest
from log_cases import make_header, make_rows, write_log

from cdpr.base.errors import LogError, OutputError
from cdpr.log import repair as repair_module
from cdpr.log import run_folder as run_folder_module
from cdpr.log.blocks import BLOCK
from cdpr.log.reader import scan
from cdpr.log.repair import repair
from cdpr.log.run import Run
from cdpr.log.run_folder import RunFolder, claim

HEADER = make_header(2)
ROWS = make_rows(HEADER, 2 * BLOCK + 44)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    return write_log(tmp_path_factory.mktemp("whole") / "log.mcap", HEADER, ROWS).read_bytes()


def test_a_run_that_begins_while_a_repair_looks_is_not_called_interrupted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Worst case: the folder exists, its lock does not yet, and a repair finds no active process."""
    looking, look, began = threading.Event(), threading.Event(), repair_module._never_began

    def slowly(folder: Path) -> bool:
        looking.set()
        assert look.wait(10)
        return began(folder)

    def look_into() -> None:
        with contextlib.suppress(LogError, OutputError):
            repair(tmp_path / "run")

    repairing = threading.Thread(target=look_into)

    def claimed(folder: Path, first: str) -> None:
        claim(folder, first)
        repairing.start()
        assert looking.wait(10)
        threading.Timer(0.05, look.set).start()

    monkeypatch.setattr(repair_module, "_never_began", slowly)
    monkeypatch.setattr(run_folder_module, "claim", claimed)
    folder = RunFolder(tmp_path / "run", HEADER)
    repairing.join()
    assert json.loads((folder.path / "run.json").read_text())["status"] == "running"
    with pytest.raises(OutputError, match="is still going on"):
        repair(folder.path)
    folder.finish(Run(HEADER, ROWS))
    assert json.loads((folder.path / "run.json").read_text())["status"] == "finished"


def test_of_several_repairs_at_once_one_works(tmp_path: Path, whole: bytes) -> None:
    for k in range(20):
        folder = tmp_path / str(k)
        folder.mkdir()
        (folder / "log.mcap").write_bytes(whole[:-500])
        barrier = threading.Barrier(3)

        def mend(folder: Path = folder, barrier: threading.Barrier = barrier) -> None:
            barrier.wait()
            with contextlib.suppress(OutputError):
                repair(folder)

        threads = [threading.Thread(target=mend) for _ in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert (folder / "log.mcap").read_bytes() == whole
        assert sorted(os.listdir(folder)) == ["log.mcap", "log.mcap.torn"]


def test_a_repair_that_is_killed_loses_nothing(tmp_path: Path, whole: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    """Overwritten data is on the disk before."""
    log = tmp_path / "log.mcap"
    log.write_bytes(whole[:-500])
    end = scan(log).end
    opened = Path.open

    class Killed:
        def __init__(self, file: Any) -> None:
            self._file = file

        def __enter__(self) -> Killed:
            return self

        def __exit__(self, *_: object) -> None:
            self._file.close()

        def __getattr__(self, name: str) -> Any:
            return getattr(self._file, name)

        def truncate(self) -> None:
            raise KeyboardInterrupt

    def opens(self: Path, mode: str = "r", *args: Any, **kwargs: Any) -> Any:
        file = opened(self, mode, *args, **kwargs)
        return Killed(file) if mode == "r+b" else file

    with monkeypatch.context() as patch:
        patch.setattr(Path, "open", opens)
        with pytest.raises(KeyboardInterrupt):
            repair(tmp_path)
    assert (tmp_path / "log.mcap.torn").read_bytes().endswith(whole[end:-500])
    repair(tmp_path)
    assert log.read_bytes() == whole
