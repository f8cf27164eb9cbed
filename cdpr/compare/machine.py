"""The kind of machine: on one kind, with the same versions, the same run gives the same bits."""

from __future__ import annotations

import platform

from cdpr.native.operations import targets


def machine() -> dict[str, str]:
    """Return system, architecture, C library, and the largest instruction set that the processor can run."""
    return {
        "system": platform.system(),
        "architecture": platform.machine(),
        "libc": "-".join(platform.libc_ver()),
        "processor": targets()[-1],
    }
