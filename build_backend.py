"""Build backend: scikit-build-core's, with a C++ compiler from PyPI where the system has none.

- Without a C and a C++ compiler, builds require ziglang, and only then. Its cache stays in the build folder.
- CDPR_BUILD_ZIG=1 chooses ziglang in any case, for wheels that run on older Linux systems (manylinux_2_17).
- An editable install is a line with the checkout's path in site-packages: no hook of imports. The kernel library is in
  the checkout; only an install compiles it.
"""

from __future__ import annotations

import importlib.util
import os
import platform
import shutil
import sys
import sysconfig
from pathlib import Path
from typing import Any

from scikit_build_core import build as backend
from scikit_build_core.build import *  # noqa: F403

ROOT = Path(__file__).parent
Settings = dict[str, Any]


def get_requires_for_build_wheel(config_settings: Settings | None = None) -> list[str]:
    """Return what a wheel is built with."""
    return [*backend.get_requires_for_build_wheel(config_settings), *compiler_requirements()]


def get_requires_for_build_editable(config_settings: Settings | None = None) -> list[str]:
    """Return what an editable install is built with."""
    return [*backend.get_requires_for_build_editable(config_settings), *compiler_requirements()]


def build_wheel(
    wheel_directory: str, config_settings: Settings | None = None, metadata_directory: str | None = None
) -> str:
    """Build a wheel; return its name."""
    settings = compiler_settings("wheel") | (config_settings or {})
    return backend.build_wheel(wheel_directory, settings, metadata_directory)


def build_editable(
    wheel_directory: str, config_settings: Settings | None = None, metadata_directory: str | None = None
) -> str:
    """Build a wheel that only names the checkout, and put the kernel library there; return the wheel's name."""
    named = {"cmake.define.CDPR_EDITABLE": "ON", "wheel.packages": []}
    settings = compiler_settings("editable") | named | (config_settings or {})
    return backend.build_wheel(wheel_directory, settings, metadata_directory)


def system_compilers() -> bool:
    """Return whether a C and a C++ compiler are used: those of CC and CXX, or on PATH, where CMake searches."""
    if os.environ.get("CDPR_BUILD_ZIG") == "1":
        return False
    return found("CC", "cc", "gcc", "clang") and found("CXX", "c++", "g++", "clang++")


def found(variable: str, *names: str) -> bool:
    """Return whether a compiler exists: that of an environment variable, else one of some names."""
    given = os.environ.get(variable, "").split()
    return any(shutil.which(name) for name in given[:1] or names)


def compiler_requirements() -> list[str]:
    """Return ziglang where there is no compiler."""
    return [] if system_compilers() else ["ziglang>=0.13"]


def compiler_settings(state: str) -> Settings:
    """Return scikit-build-core's settings for the compiler, and set what CMake reads from the environment."""
    if sysconfig.get_config_var("Py_GIL_DISABLED"):
        sys.exit("cdpr: free-threaded Python is not supported: it has another ABI; use the usual Python.")
    settings = {"build-dir": f"build/{state}", "cmake.define.CDPR_ZIG": "OFF"}
    settings["cmake.fresh"] = "true"  # paths of tools that pip installs for one build are wrong in the next
    if system_compilers():
        return settings
    use_zig()
    return settings | {"build-dir": f"build/{state}-zig", "cmake.define.CDPR_ZIG": "ON"}


def use_zig() -> None:
    """Make CMake compile by zig, for any processor of this kind and an old C library."""
    spec = importlib.util.find_spec("ziglang")
    if spec is None or spec.origin is None:
        sys.exit("cdpr: no C and C++ compiler found; install one, set CC and CXX, or install ziglang.")
    zig = Path(spec.origin).with_name("zig")
    cache = str(ROOT / "build" / "zig-cache")
    os.environ |= {"ZIG_GLOBAL_CACHE_DIR": cache, "ZIG_LOCAL_CACHE_DIR": cache}
    target = f"-target {zig_target()}" if sys.platform == "linux" else ""
    os.environ["CC"] = f"{zig} cc {target}"
    os.environ["CXX"] = f"{zig} c++ {target}"
    # CMake links a program first. Without these options zig would build its debugging libraries and the C++ library.
    os.environ["CFLAGS"] = "-O2"
    os.environ["CXXFLAGS"] = "-O2 -nostdlib++"


def zig_target() -> str:
    """Return zig's name for Linux on this kind of processor. Without it, zig compiles for exactly this processor."""
    machine = platform.machine()
    return (
        f"{machine}-linux-musl" if "musl" in (sysconfig.get_config_var("SOABI") or "") else f"{machine}-linux-gnu.2.17"
    )
