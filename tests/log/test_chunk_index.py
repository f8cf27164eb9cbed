"""ChunkIndex records: as the mcap package writes them, and read back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from mcap import records
from mcap.data_stream import RecordBuilder

import cdpr
from cdpr.log.chunk_index import Written, chunk_indexes
from cdpr.log.header import Header
from cdpr.log.index import read_index
from cdpr.log.mcap_file import LogFormat
from cdpr.log.reader import load_run


@pytest.fixture(scope="module")
def header(tmp_path_factory: pytest.TempPathFactory) -> Header:
    folder = tmp_path_factory.mktemp("run") / "run"
    cdpr.simulate("planar", overrides={"simulation.duration": 0.01}, out=folder)
    return load_run(folder).header


def random_chunks(form: LogFormat, seed: int) -> list[Written]:
    """Return chunks of random groups, lengths and sizes, one behind the other, as in a long log."""
    rng = np.random.default_rng(seed)
    counts, start, chunks = [0] * len(form.templates), len(form.description), []
    for _ in range(50):
        group, n = int(rng.integers(len(counts))), int(rng.integers(1, 5000))
        first = counts[group] * form.templates[group].group.every
        chunks.append(Written(group, first, n, start, int(rng.integers(1, 2**33))))
        counts[group] += n
        start += form.length(chunks[-1])
    return chunks


def by_mcap(form: LogFormat, chunk: Written, compression: str) -> bytes:
    group = form.templates[chunk.group].group
    length, index_length = form.head_length() + chunk.size, 15 + 16 * chunk.n
    last = chunk.first + (chunk.n - 1) * group.every
    builder = RecordBuilder()
    records.ChunkIndex(
        chunk_length=length,
        chunk_start_offset=chunk.start,
        compression=compression,
        compressed_size=chunk.size,
        message_end_time=round(last * form.step * 1e9),
        message_index_length=len(group.topics) * index_length,
        message_index_offsets={
            group.channel + i: chunk.start + length + i * index_length for i in range(len(group.topics))
        },
        message_start_time=round(chunk.first * form.step * 1e9),
        uncompressed_size=chunk.n * form.templates[chunk.group].row.size,
    ).write(builder)
    return bytes(builder.end())


@pytest.mark.parametrize(("version", "compression"), [("3", ""), ("4", "zstd")])
def test_as_mcap_writes_them(header: Header, version: str, compression: str) -> None:
    form = LogFormat(header, version=version)
    chunks = random_chunks(form, seed=int(version))
    assert chunk_indexes(form.indexes, chunks) == b"".join(by_mcap(form, chunk, compression) for chunk in chunks)
    assert chunk_indexes(form.indexes, []) == b""


@pytest.mark.parametrize("version", ["3", "4"])
def test_an_ending_is_read_back(header: Header, version: str, tmp_path: Path) -> None:
    form = LogFormat(header, version=version)
    chunks = random_chunks(form, seed=1)
    end = chunks[-1].start + form.length(chunks[-1])
    last = max(c.first + (c.n - 1) * form.every for c in chunks if c.group == 0)
    path = tmp_path / "log.mcap"
    with path.open("w+b") as file:
        file.seek(end)  # a hole replaces the chunks: only the end is read
        file.write(form.ending(chunks, last, end))
        index = read_index(file, form)
        assert index is not None
        assert list(index.chunks) == chunks
        assert index.end == end
        assert index.rows == sum(chunk.n for chunk in chunks if chunk.group == 0)
