"""Blocks of rows in which runs are recorded and logs written."""

from __future__ import annotations

BLOCK = 256  # rows of a complete block
BLOCK_SECONDS = 0.5  # s of wall time after which rows are written even if the block is incomplete
