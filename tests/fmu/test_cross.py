"""FMUs for other platforms, compiled by zig: folders, formats and functions, and the same motion in an emulator."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import zipfile
from pathlib import Path

import numpy as np
import pytest
from fmu.cases import plant_of, scenario
from fmu.host import arguments, compile_host

from cdpr.fmu.export import fmu_bytes
from cdpr.fmu.export.library import CROSSES, STANDARD, target, zig_program

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(zig_program() is None, reason="ziglang is not installed: pip install 'cdpr[cross]'"),
]
# The file of a binary in FMI 2 and FMI 3, and how it begins: format and processor.
FILES = {
    "win64": ("win64", "x86_64-windows", ".dll", b"MZ"),
    "linux-x86_64": ("linux64", "x86_64-linux", ".so", b"\x7fELF\x02\x01\x01" + bytes(9) + b"\x03\x00\x3e\x00"),
    "linux-aarch64": ("", "aarch64-linux", ".so", b"\x7fELF\x02\x01\x01" + bytes(9) + b"\x03\x00\xb7\x00"),
    "macos-x86_64": ("darwin64", "x86_64-darwin", ".dylib", b"\xcf\xfa\xed\xfe\x07\x00\x00\x01"),
    "macos-aarch64": ("", "aarch64-darwin", ".dylib", b"\xcf\xfa\xed\xfe\x0c\x00\x00\x01"),
}
# Plants, and whether they call functions of the C library, such as atan2, which other C libraries round otherwise.
CASES = {"caroca": False, "pulleys_mixed": True}
ROUND_OFF = 1e-12  # m, rad and their rates, after 200 steps: some thousand times the round-off of one such function
WINE = shutil.which("wine64") or shutil.which("wine") or shutil.which("wine64", path="/usr/lib/wine")
QEMU, ARM = shutil.which("qemu-aarch64"), Path("/usr/aarch64-linux-gnu")
# Command that runs a program for a platform here; None if there is none.
EMULATORS = {
    "linux-x86_64": (),
    "linux-aarch64": (QEMU, "-L", ARM) if QEMU and ARM.is_dir() else None,
    "win64": (WINE,) if WINE else None,
}


def check_wanted(platform):
    if platform not in ("linux-aarch64", "linux-x86_64") and not os.environ.get("CDPR_TEST_CROSS"):
        pytest.skip("zig first compiles the platform's C library, which takes minutes: set CDPR_TEST_CROSS=1")


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    """The user's cache, and zig's for all that it compiles, such as the C library of a platform.

    By default it does not optimise, to save time; unasked, it would then check for undefined behaviour.
    """
    folder = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        if not os.environ.get("CDPR_TEST_CROSS"):
            quick = folder / "zig"
            quick.write_text(f'#!/bin/sh\nexec {zig_program()} "$@" -O0 -fno-sanitize=undefined\n')
            quick.chmod(0o755)
            patch.setattr("cdpr.fmu.export.library.zig_program", lambda: str(quick))
        patch.setenv("XDG_CACHE_HOME", str(folder))
        for name in ("GLOBAL", "LOCAL"):
            patch.setenv(f"ZIG_{name}_CACHE_DIR", str(folder / "cdpr" / "fmu" / "zig"))
        yield folder


@pytest.fixture(scope="module")
def built(cache):
    """FMUs of a plant for a platform, compiled once: what differs between plants is not a source."""

    def fmu(platform, case, fmi):
        return fmu_bytes(plant_of(scenario(case)), fmi, platforms=(platform,))

    return fmu


@pytest.mark.parametrize("platform", [name for name, file in FILES.items() if not file[0]])
def test_platforms_without_a_name_in_fmi_2(platform):
    with pytest.raises(Exception, match="FMI 2 has no name"):
        target(platform, 2)


@pytest.mark.parametrize(("platform", "fmi"), [("win64", 2), ("win64", 3), ("linux-aarch64", 3), ("macos-aarch64", 3)])
def test_a_binary_for_a_platform(platform, fmi, built, tmp_path):
    check_wanted(platform)
    *folders, ending, magic = FILES[platform]
    folder = folders[fmi - 2]
    path = tmp_path / "it.fmu"
    path.write_bytes(built(platform, "caroca", fmi))
    with zipfile.ZipFile(path) as archive:
        (name,) = (name for name in archive.namelist() if name.startswith("binaries/"))
        binary = archive.read(name)
    assert name == f"binaries/{folder}/cdpr_plant{ending}"
    assert binary.startswith(magic)
    declared = re.findall(rf"FMI{fmi}_Export\s+\w+TYPE\s+(\w+);", (STANDARD / f"fmi{fmi}Functions.h").read_text())
    assert len(declared) > 40
    assert [name for name in declared if name.encode() not in binary] == []


@pytest.mark.parametrize("platform", EMULATORS)
def test_the_same_motion_on_another_platform(platform, built, tmp_path):
    """A host in C gets there what it gets here, from a library of the system's compiler: to the bit on Linux."""
    check_wanted(platform)
    if EMULATORS[platform] is None:
        pytest.skip(f"no emulator of {platform} is installed (qemu-user with libc6-arm64-cross, wine64)")
    cross = CROSSES[platform]
    there = compile_host(tmp_path, zig_program(), "cc", "-target", cross.zig, ending=".exe")
    (tmp_path / "here").mkdir()
    here = compile_host(tmp_path / "here")
    for case, rounded in CASES.items():
        for fmi in (2, 3) if cross.fmi2 and case == "caroca" else (3,):
            states = []
            for host, emulator, chosen in ((here, (), "native"), (there, EMULATORS[platform], platform)):
                path = tmp_path / "it.fmu"
                path.write_bytes(built(chosen, case, fmi))
                words = [*emulator, host, *arguments(path, tmp_path / f"{case}{fmi}{chosen}")]
                done = subprocess.run(words, capture_output=True, text=True, timeout=300)
                assert done.returncode == 0, done.stderr
                states.append([float(line) for line in done.stdout.split()])
            assert len(states[0]) == 13
            allowed = ROUND_OFF if rounded and platform == "win64" else 0.0
            np.testing.assert_allclose(states[1], states[0], rtol=0.0, atol=allowed, err_msg=f"{case}, FMI {fmi}")
