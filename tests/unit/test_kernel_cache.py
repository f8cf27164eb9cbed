"""Compiled kernels: never stale, and no folder to keep them in is no reason to fail."""

from __future__ import annotations

import importlib
import os
import shutil
import subprocess
import sys

import numba
import numpy as np
import pytest
from conftest import ROOT
from spread import sampled

from cdpr.model import jit, kernel_cache, kernel_store, kernels, linking

compiled = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="NUMBA_DISABLE_JIT: nothing is compiled")

# Says how many kernels were compiled for the answer of one.
ROTATE = """
from numba.core import event
from cdpr.model import kernels

with event.install_recorder("numba:compile") as compiled:
    answer = kernels.rotate(*{!r})
print(kernels.__file__, len(compiled.buffer) // 2, answer)
"""
TURN = ((0.5, 0.5, 0.5, 0.5), (1.0, 2.0, 3.0))

RUN = "import cdpr; print(cdpr.simulate({!r}, overrides={{'simulation.duration': 0.01}}).rows[-1].tolist())"


def run(tree, code=None, **env):
    return subprocess.run(
        [sys.executable, "-c", code or RUN.format(str(tree / "scenarios" / "caroca.yaml"))],
        env={**os.environ, "PYTHONPATH": str(tree), **env},
        cwd=tree,
        capture_output=True,
        text=True,
        check=True,
    )


