"""Compiled code, as it comes from the compiler and from disk: no more is made or read of it than is asked for.

numba has two things of a function: the machine's code, and the code of LLVM of which other functions are made. Most
kernels are called by other kernels alone, which hold copies of them: of those the machine's code is never made, a
twelfth of a first run. And of what is on disk LLVM's code is nearly never needed: reading it costs most of the time.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from typing import Any, NamedTuple, cast

import llvmlite.binding as llvm
from numba.core.codegen import CodeLibrary, JITCodeLibrary
from numba.core.compiler import Compiler, CompileResult
from numba.core.environment import lookup_environment
from numba.core.runtime import rtsys


class Code(NamedTuple):
    """What one compiled function is made of.

    Attributes:
        name: of numba's library.
        machine: an object file; empty where nobody has asked for it.
        bitcode: LLVM's code.
        defined: the names of the functions and variables in it.
        counts: whether it calls what counts references.
    """

    name: str
    machine: bytes
    bitcode: bytes
    defined: tuple[str, ...]
    counts: bool


class Library(JITCodeLibrary):  # type: ignore[misc]
    """numba's library of code, which becomes the machine's where that is asked for.

    Attributes:
        made: whether it has.
    """

    made = False

    def make(self) -> None:
        """Make the machine's code."""
        if not self.made:
            self.made = True
            super()._finalize_final_module()
            self.set_environments([each.name for each in self._final_module.global_variables])

    def set_environments(self, names: Iterable[str]) -> None:
        """Tell its code where the objects of Python are of which there are names among these."""
        for name in names:
            environment = lookup_environment(name)
            if environment is not None:
                self.codegen.set_env(name, environment)

    def get_pointer_to_function(self, name: str) -> int:
        """Return where a function is; 0 where there is none of that name, or no code yet."""
        return int(super().get_pointer_to_function(name)) if self.made else 0

    def serialize_using_object_code(self) -> tuple[str, str, tuple[bytes, bytes]]:
        """Return what numba keeps of it."""
        if self.made:
            return cast("tuple[str, str, tuple[bytes, bytes]]", super().serialize_using_object_code())
        return self.name, "object", (b"", self._get_module_for_linking().as_bitcode())

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True


class Compilation(Compiler):  # type: ignore[misc]
    """How numba compiles a kernel: into such a library."""

    def compile_extra(self, func: Any) -> Any:
        """Compile a function."""
        self.state.library = Library(self.state.targetctx.codegen(), func.__qualname__)
        self.state.library.enable_object_caching()
        context = self.state.targetctx  # of this compilation alone: numba copies it for each
        context.get_executable = _known_by
        context.get_abi_sizeof = cache(context.get_abi_sizeof)  # else LLVM reads a module for each variable's size
        return super().compile_extra(func)


def _known_by(library: Library, *_: Any) -> Library:
    """Return that by which numba knows a kernel: else its way for Python, which needs the machine's code."""
    library.finalize()
    return library


class ObjectCode(Library):
    """Such a library of code from disk."""

    def __init__(self, codegen: Any, code: Code) -> None:
        CodeLibrary.__init__(self, codegen, code.name)  # no more: that makes a module to compile into
        self._code, self._shared_module = code, None
        self._disable_inspection = self._finalized = True
        self.enable_object_caching()
        if code.machine:
            self.made = True
            engine = codegen._engine
            engine._ee.add_object_file(llvm.ObjectFileRef.from_data(code.machine))
            engine.finalize_object()
            engine._defined_symbols.update(code.defined)

    def make(self) -> None:
        """Make the machine's code, where it was not asked for before."""
        if not self.made:
            self._final_module = self._get_module_for_linking().clone()
        super().make()

    def _get_module_for_linking(self) -> Any:
        if self._shared_module is None:
            self._shared_module = llvm.parse_bitcode(self._code.bitcode)
        return self._shared_module


def packed(compiled: Any) -> tuple[Any, ...]:
    """Return what a compiled function is made of, to be kept."""
    # What numba found of each line, for people, is half of what it keeps, and longest in the making.
    (name, _, (machine, bitcode)), *described = compiled._replace(type_annotation="")._reduce()
    module = compiled.library._final_module
    names = [each for symbols in (module.functions, module.global_variables) for each in symbols]
    defined = tuple(each.name for each in names if not each.is_declaration)
    counts = any(each.name.startswith("NRT_") for each in names if each.is_declaration)
    return Code(name, machine, bitcode, defined, counts), *described


def unpacked(context: Any, code: Code, *described: Any) -> Any:
    """Undo `packed`; returns numba's result of a compilation."""
    # What numba's caches do first, refresh(), imports all that compiling needs besides: half of a process's start.
    if code.counts:
        rtsys.initialize(context)
    description, environment, signature, object_mode, lifted, annotation, prepare, environments = described
    for each in prepare:
        each()
    library = ObjectCode(context.codegen(), code)
    if library.made:
        library.set_environments([each.env_name for each in environments])
    for_python = description.llvm_cpython_wrapper_name in code.defined  # of what has such a way from the start
    return CompileResult(
        target_context=context,
        typing_context=context.typing_context,
        library=library,
        environment=environment,
        entry_point=context.get_executable(library, description, environment) if for_python else library,
        fndesc=description,
        type_annotation=annotation,
        signature=signature,
        objectmode=object_mode,
        lifted=lifted,
        typing_error=None,
        call_helper=None,
        metadata=None,
        reload_init=prepare,
        referenced_envs=environments,
    )
