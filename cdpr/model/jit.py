"""The one place where numba is told how to compile our kernels."""

from __future__ import annotations

import contextlib
import gc
import sys
from collections.abc import Callable, Iterator
from typing import Any, ParamSpec, TypeVar, cast

import numba
import numpy as np
from numba.core import sigutils
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import CPUDispatcher

from cdpr.model import kernel_cache, linking
from cdpr.model.kernel_store import KernelStore

P = ParamSpec("P")
R = TypeVar("R")

OPTIONS = {"nopython": True, "error_model": "numpy", "_nrt": False}


def kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile `function` at its first call and keep the result on disk.

    Kernels work on C-contiguous float64 arrays. Division by zero yields inf or nan, as in numpy, so that a
    degenerate geometry reaches the checks instead of raising in the loop. No fast-math: the checks must see NaN.
    They work in place: a kernel makes no array and returns none, its caller owns them all. So none counts references,
    which would take half the time of a tension distribution (`_nrt`; each slice is an atomic increment otherwise).
    With NUMBA_DISABLE_JIT=1 the same source runs as plain Python, as silent as compiled code about what is not finite.
    """
    if numba.config.DISABLE_JIT:
        return np.errstate(all="ignore")(function)
    return cast("Callable[P, R]", _kept(_Kernel(function, targetoptions=OPTIONS)))


def kernel_of_kind(function: Callable[P, R], kind: object) -> Callable[P, R]:
    """Compile, as `kernel` does, a function that another makes anew for each `kind`, whose text tells them apart."""
    kept = _Kernel(function, targetoptions=OPTIONS)
    kept._cache = KernelStore(function, "", kind=repr(kind))
    return cast("Callable[P, R]", kept)


def is_kernel(function: object) -> bool:
    """Whether this is what `kernel` returns, and compiled."""
    return isinstance(function, _Kernel)


def apart(function: Callable[P, R]) -> Callable[P, R]:
    """Let the kernels that call this one, a `kernel`, call its code where it is: none gets a copy (`linking`).

    For the large ones that several call; the answers are the same to the bit. A small one is faster within its callers,
    where it is optimised with them.
    """
    if isinstance(function, _Kernel) and isinstance(function._cache, KernelStore):
        function.apart = True
    return function


def threaded_kernel(signature: object) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Compile for one signature, when the module is imported, a kernel that lets other threads run meanwhile."""

    def compiled(function: Callable[P, R]) -> Callable[P, R]:
        if numba.config.DISABLE_JIT:
            return np.errstate(all="ignore")(function)
        dispatcher = _kept(numba.njit(error_model="numpy", nogil=True)(function))
        with global_compiler_lock, _uncollected(), _interruptible():
            dispatcher.compile(signature)
        dispatcher.disable_compile()
        return cast("Callable[P, R]", dispatcher)

    return compiled


class _Kernel(CPUDispatcher):  # type: ignore[misc]
    """What numba calls; one version serves read-only arrays and arguments that are constants where it is called.

    numba would compile another for each combination, and does so in the middle of a run where a caller's arrays are
    read-only for the first time. The code is the same: that a kernel writes only what it says is its own duty.

    Attributes:
        apart: whether callers call its code where it is.
    """

    apart = False

    def compile(self, sig: Any) -> Any:
        args = tuple(sigutils.normalize_signature(sig)[0])
        with global_compiler_lock, _uncollected(), _interruptible():
            new = args not in self.overloads
            entry = super().compile(sig)
            if self.apart and new:
                linking.call_apart(self.targetctx, self, self.overloads[args], linking.SYMBOL + self._cache.key(args))
        return entry

    def get_call_template(self, args: Any, kws: Any) -> Any:
        plain = [numba.types.unliteral(arg) for arg in args]
        return super().get_call_template(plain, {name: numba.types.unliteral(arg) for name, arg in kws.items()})

    def _compile_for_args(self, *args: Any, **kws: Any) -> Any:
        given = [self.typeof_pyval(arg) for arg in args]
        writable = [each.copy(readonly=False) if isinstance(each, numba.types.Array) else each for each in given]
        if given == writable:
            return super()._compile_for_args(*args, **kws)
        entry = self.compile(tuple(writable))
        self._insert([each._code for each in given], entry, False)
        return entry


@contextlib.contextmanager
def _uncollected() -> Iterator[None]:
    """Look for no garbage meanwhile: a compiler makes objects by the million, and the looking costs a seventh of it."""
    looks = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if looks:
            gc.enable()


@contextlib.contextmanager
def _interruptible() -> Iterator[None]:
    """End afterwards with an interrupt that came meanwhile.

    Python raises it where LLVM, which takes nearly all the time, calls back; and no exception passes through there.
    """
    lost: list[BaseException] = []
    before = sys.unraisablehook

    def keep(raised: Any) -> None:
        if isinstance(raised.exc_value, KeyboardInterrupt):
            lost.append(raised.exc_value)
        else:
            before(raised)

    sys.unraisablehook = keep
    try:
        yield
    except Exception as error:  # numba misses what LLVM would have told it
        if lost:
            raise KeyboardInterrupt from error
        raise
    finally:
        sys.unraisablehook = before
    if lost:
        raise KeyboardInterrupt


def _kept(dispatcher: Any) -> Any:
    """Have what numba compiles kept on disk."""
    sources = kernel_cache.digest_around(dispatcher.__module__)
    if sources is not None:
        dispatcher._cache = KernelStore(dispatcher.py_func, sources)
    return dispatcher


def on_first_compilation(announce: Callable[[], None]) -> None:
    """Call `announce` once, should a kernel have to be compiled because no earlier run has left it on disk."""
    from numba.core import event

    class Listener(event.Listener):  # type: ignore[misc]
        said = False

        def on_start(self, event: object) -> None:
            if not Listener.said:
                Listener.said = True
                announce()

        def on_end(self, event: object) -> None:
            pass

    event.register("numba:compile", Listener())
