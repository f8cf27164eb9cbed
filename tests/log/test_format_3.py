"""Logs of format 3, which were not compressed: read and repaired in their own format.

format_3.mcap.gz is one, as the last version that wrote them wrote it: 300 rows, so that its last block is not full. Its
numbers are short binary fractions and no platform turns, so that its pictures are the same on any machine.
"""

from __future__ import annotations

import gzip
from pathlib import Path

import pytest
from log_cases import make_header, plain_rows, same_bits
from mcap.reader import make_reader

from cdpr.log import reader
from cdpr.log.mcap_file import LogFormat
from cdpr.log.reader import load_run, scan
from cdpr.log.repair import repair

OLD = gzip.decompress((Path(__file__).parent / "format_3.mcap.gz").read_bytes())
HEADER = make_header(2, versions={}, control_step=0.01, path=((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)))
ROWS = 300


@pytest.fixture
def old(tmp_path: Path) -> Path:
    path = tmp_path / "old.mcap"
    path.write_bytes(OLD)
    return path


@pytest.mark.parametrize("memory", [0, 2**25])
def test_the_rows_are_read_to_the_bit(old: Path, memory: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reader, "IN_MEMORY", memory)
    run = load_run(old)  # without a warning
    assert (run.header, run.status) == (HEADER, "finished")
    assert same_bits(run.rows[:], plain_rows(HEADER, ROWS))
    with old.open("rb") as file:
        assert len(list(make_reader(file, validate_crcs=True).iter_messages(["/cdpr/energy"]))) == ROWS


def test_a_torn_one_is_mended_in_its_own_format(old: Path) -> None:
    kept = []
    for size in range(len(LogFormat(HEADER, version="3").description), len(OLD), 60_013):
        old.write_bytes(OLD[:size])
        kept.append(repair(old).rows)
        found = scan(old)
        assert found.problem is None
        assert same_bits(found.rows, plain_rows(HEADER, ROWS)[: kept[-1]])
        assert (old.read_bytes() == OLD) == (kept[-1] == ROWS)
    assert set(kept) == {0, 256, ROWS}
