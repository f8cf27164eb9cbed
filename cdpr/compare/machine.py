"""The kind of machine: on one kind, with the same versions, the same run gives the same bits."""

from __future__ import annotations

import platform


def machine() -> dict[str, str]:
    """Return system, architecture and processor type; the compiled kernels are made for the latter."""
    from llvmlite import binding

    return {
        "system": platform.system(),
        "architecture": platform.machine(),
        "libc": "-".join(platform.libc_ver()),
        "processor": binding.get_host_cpu_name(),
    }
