"""The one place where numba is told how to compile our kernels; imported when one is compiled or loaded by it."""

from __future__ import annotations

import contextlib
import gc
import sys
from collections.abc import Callable, Iterator
from typing import Any

import numba
from numba.core import config, event, sigutils
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import CPUDispatcher, cpu_target

from cdpr.model import lane_words, leaving, linking
from cdpr.model.kernel_store import KernelStore
from cdpr.model.kinds import Kind, Signature
from cdpr.model.numba_kinds import kind_from, numba_signature, numba_types
from cdpr.model.object_code import Compilation
from cdpr.model.objects import Found

# The ways for Python and for C to call a kernel take a fifth of what it takes to compile it, and most are called by
# other kernels alone: they are made where they are needed.
OPTIONS = {
    "nopython": True,
    "error_model": "numpy",
    "_nrt": False,
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
}

# Of LLVM's optimisation, and whether it makes loops of vectors: what more would find in our own kernels, whose loops
# are as long as there are cables, is not worth a tenth of the time of a first run.
LEVEL, VECTORS = 1, 0

cpu_target.target_context.codegen()  # made as the user says: others' code is compiled so


def dispatcher(
    function: Callable[..., Any],
    sources: str | None,
    kind: str | None,
    apart: bool,
    key_of: Callable[[str], str | None],
) -> Any:
    """Return what compiles a kernel, of which `sources` and `kind` tell as `KernelStore` has them, and calls it.

    A stranger's is compiled as numba, and its user, say.
    """
    made: Dispatcher = (Ours if sources == "" else Dispatcher)(function, targetoptions=OPTIONS)
    if sources is not None:
        made._cache = KernelStore(function, sources, kind)
        made.apart, made.key_of = apart, key_of
    return made


def threaded(function: Callable[..., Any], sources: str | None, signature: Signature) -> Any:
    """Compile for one signature what lets other threads run meanwhile."""
    made = numba.njit(error_model="numpy", nogil=True)(function)
    if sources is not None:
        made._cache = KernelStore(function, sources)
    with global_compiler_lock, _uncollected(), _interruptible():
        lane_words.tell_numba()
        made.compile(numba_signature(signature))
    made.disable_compile()
    return made


