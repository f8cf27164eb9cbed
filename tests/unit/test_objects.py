"""Kernels that an earlier process has left as a shared object run without numba, to the same bits, or not at all."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT

from cdpr.model import kernel_cache, objects
from cdpr.model.jit import DISABLED
from cdpr.model.kinds import NUMBER, ROW, WHOLE, Group
from cdpr.plugins.registry import registry

pytestmark = pytest.mark.skipif(
    DISABLED or objects.environment() is None or shutil.which("cc") is None,
    reason="no shared objects of kernels without a compiler, Linux and CPython",
)

KERNELS = """
from typing import NamedTuple
from cdpr.model.jit import apart, kernel
from helper import scaled

class Pair(NamedTuple):
    rows: object
    share: float

@kernel
def gather(table, numbers, pair, vector, whole, number, flag):
    table[0, 0] += pair.rows[0] * pair.share + vector[1] + numbers[0]
    return table[0, 0] / number, whole + numbers[-1], not flag

@kernel
def fill(row):
    row[0] = scaled(row[1])

@kernel
def limited(x):
    if x > 1.0:
        raise ValueError("too much")
    return x
"""
HELPER = """
from cdpr.model.jit import apart, kernel

@apart
@kernel
def scaled(x):
    return {factor} * x
"""
USE = """
import numpy as np
from modules import Pair, fill, gather, limited

row = np.array([0.0, 1.5, 7.0])
row.flags.writeable = False
table, numbers = np.arange(1.0, 7.0).reshape(2, 3) / 7.0, np.array([3, 4])
for number in (0.1, np.float64(0.3)):
    for flag in (True, False):
        print(gather(table, numbers, Pair(row, 0.1), (1.0, 2.0, 3.0), 2**40, number, flag))
out = np.ones(2)
print(fill(out), out, limited(0.5), limited(np.float64(0.25)))
"""
BLOCKED = """
import builtins
imported = builtins.__import__
def other(name, *given, **named):
    if name.partition(".")[0] in ("numba", "llvmlite"):
        raise ImportError("numba is asked for")
    return imported(name, *given, **named)
