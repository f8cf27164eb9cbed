"""CRC-32, as zlib computes it: by instructions of the processor where isal is installed, twenty times as fast."""

try:
    from isal.isal_zlib import crc32
except ImportError:  # no wheel for this machine
    from zlib import crc32

__all__ = ["crc32"]
