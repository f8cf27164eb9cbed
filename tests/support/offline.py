"""pip without a network, for tests that build cdpr: what builds need is on PYTHONPATH, as pip's isolation has it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys

ONE_TARGET = ("--config-settings", "cmake.define.CDPR_ONE_TARGET=ON")  # in a third of the time


def has_compiler():
    return shutil.which("cc") is not None and shutil.which("c++") is not None


def pip(folder, command, *words, **more):
    """Run a command of pip in a virtual environment of its own, `builder`. cdpr itself is not in it."""
    needed = folder / "needed"
    needed.mkdir(exist_ok=True)
    for place in (path for path in sys.path if path.endswith("site-packages")):
        for entry in os.scandir(place):
            if not entry.name.endswith(".pth") and "cdpr" not in entry.name and not (needed / entry.name).exists():
                (needed / entry.name).symlink_to(entry.path)
    venv = folder / "builder"
    if not venv.exists():
        subprocess.run([sys.executable, "-m", "venv", "--without-pip", venv], check=True)  # pip is in `needed`
    offline = ["--no-deps", "--no-index", "--no-build-isolation"]
    env = {**os.environ, "PYTHONPATH": str(needed), "PIP_DISABLE_PIP_VERSION_CHECK": "1", **more}
    words = [venv / "bin" / "python", "-m", "pip", command, *offline, *words]
    return subprocess.run(words, env=env, capture_output=True, text=True, check=False)
