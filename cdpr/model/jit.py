"""Kernels: functions that are compiled, once for a state of the sources; the one place where that is asked for.

What an earlier process has left as machine code is called without numba (`objects`). Numba is imported for what is not
there yet: it takes longer to start than a short run.
"""

from __future__ import annotations

import functools
import hashlib
import os
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any, ParamSpec, TypeVar, cast

import numpy as np

from cdpr.interrupts import uninterrupted
from cdpr.model import kernel_cache, objects
from cdpr.model.kinds import Kind, Signature, kind_of, text

P = ParamSpec("P")
R = TypeVar("R")

DISABLED = os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0")

# Whether kernels without code on disk run as Python.
_UNCOMPILED: ContextVar[bool] = ContextVar("uncompiled", default=False)


@contextmanager
def without_compiling() -> Iterator[None]:
    """Run kernels that have no code on disk as plain Python: for a few calls, which take less than to compile them.

    Not for kernels that call others by their address, which only compiled code can.
    """
    token = _UNCOMPILED.set(True)
    try:
        with np.errstate(all="ignore"):
            yield
    finally:
        _UNCOMPILED.reset(token)


def kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile `function` at its first call and keep the result on disk.

    Kernels work on C-contiguous float64 arrays. Division by zero yields inf or nan, as in numpy, so that a
    degenerate geometry reaches the checks instead of raising in the loop. No fast-math: the checks must see NaN.
    They work in place: a kernel makes no array and returns none, its caller owns them all. So none counts references,
    which would take half the time of a tension distribution (`_nrt`; each slice is an atomic increment otherwise).
    With NUMBA_DISABLE_JIT=1 the same source runs as plain Python, as silent as compiled code about what is not finite.
    """
    if DISABLED:
        return np.errstate(all="ignore")(function)
    return cast("Callable[P, R]", Kernel(function))


def kernel_of_kind(function: Callable[P, R], kind: str) -> Callable[P, R]:
    """Compile, as `kernel` does, a function that another makes anew for each `kind`, whose text tells them apart."""
    return cast("Callable[P, R]", Kernel(function, kind))


def apart(function: Callable[P, R]) -> Callable[P, R]:
    """Let the kernels that call this one, a `kernel`, call its code where it is: none gets a copy (`linking`).

    For the large ones that several call; the answers are the same to the bit. A small one is faster within its callers,
    where it is optimised with them.
    """
    if isinstance(function, Kernel):
        function.apart = True
    return function


def small(function: Callable[P, R]) -> Callable[P, R]:
    """Let Python call this one, a `kernel` of a few operations, as it stands: a way into compiled code is not worth it.

    So are those that it calls.
    """
    if isinstance(function, Kernel):
        function.call = function.py_func
    return function


def any_width(function: Callable[P, R]) -> Callable[P, R]:
    """Say of a `kernel` that it serves eight problems side by side as well, given arrays of lanes (`cdpr.model.lanes`).

    Numbers that are no arrays are the same for all eight. If it returns something, that is the bits of those that it
    has not served: for them it has changed nothing that it reads.
    """
    if isinstance(function, Kernel):
        function.any_width = True
    return function


def bind(function: Callable[..., R], *args: Any) -> Callable[[], R]:
    """Return a call of a kernel with these arguments: where it is called often, a `partial` costs more."""
    return function.bind(*args) if isinstance(function, Kernel) else functools.partial(function, *args)


def threaded_kernel(signature: Signature) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Compile for one signature, at its first call, a kernel that lets other threads run meanwhile."""

    def compiled(function: Callable[P, R]) -> Callable[P, R]:
        if DISABLED:
            return np.errstate(all="ignore")(function)
        return cast("Callable[P, R]", Threaded(function, signature))

    return compiled


class _Compiled:
    """A function and what numba makes of it, when it is asked.

    Attributes:
        py_func: the function.
    """

    def __init__(self, function: Callable[..., Any], kind: str | None = None) -> None:
        functools.update_wrapper(cast("Callable[..., Any]", self), function)
        self.py_func = function
        self._kind = kind
        self._sources = "" if kind is not None else kernel_cache.digest_around(function.__module__)
        self._lock = threading.Lock()
        self._made: Any = None

    @property
    def dispatcher(self) -> Any:
        """What numba calls."""
        if self._made is None:
            compiler = _compiler()
            with self._lock:
                self._made = self._made or self._make(compiler)
        return self._made

    def _make(self, compiler: Any) -> Any:
        raise NotImplementedError