builtins.__import__ = other
"""
SAY = "\nimport sys; print('numba' in sys.modules)"


class Place:
    """Two strangers' modules, a cache, and processes that use them."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.cache = folder, folder / "cache"
        (folder / "a" / "modules").mkdir(parents=True)
        (folder / "a" / "modules" / "__init__.py").write_text(KERNELS)
        (folder / "b").mkdir()
        self.write(2.0)

    def write(self, factor: float) -> None:
        (self.folder / "b" / "helper.py").write_text(HELPER.format(factor=factor))

    def start(self, code: str = USE, **env: str) -> subprocess.Popen[str]:
        path = os.pathsep.join(map(str, (ROOT, self.folder / "a", self.folder / "b")))
        return subprocess.Popen(
            [sys.executable, "-c", code],
            env={**os.environ, "PYTHONPATH": path, "NUMBA_CACHE_DIR": str(self.cache), **env},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    def run(self, code: str = USE, **env: str) -> str:
        process = self.start(code, **env)
        out, err = process.communicate()
        assert process.returncode == 0, err
        return out

    @property
    def left(self) -> list[Path]:
        return sorted(self.cache.glob("kernels-*/objects-*.so"))


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """A place where one process has run; and what it said."""
    place = Place(tmp_path_factory.mktemp("objects"))
    said = place.run()
    assert len(place.left) == 1
    return place, said


@pytest.fixture
def place(compiled, tmp_path):
    """A copy of it."""
    shutil.copytree(compiled[0].folder, tmp_path / "copy", ignore=shutil.ignore_patterns("__pycache__"))
    copy = Place.__new__(Place)
    copy.folder, copy.cache = tmp_path / "copy", tmp_path / "copy" / "cache"
    return copy


@pytest.mark.slow
def test_the_next_process_needs_no_numba(compiled):
    place, said = compiled
    assert place.run(BLOCKED + USE) == said
    assert len(place.left) == 1


@pytest.fixture(scope="module")
def no_objects(tmp_path_factory):
    """A cache with what is compiled by now, but without shared objects."""
    cache = tmp_path_factory.mktemp("cache")
    kept = kernel_cache.kept()
    shutil.copytree(kept, cache / kept.name, ignore=shutil.ignore_patterns("objects-*"))
    return cache


BACKENDS = [name for name in ("reference", "mujoco", "bullet", "dart") if not registry().get("backend", name).missing]
RUNS = [("caroca", name) for name in BACKENDS]


@pytest.mark.slow
@pytest.mark.parametrize(("scenario", "backend"), [*RUNS, ("winch", "reference")])
def test_a_run_needs_no_numba_and_logs_the_same(no_objects, tmp_path, scenario, backend):
    words = ["run", f"scenarios/{scenario}.yaml", "--backend", backend, "--set", "simulation.duration=0.01"]
    code = "from cdpr.cli import cli; cli.main({!r}, standalone_mode=False)"
    for name, before in (("by_numba", ""), ("without", BLOCKED)):
        script = before + code.format([*words, "--no-report", "--out", str(tmp_path / name)])
        env = {**os.environ, "NUMBA_CACHE_DIR": str(no_objects)}
        subprocess.run([sys.executable, "-c", script], cwd=ROOT, env=env, check=True, capture_output=True)
    logs = [(tmp_path / name / "log.mcap").read_bytes() for name in ("by_numba", "without")]
    assert logs[0] == logs[1]


@pytest.mark.slow
def test_other_arguments_are_for_numba(place, compiled):
    code = USE + SAY + "\nprint(limited(-2), limited(x=0.5), fill(np.ones(4)[::2]))" + SAY
    said, then = place.run(code).split("False\n")
    assert (said, then) == (compiled[1], "-2 0.5 None\nTrue\n")


@pytest.mark.slow
def test_what_a_kernel_raises_is_raised(place):
    code = "from modules import limited\ntry:\n    limited(3.0)\nexcept ValueError as error:\n    print(error)"
    assert place.run(code) == "too much\n"


@pytest.mark.slow
@pytest.mark.parametrize(
    "damage",
    [
        lambda whole: whole[: len(whole) // 2],
        lambda whole: b"",
        lambda whole: whole[:-100],
        lambda whole: whole[:5000] + bytes(8) + whole[5008:],
    ],
)
def test_a_damaged_file_is_no_reason_to_fail_and_is_whole_again(place, compiled, damage):
    (file,) = place.left
    whole = file.read_bytes()
    file.write_bytes(damage(whole))
    assert place.run() == compiled[1]
    assert [each.read_bytes() for each in place.left] == [whole]
    assert place.run(BLOCKED + USE) == compiled[1]


@pytest.mark.slow
def test_a_library_of_somebody_else_is_not_loaded(place, compiled):
    (file,) = place.left
    shutil.copy(np._core._multiarray_umath.__file__, file)
    assert place.run() == compiled[1]
    assert place.run(BLOCKED + USE) == compiled[1]


@pytest.mark.slow
@pytest.mark.parametrize("compiler", ["/nowhere/cc", "false"])
def test_without_a_linker_numba_serves_all(place, compiled, compiler):
    (file,) = place.left
    file.unlink()
    for _ in range(2):
        assert place.run(USE + SAY, CC=compiler) == compiled[1] + "True\n"
    assert not place.left


@pytest.mark.slow
def test_killed_while_it_links_a_process_leaves_nothing(place, compiled):
    (file,) = place.left
    file.unlink()
    before = sorted(file.parent.iterdir())
    killer = place.folder / "killer"
    killer.write_text("#!/bin/sh\nkill -9 $PPID\n")
    killer.chmod(0o755)
    process = place.start(CC=str(killer))
    assert process.communicate()[0] == compiled[1]
    assert process.returncode == -9
    assert sorted(file.parent.iterdir()) == before
    assert place.run() == compiled[1]
    assert len(place.left) == 1


@pytest.mark.slow
def test_two_processes_at_once_leave_what_serves_both(place, compiled):
    (file,) = place.left
    file.unlink()
    both = [place.start() for _ in range(2)]
    assert [each.communicate()[0] for each in both] == [compiled[1]] * 2
    assert place.run(BLOCKED + USE) == compiled[1]


@pytest.mark.slow
def test_a_change_of_what_another_package_holds_is_seen(place, compiled):
    """Its code is within what was left, and nothing of the caller's package has changed."""
    place.write(30.0)
    changed = place.run()
    assert changed != compiled[1]
    assert place.run(BLOCKED + USE) == changed
    place.write(2.0)
    assert place.run(BLOCKED + USE) == compiled[1]


@pytest.mark.slow
def test_other_settings_of_numba_have_files_of_their_own(place, compiled):
    assert place.run(USE + SAY, NUMBA_OPT="1").endswith("True\n")
    assert len(place.left) == 2
    assert place.run(BLOCKED + USE) == compiled[1]


def test_what_calls_cannot_pass_does_not_fit():
    assert objects.fits((NUMBER, ROW, Group((WHOLE, ROW))), NUMBER)
    assert not objects.fits((Group((ROW,) * objects.MOST_WORDS),), NUMBER)
    assert not objects.fits((NUMBER,), Group((NUMBER,) * objects.MOST_RESULTS))
    assert not objects.fits((NUMBER,), None)
