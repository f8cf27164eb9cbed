"""How compiled kernels call each other without being made of each other.

numba copies each kernel that another calls into it and optimises the whole anew: sound for the algebra of vectors,
which melts into its callers, but of a large kernel that many call there is then a copy in each, compiled each time.
Such a kernel is called apart instead: its code where it is, with numba's own convention for calls. The code of the
caller holds but a name, its symbol, for which the linker must know an address before it sees that code.

A symbol is the name under which the kernel is kept on disk: other sources, types or machines have others. What is kept
of a caller tells which it needs, so that they are there first (`KernelStore`).
"""

from __future__ import annotations

import copy
import sys
from typing import Any, NamedTuple

import llvmlite.binding as llvm

SYMBOL = "cdpr:"  # begins the symbols; the names of functions have no colon


class Needed(NamedTuple):
    """A compiled kernel that the code of another one calls: where it is found, and for which types."""

    symbol: str
    module: str
    name: str
    types: tuple[Any, ...]


_linked: dict[str, tuple[Needed, Any]] = {}  # by symbol, with what numba compiled: its code must stay in memory


def call_apart(context: Any, dispatcher: Any, compiled: Any, symbol: str) -> None:
    """Let callers that are compiled from now on call `compiled`, one version of a dispatcher's, by its symbol."""
    name, function = compiled.fndesc.llvm_func_name, dispatcher.py_func
    llvm.add_symbol(symbol, compiled.library.get_pointer_to_function(name))
    _linked[symbol] = Needed(symbol, function.__module__, function.__qualname__, compiled.signature.args), compiled
    declared = copy.copy(compiled.fndesc)
    declared.mangled_name = symbol
    context.remove_user_function(compiled.entry_point)
    context.insert_user_function(compiled.entry_point, declared, ())  # no library: nothing to copy


def needed_by(library: Any) -> list[Needed]:
    """Return what compiled code calls by symbol, be it by way of a kernel whose copy it holds."""
    names = (each.name for each in library._final_module.functions if each.is_declaration)
    return [_linked[name][0] for name in names if name.startswith(SYMBOL)]


def found(symbol: str) -> tuple[Needed, Any]:
    """Return what stands behind a symbol: where it is found, and what numba compiled."""
    return _linked[symbol]


def link(needed: Needed) -> bool:
    """Have a kernel loaded, or compiled; return whether its symbol has an address: not so where it has changed."""
    if needed.symbol not in _linked:
        dispatcher: Any = getattr(sys.modules.get(needed.module), needed.name, None)
        if hasattr(dispatcher, "compile"):
            dispatcher.compile(needed.types)
    return needed.symbol in _linked
