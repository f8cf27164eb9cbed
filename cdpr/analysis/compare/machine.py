"""Kind of machine: the same kind with the same versions reproduces a run to the bit."""

from __future__ import annotations

import platform

from cdpr.native.operations import targets


def machine() -> dict[str, str]:
    """Return the system, architecture, C library and largest instruction set that the processor supports."""
    return {
        "system": platform.system(),
        "architecture": platform.machine(),
        "libc": "-".join(platform.libc_ver()),
        "processor": targets()[-1],
    }
