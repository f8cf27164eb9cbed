"""Damage in long logs, of which only the index is read when they are opened."""

from __future__ import annotations

import io
import os
import warnings
from pathlib import Path

import numpy as np
import pytest
from log_cases import make_header, make_rows, same_bits, write_log

from cdpr.base.errors import LogError
from cdpr.log import reader
from cdpr.log.blocks import BLOCK
from cdpr.log.index import read_index
from cdpr.log.mcap_file import LogFormat
from cdpr.log.reader import load_run, scan
from cdpr.log.repair import repair
from cdpr.log.rows import LogRows
from cdpr.log.walk import Walk

FLIPS = int(os.environ.get("CDPR_FLIPS", "30"))
HEADER = make_header(2)
ROWS = make_rows(HEADER, 3 * BLOCK + 44)


@pytest.fixture(autouse=True)
def long(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every log counts as long."""
    monkeypatch.setattr(reader, "IN_MEMORY", 0)


@pytest.fixture
def log(tmp_path: Path) -> Path:
    return write_log(tmp_path / "log.mcap", HEADER, ROWS)


def read(log: Path) -> str:
    """Read all that can be read; what is read is the truth."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            rows = load_run(log).rows
            found = [rows[k : k + 100] for k in range(0, len(rows), 100)]
        except LogError as error:
            return str(error)
    assert same_bits(np.concatenate([ROWS[:0], *found]), ROWS[: len(rows)])
    assert len(rows) == len(ROWS) or told
    return str(told[0].message) if told else ""


def test_a_sound_long_log_is_opened_by_its_index_alone(log: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(Walk, "run", lambda self: pytest.fail("its chunks are read"))
        rows = load_run(log).rows
    assert isinstance(rows, LogRows)
    assert same_bits(rows[:], ROWS)
    assert not read(log)


def test_no_flipped_bit_gives_a_wrong_row(log: Path) -> None:
    whole, form = log.read_bytes(), LogFormat(HEADER)
    rng = np.random.default_rng(0)
    ending = len(whole) - scan(log).end
    places = [
        *rng.integers(0, len(whole), FLIPS),
        *rng.integers(0, len(form.description), FLIPS // 3),
        *rng.integers(len(whole) - ending, len(whole), FLIPS // 3),
    ]
    for place in places:
        data = bytearray(whole)
        data[place] ^= 1 << int(rng.integers(8))
        log.write_bytes(data)
        if place < len(form.description) or place >= len(whole) - ending:
            assert read(log), place
        else:
            read(log)


def test_a_cut_long_log_keeps_the_rows_before(log: Path) -> None:
    whole = log.read_bytes()
    for cut in np.random.default_rng(1).integers(0, len(whole), 12):
        log.write_bytes(whole[:cut])
        assert read(log)


def test_damaged_rows_are_reported_and_repair_keeps_earlier_rows(log: Path) -> None:
    second = [chunk for chunk in scan(log).chunks if chunk.group == 0][1]
    data = bytearray(log.read_bytes())
    data[second.start + 1000] ^= 1
    log.write_bytes(data)
    run = load_run(log)
    assert same_bits(run.rows[:BLOCK], ROWS[:BLOCK])
    with pytest.raises(LogError, match=r"log\.mcap: rows 256 to 511 are damaged.* at byte \d+; `cdpr repair`"):
        run.rows[300]
    assert repair(log).rows == BLOCK
    assert same_bits(load_run(log).rows[:], ROWS[:BLOCK])


def test_a_block_of_other_samples_is_not_accepted() -> None:
    form = LogFormat(HEADER)
    raw = form.block(ROWS[:BLOCK], 0)
    records = form.records(bytes(raw[: form.templates[0].chunk_length(BLOCK)]), tail=True)
    rows = np.empty_like(ROWS[:BLOCK])
    form.read_rows(records, 0, rows)
    assert same_bits(rows, ROWS[:BLOCK])
    with pytest.raises(ValueError, match="damaged"):
        form.read_rows(records, BLOCK, rows)
    with pytest.raises(ValueError, match="damaged"):
        form.read_rows(records, 0, rows[:-1])


def test_a_footer_that_points_to_another_place_does_not_read_the_whole_log(log: Path) -> None:
    class Counted(io.FileIO):
        read_bytes = 0

        def read(self, size: int | None = -1, /) -> bytes:
            data = super().read(size)
            self.read_bytes += len(data)
            return data

    form = scan(log).form
    content = log.read_bytes()
    start = len(content) - 37 + 9  # of the summary's place, in the footer
    for place in (
        len(form.description) + 1,
        len(content) // 2,
        int.from_bytes(content[start : start + 8], "little") - 1,
    ):
        log.write_bytes(content[:start] + place.to_bytes(8, "little") + content[start + 8 :])
        with Counted(log) as file:
            assert read_index(file, form) is None
            assert file.read_bytes < 1024 + len(form.ending_start)
    log.write_bytes(content)
    with Counted(log) as file:
        assert read_index(file, form) is not None
