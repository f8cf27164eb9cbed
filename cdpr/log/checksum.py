"""CRC-32 as in zlib; with isal by processor instructions, twenty times as fast."""

try:
    from isal.isal_zlib import crc32
except ImportError:  # no wheel for this machine
    from zlib import crc32

__all__ = ["crc32"]
