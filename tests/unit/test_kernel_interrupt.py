"""An interrupt while a kernel is compiled ends what asked for it, though it came where LLVM calls back."""

from __future__ import annotations

import signal
import subprocess
import sys
from types import SimpleNamespace

import numba
import pytest
from numba.core.registry import cpu_target

from cdpr.model import compiler

compiled = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="NUMBA_DISABLE_JIT: nothing is compiled")


def kernel():
    """One that no cache holds."""
    return compiler.Dispatcher(lambda x: 2.0 * x, targetoptions={"nopython": True, "_nrt": False})


@pytest.fixture
def called_back(monkeypatch):
    """Where LLVM calls back once it has compiled, something else can be done; how often it did."""
    engine = cpu_target.target_context.codegen()._engine._ee
    calls = []

    def instead(do):
        def notified(module, code):
            calls.append(code)
            do()

        monkeypatch.setattr(engine, "_object_cache_notify", notified)
        return calls

    return instead


@compiled
def test_an_interrupt_within_llvm_is_not_lost(called_back, monkeypatch, capsys):
    monkeypatch.setattr(sys, "unraisablehook", hook := sys.unraisablehook)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        calls = called_back(lambda: signal.raise_signal(signal.SIGINT))
        double = kernel()
        with pytest.raises(KeyboardInterrupt):
            double(1.0)
    finally:
        signal.signal(signal.SIGINT, before)
    assert calls
    assert sys.unraisablehook is hook
    assert "Traceback" not in capsys.readouterr().err
    assert double(1.5) == 3.0  # what was compiled is whole


def test_nor_is_one_for_which_numba_then_misses_its_result(monkeypatch):
    monkeypatch.setattr(sys, "unraisablehook", sys.unraisablehook)

    def miss(interrupted):
        with compiler._interruptible():
            if interrupted:
                sys.unraisablehook(SimpleNamespace(exc_value=KeyboardInterrupt()))
            raise RuntimeError("no compiled object yet")

    with pytest.raises(KeyboardInterrupt):
        miss(True)
    with pytest.raises(RuntimeError):
        miss(False)


@compiled
def test_other_errors_within_llvm_are_told_as_ever(called_back, monkeypatch):
    told = []
    monkeypatch.setattr(sys, "unraisablehook", lambda raised: told.append(raised.exc_type))
    called_back(lambda: 1 / 0)
    assert kernel()(1.5) == 3.0
    assert set(told) == {ZeroDivisionError}


HALF = """
import signal, sys

from cdpr.model import jit

assert "numba" not in sys.modules


class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == "numba.core.compiler":
            signal.raise_signal(signal.SIGINT)


sys.meta_path.insert(0, Finder())
double = jit.kernel(lambda x: 2.0 * x)
try:
    double.dispatcher
except KeyboardInterrupt:
    print("interrupted")
assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
print(double(1.5))
"""


@pytest.mark.slow
@compiled
def test_an_interrupt_while_numba_is_imported_waits_for_its_end():
    done = subprocess.run([sys.executable, "-c", HALF], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "interrupted\n3.0\n"), done.stderr