class Dispatcher(CPUDispatcher):  # type: ignore[misc]
    """What numba calls; one version serves read-only arrays and arguments that are constants where it is called.

    numba would compile another for each combination, and does so in the middle of a run where a caller's arrays are
    read-only for the first time. The code is the same: that a kernel writes only what it says is its own duty.

    Attributes:
        apart: whether callers call its code where it is.
        key_of: what its code for such arguments is called in shared objects (`cdpr.model.objects`).
    """

    apart = False
    key_of: Callable[[str], str | None] | None = None

    def __init__(self, *args: Any, **kws: Any) -> None:
        super().__init__(*args, pipeline_class=Compilation, **kws)
        self._called = False  # other than by kernels
        self._ways: list[Any] = []  # to call what is compiled, held as long as it is
        self._known: dict[tuple[Any, ...], Any] = {}  # what is called for which arguments, held likewise

    def called(self) -> Any:
        """Return itself, to be called by Python."""
        leaving.wanted(self, None)
        return self

    def native(self, kinds: tuple[Kind, ...]) -> Found:
        """Return its code for arguments of these kinds, as other compiled code calls it."""
        args = numba_types(kinds)
        entry = self._ready(args)
        leaving.wanted(self, args)
        place = entry.library.get_pointer_to_function(entry.fndesc.llvm_func_name)
        return Found(int(place), 0, kind_from(entry.signature.return_type))

    def compile(self, sig: Any) -> Any:
        """Compile for one signature, or load what is on disk; into the machine's code only where that is called."""
        args = tuple(sigutils.normalize_signature(sig)[0])
        with global_compiler_lock, _uncollected(), _interruptible():
            lane_words.tell_numba()
            new = args not in self.overloads
            entry = super().compile(sig)
            if self.apart and new and isinstance(self._cache, KernelStore):
                linking.call_apart(self.targetctx, self, self._ready(args), linking.SYMBOL + self._cache.key(args))
        return entry

    def _ready(self, args: tuple[Any, ...]) -> Any:
        """Return what is compiled, such that the machine runs it; what had to be done for that is kept on disk."""
        with global_compiler_lock:
            self._called = True
            try:
                self.compile(args)
            finally:
                self._called = False
            entry = self.overloads[args]
            if not entry.library.made:
                with _uncollected(), _interruptible():
                    entry.library.make()
                self._cache.save_overload(args, entry)
            return entry

    def add_overload(self, cres: Any) -> None:
        """Take down what was compiled, or loaded; Python cannot call it yet."""
        if self._called or self.apart:
            cres.library.make()
        self.overloads[tuple(cres.signature.args)] = cres

    def get_compile_result(self, sig: Any) -> Any:
        """Return what numba compiled, for C to call."""
        super().get_compile_result(sig)
        found = self._ready(tuple(sig.args))
        if not found.library.get_pointer_to_function(found.fndesc.llvm_cfunc_wrapper_name):
            self._add(found, self.targetctx.create_cfunc_wrapper)
        return found

    def _for_python(self, compiled: Any) -> Any:
        """Return what Python calls of something compiled."""
        if not compiled.library.get_pointer_to_function(compiled.fndesc.llvm_cpython_wrapper_name):
            self._add(compiled, self.targetctx.create_cpython_wrapper)
        return self.targetctx.get_executable(compiled.library, compiled.fndesc, compiled.environment)

    def _add(self, compiled: Any, make: Callable[..., None]) -> None:
        """Make a way to call something compiled; it finds that by its name."""
        with global_compiler_lock, _uncollected(), _interruptible():
            self.targetctx.refresh()  # which what is loaded did not need
            library = self.targetctx.codegen().create_library(f"way to {compiled.fndesc.llvm_func_name}")
            with self.targetctx.push_code_library(library):
                make(library, compiled.fndesc, compiled.environment, compiled.call_helper)
            library.finalize()
            self._ways.append(library)

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Return what numba asks of a kernel that another one calls."""
        plain = [numba.types.unliteral(arg) for arg in args]
        return super().get_call_template(plain, {name: numba.types.unliteral(arg) for name, arg in kws.items()})

    def _compile_for_args(self, *args: Any, **kws: Any) -> Any:
        assert not kws  # `Kernel` has put them into their places
        given = [self.typeof_pyval(arg) for arg in args]
        writable = [each.copy(readonly=False) if isinstance(each, numba.types.Array) else each for each in given]
        with global_compiler_lock:
            # What two threads asked for at once is there for the second: of two that are the same numba takes neither.
            entry = self._known.get(tuple(given))
            if entry is None:
                entry = self._for_python(self._ready(tuple(writable)))
                self._insert([each._code for each in given], entry, False)
                self._known[tuple(given)] = entry
        return entry


class Ours(Dispatcher):
    """What numba calls of our own kernels."""

    def compile(self, sig: Any) -> Any:
        """Compile for one signature, quickly, or load what is on disk."""
        with global_compiler_lock:
            config.reload_config()  # as numba does, where the environment has changed
            before = config.OPT, config.LOOP_VECTORIZE
            config.OPT, config.LOOP_VECTORIZE = min(before[0], type(before[0])(LEVEL)), min(before[1], VECTORS)
            try:
                return super().compile(sig)
            finally:
                config.OPT, config.LOOP_VECTORIZE = before


@contextlib.contextmanager
def _uncollected() -> Iterator[None]:
    """Look for no garbage meanwhile: a compiler makes objects by the million, and the looking costs a fifth of it."""
    looks = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if looks:
            if not _frozen_by_others():  # what is new becomes old, to be looked at with all the rest
                gc.freeze()
                gc.unfreeze()
            gc.enable()


_frozen = False  # once found, for good: Python counts what is frozen by going through all of it


def _frozen_by_others() -> bool:
    """Return whether the calling program keeps objects out of the search for garbage; thawing ours would undo that."""
    global _frozen
    _frozen = _frozen or gc.get_freeze_count() > 0
    return _frozen


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


def on_first_compilation(announce: Callable[[], None]) -> None:
    """Call `announce` once, should a kernel have to be compiled because no earlier run has left it on disk."""

    class Listener(event.Listener):  # type: ignore[misc]
        said = False

        def on_start(self, event: object) -> None:
            if not Listener.said:
                Listener.said = True
                announce()

        def on_end(self, event: object) -> None:
            pass

    event.register("numba:compile", Listener())
