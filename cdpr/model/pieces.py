"""Compiled kernels as LLVM has them, put together into one piece of machine code that may lie anywhere in memory.

What numba optimised is left as it is, and the machine's instructions are made of it under the same settings but for
where they lie: the answers are the same to the bit.
"""

from __future__ import annotations

import ctypes
import ctypes.util
import sys
from functools import cache
from typing import Any, NamedTuple

import llvmlite.binding as llvm
from llvmlite import ir
from numba.core import config
from numba.core.registry import cpu_target

from cdpr.model import linking
from cdpr.model.kernel_cache import PACKAGES
from cdpr.model.kinds import text
from cdpr.model.numba_calls import read, write
from cdpr.model.numba_kinds import kind_from
from cdpr.model.objects import Needed

FAILED = 1  # what an entry returns where the kernel raises
ENVIRONMENT = "_ZN08NumbaEnv"  # begins the names of what points to objects of Python
WORDS = ir.IntType(64).as_pointer()


class Piece(NamedTuple):
    """One kernel: its name in the code, and the kernels of strangers' packages that it holds or calls."""

    name: str
    foreign: frozenset[Needed]


class Pieces:
    """Kernels, gathered."""

    def __init__(self) -> None:
        self._added: dict[int, Piece | None] = {}
        self._codegen = cpu_target.target_context.codegen()
        self._whole = llvm.parse_assembly(str(self._codegen._create_empty_module("cdpr")))

    def add(self, compiled: Any) -> Piece | None:
        """Add what numba compiled, and what it calls; None where its code needs more than a C library."""
        if id(compiled) not in self._added:
            self._added[id(compiled)] = None
            self._added[id(compiled)] = self._add(compiled)
        return self._added[id(compiled)]

    def add_entry(self, compiled: Any, piece: Piece) -> str:
        """Add what calls a kernel with its arguments as words, and writes what it returns as words; return its name."""
        context, signature = compiled.target_context, compiled.signature
        library = self._codegen.create_library("entry")
        module = library.create_ir_module("entry")
        convention, result, taken = context.call_conv, compiled.fndesc.restype, signature.args
        kernel = ir.Function(module, convention.get_function_type(result, taken), piece.name)
        function = ir.Function(module, ir.FunctionType(ir.IntType(32), [WORDS, WORDS]), f"{piece.name}_entry")
        builder = ir.IRBuilder(function.append_basic_block())
        with context.push_code_library(library):
            arguments = read(context, builder, function.args[0], taken)
            status, answer = convention.call_function(builder, kernel, result, taken, arguments)
            with builder.if_then(status.is_error, likely=False):
                builder.ret(ir.IntType(32)(FAILED))
            write(context, builder, function.args[1], result, answer)
            builder.ret(ir.IntType(32)(0))
        library.add_ir_module(module)
        library._optimize_final_module()
        self._whole.link_in(library._final_module)
        return str(function.name)

    def machine(self) -> bytes:
        """Return an object file."""
        options: dict[str, Any] = {"opt": config.OPT}
        self._codegen._customize_tm_options(options)
        options |= {"reloc": "pic", "codemodel": "default"}
        options.pop("jit", None)
        machine = llvm.Target.from_triple(self._whole.triple).create_target_machine(**options)
        self._whole.verify()
        return bytes(machine.emit_object(self._whole))

    def _add(self, compiled: Any) -> Piece | None:
        name = f"cdpr_kernel_{len(self._added)}"
        module = compiled.library._get_module_for_linking().clone()
        foreign: set[Needed] = set()
        for function in list(module.functions):
            if not function.is_declaration:
                main = function.name == compiled.fndesc.llvm_func_name
                function.linkage = "external" if main else "internal"
                if main:
                    function.name = name
        for variable in list(module.global_variables):
            if not variable.is_declaration:
                variable.linkage = "internal"
        _without_unused(module)
        for function in list(module.functions):
            if function.is_declaration and function.name.startswith(linking.SYMBOL):
                needed, callee = linking.found(function.name)
                piece, other = self.add(callee), _stranger(needed)
                if piece is None or (other is not None and other.key == ""):
                    return None
                foreign |= piece.foreign | ({other} if other else set())
                function.name = piece.name
        names = [each.name for each in module.functions if each.is_declaration]
        variables = [each.name for each in module.global_variables if each.is_declaration or ENVIRONMENT in each.name]
        if variables or not all(map(_of_the_system, names)):
            return None
        self._whole.link_in(module)
        return Piece(name, frozenset(foreign))


def _without_unused(module: Any) -> None:
    """Remove what nothing calls any more: numba's ways for Python to call a kernel."""
    target = llvm.Target.from_triple(module.triple).create_target_machine()
    builder = llvm.create_pass_builder(target, llvm.create_pipeline_tuning_options(speed_level=0))
    passes = llvm.create_new_module_pass_manager()
    passes.add_global_dead_code_eliminate_pass()
    passes.run(module, builder)


def _of_the_system(name: str) -> bool:
    return name.startswith(("llvm.", "cdpr_kernel_")) or hasattr(_mathematics(), name)


@cache
def _mathematics() -> Any:
    return ctypes.CDLL(ctypes.util.find_library("m") or "libm.so.6")


def _stranger(needed: linking.Needed) -> Needed | None:
    """What a kernel was when it was compiled; None of ours, which the folder tells, and without key where none is."""
    if needed.module.partition(".")[0] in PACKAGES:
        return None
    kinds = [kind_from(each) for each in needed.types]
    kernel: Any = getattr(sys.modules.get(needed.module), needed.name, None)
    types = ", ".join("" if kind is None else text(kind) for kind in kinds)
    key = kernel.key_of(types) if hasattr(kernel, "key_of") else None
    return Needed(needed.module, needed.name, types, key or "")
