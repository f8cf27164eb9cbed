"""The cache of compiled FMU libraries between processes that need the same file at once."""

from __future__ import annotations

import threading

from cdpr.fmu.export import cache


def test_concurrent_requests_for_a_file_compile_it_once(tmp_path, monkeypatch):
    """Threads here; each opens the lock for itself, as processes do."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    lock, asked, made, got = cache.lock, threading.Event(), [], []

    def asking(*arguments):
        if made:
            asked.set()
        return lock(*arguments)

    monkeypatch.setattr(cache, "lock", asking)

    def make(folder):
        made.append(folder)
        if len(made) == 1:
            other.start()
            assert asked.wait(60.0)
        (folder / "a.o").write_bytes(b"object")
        return folder / "a.o"

    def need():
        got.append(cache.kept(["c++"], {"a.cpp": b""}, ".o", 5, make))

    other = threading.Thread(target=need)
    need()
    other.join()
    assert got == [b"object", b"object"]
    assert len(made) == 1
    assert [path.suffix for path in cache.fmu_cache().iterdir()] == [".o"]
