"""The checksum of chunks: by isal where it is installed, by zlib elsewhere, the same bytes."""

from __future__ import annotations

import runpy
import sys
import zlib
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from log_cases import make_header, make_rows, write_log

from cdpr.log import checksum, chunk, mcap_file, reader
from cdpr.log.blocks import BLOCK

pytestmark = pytest.mark.core

USERS = (chunk, mcap_file, reader)


def chosen() -> Callable[[bytes], int]:
    """Checksum computed by a new process."""
    return runpy.run_path(str(checksum.__file__))["crc32"]


def test_without_isal_it_is_zlib(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "isal", None)
    monkeypatch.setitem(sys.modules, "isal.isal_zlib", None)
    assert chosen() is zlib.crc32


def test_with_isal_it_is_isal(monkeypatch: pytest.MonkeyPatch) -> None:
    stand_in = SimpleNamespace(crc32=lambda data: 7)
    monkeypatch.setitem(sys.modules, "isal", SimpleNamespace(isal_zlib=stand_in))
    monkeypatch.setitem(sys.modules, "isal.isal_zlib", stand_in)
    assert chosen() is stand_in.crc32


@pytest.mark.parametrize("size", [0, 1, 15, 16, 17, 63, 64, 65, 255, 256, 1000, 65_537])
@pytest.mark.parametrize("offset", [0, 1, 7])
def test_both_agree_on_any_size_and_place(size: int, offset: int) -> None:
    isal = pytest.importorskip("isal.isal_zlib")
    data = np.random.default_rng(size).bytes(size + offset)
    assert isal.crc32(memoryview(data)[offset:]) == zlib.crc32(data[offset:])


@pytest.mark.parametrize("writer", ["isal.isal_zlib", "zlib"])
@pytest.mark.parametrize("loader", ["isal.isal_zlib", "zlib"])
def test_a_log_is_the_same_and_is_read_by_either(
    writer: str, loader: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    header = make_header(2)
    table = make_rows(header, BLOCK + 9)
    expected = write_log(tmp_path / "expected.mcap", header, table).read_bytes()
    for library, use in ((writer, "write"), (loader, "load")):
        for module in USERS:
            monkeypatch.setattr(module, "crc32", pytest.importorskip(library).crc32)
        if use == "write":
            log = write_log(tmp_path / "log.mcap", header, table)
            assert log.read_bytes() == expected
        else:
            assert reader.scan(log).problem is None
