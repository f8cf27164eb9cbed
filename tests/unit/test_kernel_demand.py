"""A kernel becomes the machine's code where something other than a kernel calls it, and not before."""

from __future__ import annotations

import gc

import numba
import pytest

from cdpr.model import compiler, kernel_cache
from cdpr.model.kernel_store import KernelStore
from cdpr.model.kinds import NUMBER

pytestmark = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="NUMBA_DISABLE_JIT: nothing is compiled")


def inner(x):
    return 3.0 * x


@pytest.fixture(autouse=True)
def store(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    kernel_cache.kept.cache_clear()
    yield
    kernel_cache.kept.cache_clear()


def made():
    """A pair of kernels as a new process has them: one, and one that calls it."""
    callee = compiler.dispatcher(inner, "sources of a test", None, False, lambda types: None)

    def outer(x):
        return callee(x) + 1.0

    return callee, compiler.dispatcher(outer, None, None, False, lambda types: None)


def only(kernel):
    (entry,) = kernel.overloads.values()
    return entry.library


def test_a_kernel_that_kernels_alone_call_stays_what_compilers_read():
    callee, caller = made()
    assert caller(2.0) == 7.0
    assert only(caller).made
    assert not only(callee).made


def test_it_can_be_called_later():
    callee, caller = made()
    caller(2.0)
    assert callee(5.0) == 15.0
    assert only(callee).made
    assert caller(5.0) == 16.0


@pytest.mark.slow
@pytest.mark.parametrize("asked", [False, True])
def test_on_disk_it_is_as_it_was_asked_for(asked):
    callee, caller = made()
    caller(2.0)
    if asked:
        callee(2.0)
    again, caller = made()
    assert caller(4.0) == 13.0
    assert only(again).made == asked
    assert again(5.0) == 15.0
    assert only(again).made
    assert isinstance(again._cache, KernelStore)
    assert sum(again.stats.cache_hits.values()) == 1
    third, _ = made()
    assert third(5.0) == 15.0
    assert sum(third.stats.cache_hits.values()) == 1
    assert only(third)._shared_module is None  # it came as the machine's code, and no compiler asked


def test_what_lets_threads_run_is_found_on_disk_as_well():
    """numba makes its way for Python at once, and asks for one of what it finds."""
    kinds = NUMBER(NUMBER)
    for hits in (0, 1):
        found = compiler.threaded(inner, "sources of a test", kinds)
        assert found(2.0) == 6.0
        assert sum(found.stats.cache_hits.values()) == hits


def test_what_others_froze_is_counted_once(monkeypatch):
    """Python goes through all of it to count it: for each kernel, that was most of the time of loading them."""
    counts, left = iter([0, 7]), []
    monkeypatch.setattr(compiler, "_frozen", False)
    monkeypatch.setattr(gc, "get_freeze_count", lambda: next(counts))
    monkeypatch.setattr(gc, "freeze", lambda: left.append("frozen"))
    monkeypatch.setattr(gc, "unfreeze", lambda: left.append("thawed"))
    for _ in range(4):
        with compiler._uncollected():
            assert not gc.isenabled()
        assert gc.isenabled()
    assert left == ["frozen", "thawed"]
