"""Logs of format 2, which held the clock and the commands of ideal cables in every row: read and repaired as ever.

format_2.mcap.gz is one, as the last version that wrote them wrote it. Its numbers are short binary fractions and no
platform turns, so that its pictures are the same on any machine.
"""

from __future__ import annotations

import gzip
from pathlib import Path

import pytest
from log_cases import make_header, plain_rows, same_bits, write_log
from mcap.reader import make_reader

from cdpr.log import run_json
from cdpr.log.mcap_file import LogFormat
from cdpr.log.reader import load_run, scan
from cdpr.log.repair import repair
from cdpr.log.run_folder import RunFolder

OLD = gzip.decompress((Path(__file__).parent / "format_2.mcap.gz").read_bytes())
HEADER = make_header(2, versions={}, control_step=0.01, path=((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)))


@pytest.fixture
def old(tmp_path: Path) -> Path:
    path = tmp_path / "old.mcap"
    path.write_bytes(OLD)
    return path


def test_the_rows_of_an_old_log_are_read_to_the_bit(old: Path, tmp_path: Path) -> None:
    run = load_run(old)  # without a warning
    assert (run.header, run.status) == (HEADER, "finished")
    assert same_bits(run.rows, plain_rows(HEADER, 5))
    new = write_log(tmp_path / "new.mcap", HEADER, plain_rows(HEADER, 5))
    assert same_bits(load_run(new).rows, run.rows)
    counts = []
    for path in (old, new):
        with path.open("rb") as file:
            reader = make_reader(file, validate_crcs=True)
            topics = [channel.topic for _, channel, _ in reader.iter_messages()]
        counts.append(
            [topics.count(topic) for topic in ("/clock", "/cdpr/cable_commands", "/cdpr/cable_states", "/tf")]
        )
    assert counts == [[5, 5, 5, 3], [3, 0, 5, 3]]


def test_a_torn_old_log_is_mended_in_its_own_format(old: Path) -> None:
    kept = []
    for size in range(len(LogFormat(HEADER, version="2").description), len(OLD), 500):
        old.write_bytes(OLD[:size])
        kept.append(repair(old).rows)
        found = scan(old)
        assert found.problem is None
        assert same_bits(found.rows, plain_rows(HEADER, 5)[: kept[-1]])
        assert (old.read_bytes() == OLD) == (kept[-1] == 5)
    assert set(kept) == {0, 5}  # its rows are one block


def test_a_run_that_an_old_version_hardly_began_is_distinguished_from_a_damaged_one(tmp_path: Path) -> None:
    folder = RunFolder(tmp_path / "run", HEADER).path
    (folder / "log.mcap").write_bytes(LogFormat(HEADER, version="2").description[:500])
    report = repair(folder)
    assert (report.rows, report.problem, report.interrupted) == (0, None, True)
    assert (run_json.read(folder) or {})["status"] == "interrupted"
    assert not (folder / "log.mcap").exists()