@pytest.mark.slow
def test_a_change_in_a_called_kernel_is_seen(tmp_path):
    """numba looks only at the file of the kernel itself; this one is called from others."""
    for name in (*kernel_cache.PACKAGES, "scenarios"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    cache = {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    before = run(tmp_path, **cache).stdout
    kernels = tmp_path / "cdpr" / "mechanics" / "geometry.py"
    text = kernels.read_text()
    changed = text.replace("scale = tension[i] /", "scale = 0.9 * tension[i] /")
    assert changed != text
    kernels.write_text(changed)
    assert run(tmp_path, **cache).stdout != before
    kernels.write_text(text)
    assert run(tmp_path, **cache).stdout == before


@pytest.mark.slow
def test_without_a_place_for_kernels_it_still_runs(tmp_path):
    done = run(ROOT, NUMBA_CACHE_DIR="/dev/null/nowhere")
    assert "cannot be written" in done.stderr
    assert done.stdout == run(ROOT).stdout


def test_other_states_of_the_sources_are_kept_but_not_for_ever(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    for i in range(20):
        old = tmp_path / f"kernels-{i}"
        old.mkdir()
        os.utime(old, (i, i))
    for i in range(20, 30):  # of checkouts that are in use
        (tmp_path / f"kernels-{i}").mkdir()
    (tmp_path / "mine").mkdir()
    chosen = kernel_cache.folder()
    assert chosen == str(tmp_path / f"kernels-{kernel_cache.digest()}")
    kept = {f"kernels-{i}" for i in range(20 - kernel_cache.KEPT, 30)} | {f"kernels-{kernel_cache.digest()}"}
    assert {path.name for path in tmp_path.glob("kernels-*")} == kept
    assert (tmp_path / "mine").exists()


def test_what_is_used_stays_however_old_it_is(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    chosen = kernel_cache.folder()
    os.utime(chosen, (0, 0))
    for i in range(20):
        (tmp_path / f"kernels-{i}").mkdir()
    assert kernel_cache.folder() == chosen
    assert os.stat(chosen).st_mtime > 0


@pytest.fixture
def store(tmp_path, monkeypatch):
    """Kernels made in this test are kept in this folder, under the name that the test process and others would use."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    kernel_cache.kept.cache_clear()
    yield kernel_cache.kept()
    kernel_cache.kept.cache_clear()


def copied(tmp_path):
    """Copy the core into another folder."""
    shutil.copytree(ROOT / "cdpr", tmp_path / "cdpr", ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path


@pytest.mark.slow
@compiled
def test_the_same_sources_in_another_folder_are_found_compiled(store, tmp_path):
    expected = jit.kernel(kernels.rotate.py_func)(*TURN)
    tree = copied(tmp_path)
    file, compiled, answer = run(tree, ROTATE.format(TURN)).stdout.split(maxsplit=2)
    assert file == str(tree / "cdpr" / "model" / "kernels.py")
    assert compiled == "0"
    assert answer.strip() == str(expected)


@pytest.mark.slow
@compiled
def test_a_changed_kernel_is_compiled_anew(store, tmp_path):
    jit.kernel(kernels.rotate.py_func)(*TURN)
    tree = copied(tmp_path)
    file = tree / "cdpr" / "model" / "kernels.py"
    text = file.read_text()
    changed = text.replace("def cross(a: Vector, b: Vector) -> Vector:", "def cross(b: Vector, a: Vector) -> Vector:")
    assert changed != text
    file.write_text(changed)
    _, compiled, answer = run(tree, ROTATE.format(TURN)).stdout.split(maxsplit=2)
    assert int(compiled) > 0
    assert answer.strip() != str(kernels.rotate(*TURN))


@pytest.fixture
def stranger(tmp_path, monkeypatch):
    """A module of nobody's package, with a kernel, and a neighbour that holds what the kernel calls."""
    folder = tmp_path / "modules"
    folder.mkdir()
    (folder / "stranger_helper.py").write_text(HELPER.format(factor=2.0))
    (folder / "stranger.py").write_text(STRANGER)
    monkeypatch.syspath_prepend(folder)
    for name in ("stranger", "stranger_helper"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    kernel_cache._digest_of.cache_clear()
    yield folder
    for name in ("stranger", "stranger_helper"):
        sys.modules.pop(name, None)


HELPER = """
from cdpr.model.jit import kernel

@kernel
def scaled(x):
    return {factor} * x
"""
STRANGER = """
from cdpr.model.jit import kernel
from stranger_helper import scaled

@kernel
def first(x):
    return scaled(x[0])
"""


def fresh():
    """Import the stranger as a new process would."""
    for name in ("stranger", "stranger_helper"):
        sys.modules.pop(name, None)
    kernel_cache._digest_of.cache_clear()
    importlib.invalidate_caches()
    return importlib.import_module("stranger").first


@compiled
def test_each_signature_has_a_file_and_is_loaded_again(store, stranger):
    one, two = np.array([1.0]), np.array([1])  # float64 and int64
    made = fresh()
    assert (made(one), made(two)) == (2.0, 2.0)
    assert len(list(store.glob("stranger.first-*"))) == 2
    again = fresh()
    assert (again(one), again(two)) == (2.0, 2.0)
    assert sum(again.stats.cache_hits.values()) == 2


@pytest.mark.slow
@compiled
def test_a_change_beside_a_strangers_kernel_is_seen(store, stranger):
    assert fresh()(np.ones(1)) == 2.0
    (stranger / "stranger_helper.py").write_text(HELPER.format(factor=30.0))
    assert fresh()(np.ones(1)) == 30.0


@compiled
@sampled(1, "damage", [lambda whole: whole[: len(whole) // 2], lambda whole: b"", lambda whole: whole[::-1]])
def test_a_damaged_file_is_compiled_again(store, stranger, damage):
    fresh()(np.ones(1))
    (file,) = store.glob("stranger.first-*")
    whole = file.read_bytes()
    file.write_bytes(damage(whole))
    again = fresh()
    with pytest.warns(UserWarning, match="is damaged: it is not used, and compiled again"):
        assert again(np.ones(1)) == 2.0
    assert not again.stats.cache_hits
    kept = fresh()
    assert kept(np.ones(1)) == 2.0
    assert kept.stats.cache_hits  # it is whole again


@compiled
@pytest.mark.skipif(os.geteuid() != 0, reason="gives files to another user")
def test_a_file_of_another_user_is_compiled_again(store, stranger):
    fresh()(np.ones(1))
    (file,) = store.glob("stranger.first-*")
    os.chown(file, 12345, 12345)
    with pytest.warns(UserWarning, match="belongs to another user: it is not used, and compiled again"):
        assert fresh()(np.ones(1)) == 2.0
    assert file.stat().st_uid == 0


@compiled
def test_a_full_disk_costs_the_cache_and_not_the_run(store, stranger, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(kernel_store.os, "replace", full)
    assert fresh()(np.ones(1)) == 2.0
    assert not list(store.iterdir())


@compiled
def test_what_has_no_file_is_not_kept(store):
    """In a notebook nothing tells when a kernel has changed that this one calls."""
    space = {"__name__": "no_such_module"}
    exec("def double(x):\n    return 2.0 * x", space)
    assert jit.kernel(space["double"])(1.5) == 3.0
    assert not list(store.iterdir())


@pytest.mark.slow
@compiled
def test_of_what_lies_on_disk_the_code_for_compilers_is_read_when_one_asks(store):
    jit.kernel(kernels.rotate.py_func)(*TURN)
    found = jit.kernel(kernels.rotate.py_func)
    assert found(*TURN) == kernels.rotate(*TURN)
    assert loaded(found) == [1]
    ((signature, entry),) = found.overloads.items()
    assert entry.library._shared_module is None
    assert entry.library.get_pointer_to_function("no such name") == 0
    space = {"found": found}
    exec("def back(q, v):\n    return found((q[0], -q[1], -q[2], -q[3]), found(q, v))", space)
    back = numba.njit(space["back"])
    assert np.allclose(back(*TURN), TURN[1], atol=1e-15)
    assert entry.library._shared_module is not None
    assert signature == entry.signature.args


# A kernel that others call where its code is, by way of one that is copied into its callers.
SHARED = """
from cdpr.model.jit import apart, kernel

@apart
@kernel
def scaled(x):
    return {factor} * x

@kernel
def twice(x):
    return scaled(x) + scaled(x)
"""
CALLS_SHARED = """
from cdpr.model.jit import kernel
from stranger_helper import twice

@kernel
def first(x):
    return twice(x[0])
"""


@pytest.fixture
def apart(tmp_path, stranger, monkeypatch):
    """The stranger calls a kernel of another package; write it with a factor, and no address is known of it."""
    (stranger / "stranger_helper.py").unlink()
    other = tmp_path / "other"
    other.mkdir()
    monkeypatch.syspath_prepend(other)

    def write(factor):
        (other / "stranger_helper.py").write_text(SHARED.format(factor=factor))
        (stranger / "stranger.py").write_text(CALLS_SHARED)
        monkeypatch.setattr(linking, "_linked", {})
        return fresh()

    return write


def loaded(*kernels):
    return [sum(each.stats.cache_hits.values()) for each in kernels]


@compiled
def test_what_is_called_apart_is_not_copied(store, apart):
    first = apart(2.0)
    assert first(np.ones(1)) == 4.0
    (library,) = (each.library for each in first.overloads.values())
    assert [(each.module, each.name) for each in linking.needed_by(library)] == [("stranger_helper", "scaled")]
    assert not any("scaled" in each.name for each in library.get_defined_functions())


@pytest.mark.slow
@compiled
def test_processes_at_once_keep_kernels_and_what_they_call_apart(store, tmp_path, apart):
    """And this one, which has compiled none of them, loads both."""
    factor = 3.0
    first = apart(factor)
    helper = sys.modules["stranger_helper"]
    script = "import numpy, stranger; print(stranger.first(numpy.ones(1)))"
    path = os.pathsep.join(map(str, (ROOT, tmp_path / "modules", tmp_path / "other")))
    both = [
        subprocess.Popen(
            [sys.executable, "-c", script],
            env={**os.environ, "PYTHONPATH": path, "CC": "/nowhere/cc"},  # they leave nothing but what numba loads
            stdout=subprocess.PIPE,
            text=True,
        )
        for _ in range(2)
    ]
    assert [each.communicate()[0] for each in both] == ["6.0\n"] * 2
    assert first(np.ones(1)) == 6.0
    assert loaded(first, helper.scaled, helper.twice) == [1, 1, 0]


@compiled
@pytest.mark.filterwarnings("ignore:.* is damaged")
@sampled(1, "damage", [lambda file: file.write_bytes(b"?"), lambda file: file.unlink()])
def test_what_is_called_apart_is_compiled_again_where_its_file_is_damaged(store, apart, damage):
    apart(2.0)(np.ones(1))
    (file,) = store.glob("stranger_helper.scaled-*")
    damage(file)
    again = apart(2.0)
    assert again(np.ones(1)) == 4.0
    assert loaded(again, sys.modules["stranger_helper"].scaled) == [1, 0]


@compiled
def test_a_change_of_what_is_called_apart_is_seen(store, apart):
    """Though nothing of the caller's package has changed."""
    assert apart(2.0)(np.ones(1)) == 4.0
    again = apart(50.0)
    assert again(np.ones(1)) == 100.0
    assert loaded(again) == [0]


def test_moved_sources_have_another_digest(tmp_path, monkeypatch):
    """Two files of one name that change places make other kernels."""
    monkeypatch.syspath_prepend(tmp_path)
    found = set()
    for contents in (("kernel one", "kernel two"), ("kernel two", "kernel one")):
        for place, content in zip(("a", "b"), contents, strict=True):
            (tmp_path / "moving" / place).mkdir(parents=True, exist_ok=True)
            (tmp_path / "moving" / place / "same.py").write_text(f"@kernel\ndef f(x):\n    return '{content}'\n")
        monkeypatch.setattr(kernel_cache, "PACKAGES", ("moving",))
        kernel_cache.digest.cache_clear()
        found.add(kernel_cache.digest())
    kernel_cache.digest.cache_clear()
    assert len(found) == 2


def test_constants_of_a_kernel_count_and_types_and_locks_of_editors_do_not(tmp_path, monkeypatch):
    """What a kernel's file imports is compiled in, but for type checkers alone; an editor's lock leads nowhere."""
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(kernel_cache, "PACKAGES", ("fixed",))
    (tmp_path / "fixed" / "deep").mkdir(parents=True)
    (tmp_path / "fixed" / "__init__.py").write_text("")
    (tmp_path / "fixed" / "compiled.py").write_text(
        "from typing import TYPE_CHECKING\n\nif TYPE_CHECKING:\n    from fixed import words\n\n"
        "from fixed.deep import (\n    numbers,\n)\n\n@kernel\ndef f(x):\n    return x * numbers.GAIN\n"
    )
    (tmp_path / "fixed" / ".#compiled.py").symlink_to("nobody@nowhere.1")
    found = []
    for gain, other in ((1, 1), (2, 1), (2, 2)):
        (tmp_path / "fixed" / "deep" / "numbers.py").write_text(f"GAIN = {gain}\n")
        (tmp_path / "fixed" / "words.py").write_text(f"OTHER = {other}  # no kernel uses it\n")
        kernel_cache.digest.cache_clear()
        found.append(kernel_cache.digest())
    kernel_cache.digest.cache_clear()
    assert found[0] != found[1] == found[2]


def test_read_only_arrays_make_no_second_version():
    @jit.kernel
    def double(a, b):
        for i in range(len(a)):
            b[i] = 2.0 * a[i]
        return 0

    given, result = np.arange(3.0), np.zeros(3)
    for writeable in (False, True, False):
        given.flags.writeable = writeable
        double(given, result)
    np.testing.assert_array_equal(result, [0.0, 2.0, 4.0])
    assert len(getattr(double, "signatures", [1])) == 1


def test_constants_make_no_second_version():
    @jit.kernel
    def fill(count, value, b):
        for i in range(count):
            b[i] = value
        return 0

    @jit.kernel
    def call(b):
        fill(2, 1.0, b[1:])
        return fill(len(b) - 1, b[1] + b[2], b)

    result = np.zeros(3)
    call(result)
    np.testing.assert_array_equal(result, [2.0, 2.0, 1.0])
    assert len(getattr(fill, "signatures", [])) <= 1  # none where an earlier process has left `call`


@pytest.mark.skipif(jit.DISABLED, reason="nothing is compiled")
def test_how_our_kernels_are_compiled_is_not_how_others_are():
    import numba

    from cdpr.model.compiler import Ours
    from cdpr.model.kernels import copy

    before = numba.config.OPT, numba.config.LOOP_VECTORIZE
    seen = []

    class Told(Ours):
        def add_overload(self, compiled):
            seen.append((numba.config.OPT, numba.config.LOOP_VECTORIZE))
            super().add_overload(compiled)

    Told(lambda x: x + 1.0, targetoptions={}).compile((numba.float64,))
    assert seen == [(1, 0)]
    assert before == (numba.config.OPT, numba.config.LOOP_VECTORIZE)
    assert isinstance(copy.dispatcher, Ours)
    assert not isinstance(jit.kernel(lambda x: x).dispatcher, Ours)
