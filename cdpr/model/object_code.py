"""Compiled code as it lies on disk: ready to run, and not asked for more than that until somebody compiles with it.

numba reads a cached function back as two things: the machine's code, and the code of LLVM of which other functions
could be made. The second costs most of the time and is nearly never needed, so here it is read when it is. The first
goes to the linker as it is.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import llvmlite.binding as llvm
from numba.core.codegen import CodeLibrary, JITCodeLibrary
from numba.core.compiler import CompileResult
from numba.core.runtime import rtsys

ANNOTATION = 5  # the place of what numba found of each line, for people: half of what it keeps


class Code(NamedTuple):
    """What one compiled function is made of.

    Attributes:
        name: of numba's library.
        machine: an object file.
        bitcode: LLVM's code.
        defined: the names of the functions and variables in it.
        counts: whether it calls what counts references.
    """

    name: str
    machine: bytes
    bitcode: bytes
    defined: tuple[str, ...]
    counts: bool


class ObjectCode(JITCodeLibrary):  # type: ignore[misc]
    """numba's library of code from disk."""

    def __init__(self, codegen: Any, code: Code) -> None:
        CodeLibrary.__init__(self, codegen, code.name)  # no more: that makes a module to compile into
        self._code, self._shared_module = code, None
        self._disable_inspection = self._finalized = True
        engine = codegen._engine
        engine._ee.add_object_file(llvm.ObjectFileRef.from_data(code.machine))
        engine.finalize_object()
        engine._defined_symbols.update(code.defined)

    def _get_module_for_linking(self) -> Any:
        if self._shared_module is None:
            self._shared_module = llvm.parse_bitcode(self._code.bitcode)
        return self._shared_module


def packed(compiled: Any) -> tuple[Any, ...]:
    """Return what a compiled function is made of, to be kept."""
    (name, _, (machine, bitcode)), *described = compiled._reduce()
    described[ANNOTATION] = ""
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
    for each in environments:
        library.codegen.set_env(each.env_name, each)
    return CompileResult(
        target_context=context,
        typing_context=context.typing_context,
        library=library,
        environment=environment,
        entry_point=context.get_executable(library, description, environment),
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
