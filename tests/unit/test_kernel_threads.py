"""A kernel that two threads call for the first time at once."""

from __future__ import annotations

import threading

import numba
import pytest

from cdpr.model import compiler


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="NUMBA_DISABLE_JIT: nothing is compiled")
def test_it_is_asked_for_once_and_found_ever_after(monkeypatch):
    double = compiler.Dispatcher(lambda x: 2.0 * x, targetoptions={"nopython": True, "_nrt": False})
    asked, both = [], threading.Barrier(2)
    compile_for = compiler.Dispatcher._compile_for_args

    def together(self, *args):
        asked.append(args)
        if len(asked) <= 2:
            both.wait(timeout=60.0)
        return compile_for(self, *args)

    monkeypatch.setattr(compiler.Dispatcher, "_compile_for_args", together)
    answers = []
    threads = [threading.Thread(target=lambda: answers.append(double(1.5))) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert answers == [3.0, 3.0]
    assert double(2.0) == 4.0
    assert len(asked) == 2  # numba calls what it has, and asks no more
