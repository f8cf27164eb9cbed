"""How compiled kernels are kept on disk: one file each, named by all that its content depends on.

numba's own cache names the folder of the source, so that every other checkout compiles all kernels anew. It also keeps
an index beside the data: of two processes that save different signatures at once, one may then load the other's, and a
damaged file ends the program. Here a file is either whole or not there, and depends on no folder.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import pickle
import sys
import tempfile
from collections.abc import Callable
from typing import Any

import llvmlite
import numba
from numba.core.caching import _Cache
from numba.core.registry import cpu_target
from numba.core.serialize import dumps

from cdpr.model import kernel_cache, linking, object_code

CHECKSUM = hashlib.sha256().digest_size  # bytes at the start of each file


class KernelStore(_Cache):  # type: ignore[misc]
    """The compiled signatures of one function, as numba's dispatcher asks for them.

    `sources` is a fingerprint of the sources that the function is made of, beside ours. Of what is made anew for each
    `kind`, that stands for all that it refers to in the function that makes it.

    Attributes:
        cache_path: the folder, for numba's statistics.
    """

    cache_path = None

    def __init__(self, function: Callable[..., Any], sources: str, kind: str | None = None) -> None:
        self.cache_path = str(kernel_cache.kept())
        self._name = f"{function.__module__}.{function.__qualname__}"
        cells = () if kind is not None else tuple(cell.cell_contents for cell in function.__closure__ or ())
        code = function.__code__
        self._version = (
            (numba.__version__, llvmlite.__version__, sys.implementation.cache_tag),
            (self._name, code.co_firstlineno, code.co_code, dumps(cells) if cells else b""),
            sources,
            *([] if kind is None else [kind]),
        )

    def load_overload(self, sig: object, target_context: Any) -> Any:
        """Return the compiled function, or None where it is not there or not whole."""
        content = kernel_cache.read(self.key(sig))
        if content is None:
            return None
        checksum, payload = content[:CHECKSUM], content[CHECKSUM:]
        if hashlib.sha256(payload).digest() != checksum:
            kernel_cache.warn_rebuilt(f"{kernel_cache.kept() / self.key(sig)} is damaged")
            return None
        needed, kernel = pickle.loads(payload)
        if not all(map(linking.link, needed)):  # before its code is seen: without an address, that ends the process
            return None
        return object_code.unpacked(target_context, *kernel)

    def save_overload(self, sig: object, data: Any) -> None:
        """Keep a compiled function; where that fails, such as on a full disk, it is compiled again next time."""
        if data.lifted or data.library.has_dynamic_globals:  # pointers of this process
            return
        payload = dumps((linking.needed_by(data.library), object_code.packed(data)))
        target = kernel_cache.kept() / self.key(sig)
        part = None
        try:
            with tempfile.NamedTemporaryFile(dir=target.parent, delete=False) as file:
                part = file.name
                file.write(hashlib.sha256(payload).digest() + payload)
            os.replace(part, target)
        except OSError:
            if part is not None:
                with contextlib.suppress(OSError):
                    os.unlink(part)

    def enable(self) -> None:
        """Do nothing: it is always on."""

    def disable(self) -> None:
        """Do nothing, likewise."""

    def flush(self) -> None:
        """Do nothing: what is compiled anew replaces what is there."""

    def key(self, sig: object) -> str:
        """Return what a signature's code is called: the name of its file, and the one by which kernels call it."""
        magic = cpu_target.target_context.codegen().magic_tuple()
        key = hashlib.sha256(repr((self._version, str(sig), magic)).encode()).hexdigest()
        return f"{self._name.replace('<', '').replace('>', '')[:120]}-{key[:32]}"
