"""Compression of MCAP chunks by zstd, with parameters suited to the messages of a run.

Successive rows differ in the low bytes of their numbers and repeat everything else, so a small hash table finds nearly
all repetitions: 545 bytes per row of eight moving cables against 493 at zstd's level 1, in half the time. The
parameters are explicit, so that new defaults of the library do not change the bytes of a log.
"""

from __future__ import annotations

import struct

import zstandard

from cdpr.log.chunk import CHUNK_HEAD

# CHUNK_HEAD with the compression's name.
ZSTD_HEAD = struct.Struct("<BQQQQII4sQ")
NAME = b"zstd"
_PARAMETERS = zstandard.ZstdCompressionParameters(
    strategy=zstandard.STRATEGY_FAST,
    window_log=19,  # 512 KiB: a block of eight cables
    hash_log=11,
    chain_log=6,
    search_log=1,
    min_match=7,
    target_length=3,
    threads=0,
)


class Compressor:
    """Compressor of chunks, for one thread at a time."""

    def __init__(self) -> None:
        self._zstd = zstandard.ZstdCompressor(compression_params=_PARAMETERS)

    def compress(self, raw: memoryview) -> tuple[list[bytes | memoryview], int]:
        """Return a compressed chunk and the message indexes after it, in parts, and the size of its compressed records.

        Args:
            raw: the uncompressed chunk, followed by its message indexes.
        """
        stop = 9 + int.from_bytes(raw[1:9], "little")
        records = self._zstd.compress(raw[CHUNK_HEAD.size : stop])
        return [compressed_head(raw, len(records)), records, raw[stop:]], len(records)


def compressed_head(raw: bytes | memoryview, size: int) -> bytes:
    """Return the head of a chunk with `size` bytes of compressed records; `raw` is the uncompressed chunk."""
    opcode, _, start, end, length, crc, _, _ = CHUNK_HEAD.unpack_from(raw)
    return ZSTD_HEAD.pack(opcode, ZSTD_HEAD.size - 9 + size, start, end, length, crc, len(NAME), NAME, size)


def decompress(records: bytes | memoryview, size: int) -> bytes:
    """Return the decompressed `size` bytes.

    Raises:
        ValueError: if `records` are damaged.
    """
    try:
        if zstandard.frame_content_size(records) == size:  # checked first, so that no wrong size is allocated
            return zstandard.decompress(records, size)
    except (zstandard.ZstdError, MemoryError) as error:
        raise ValueError("damaged") from error
    raise ValueError("damaged")


def largest(size: int) -> int:
    """Return an upper bound of the size of a chunk with `size` bytes of incompressible records."""
    return ZSTD_HEAD.size + size + size // 256 + 64