class Kernel(_Compiled):
    """What `kernel` returns: code from disk where there is some for the arguments, else numba's.

    What is not said here is numba's.

    Attributes:
        apart: whether callers call its code where it is.
        any_width: whether it serves eight problems at once, too.
    """

    apart = False
    any_width = False

    def __init__(self, function: Callable[..., Any], kind: str | None = None) -> None:
        super().__init__(function, kind)
        code = function.__code__
        self._identity = repr(
            (function.__module__, function.__qualname__, code.co_firstlineno, code.co_code, self._sources, kind)
        )
        self._kept = self._sources is not None and (kind is not None or not function.__closure__)
        self._calls: dict[tuple[Kind | None, ...], Callable[..., Any]] = {}
        self._natives: dict[tuple[Kind, ...], objects.Found] = {}
        self.call: Callable[..., Any] = self._choose

    def __call__(self, *args: Any, **kws: Any) -> Any:
        """Call it."""
        return self.dispatcher(*args, **kws) if kws else self.call(*args)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self.dispatcher, name)

    def __reduce__(self) -> Any:
        return Kernel, (self.py_func, self._kind)

    @property
    def _numba_type_(self) -> Any:
        return self.dispatcher._numba_type_

    def key_of(self, types: str) -> str | None:
        """Return what its code for such arguments is called; None where it is not kept without numba."""
        if not self._kept:
            return None
        return hashlib.sha256(f"{self._identity} {types}".encode()).hexdigest()[:32]

    def bind(self, *args: Any) -> Callable[[], Any]:
        """Return a call of it with these arguments, for those that are many: nothing is asked each time."""
        kinds = tuple(map(kind_of, args))
        known = tuple(kind for kind in kinds if kind is not None)
        found = self._find(known) if len(known) == len(kinds) else None
        call = self.dispatcher.called() if found is None else objects.call(*found, known, self._by_numba)
        return functools.partial(call, *args)

    def native(self, kinds: tuple[Kind, ...]) -> objects.Found:
        """Return its code for arguments of these kinds, as other compiled code calls it."""
        found = self._natives.get(kinds)
        if found is None:
            kept = self._find(kinds)
            found = self._natives[kinds] = self.dispatcher.native(kinds) if kept is None else kept[0]
        return found

    def _find(self, kinds: tuple[Kind, ...]) -> tuple[objects.Found, objects.Library] | None:
        key = self.key_of(", ".join(map(text, kinds)))
        return None if key is None else objects.find(key)

    def _choose(self, *args: Any) -> Any:
        """Call what these arguments need; from now on without asking, where they are of the first kinds again."""
        kinds = tuple(map(kind_of, args))
        call = self._calls.get(kinds)
        first = self.call == self._choose
        if call is None:
            known = tuple(kind for kind in kinds if kind is not None)
            found = self._find(known) if len(known) == len(kinds) else None
            if found is not None:
                call = self._calls[kinds] = objects.call(*found, known, self._by_numba)
                if first:
                    self.call = objects.call(*found, known, self._choose)
            elif _UNCOMPILED.get():
                return self.py_func(*args)
            elif first:
                self.call = self.dispatcher.called()
        return self._by_numba(*args) if call is None else call(*args)

    def _by_numba(self, *args: Any) -> Any:
        return self.py_func(*args) if _UNCOMPILED.get() else self.dispatcher.called()(*args)

    def _make(self, compiler: Any) -> Any:
        return compiler.dispatcher(self.py_func, self._sources, self._kind, self.apart, self.key_of)


class Threaded(_Compiled):
    """What `threaded_kernel` returns."""

    def __init__(self, function: Callable[..., Any], signature: Signature) -> None:
        super().__init__(function)
        self._signature = signature

    def __call__(self, *args: Any) -> Any:
        """Call it; kernels among the arguments are called by it."""
        return self.dispatcher(*(each.dispatcher if isinstance(each, Kernel) else each for each in args))

    def _make(self, compiler: Any) -> Any:
        return compiler.threaded(self.py_func, self._sources, self._signature)


_announcements: list[Callable[[], None]] = []


@functools.cache
def _compiler() -> Any:
    with uninterrupted():  # half imported, numba cannot be used in this process any more
        from cdpr.model import compiler

    for announce in _announcements:
        compiler.on_first_compilation(announce)
    return compiler


def on_first_compilation(announce: Callable[[], None]) -> None:
    """Call `announce` once, should a kernel have to be compiled because no earlier run has left it on disk."""
    if "cdpr.model.compiler" in sys.modules:
        _compiler().on_first_compilation(announce)
    else:
        _announcements.append(announce)
