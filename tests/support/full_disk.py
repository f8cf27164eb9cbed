"""Full disk, simulated by a limit of the size of files."""

from __future__ import annotations

import resource
import sys
from contextlib import contextmanager


@contextmanager
def file_size_limit(size):
    """Limit the size of all files; no bytecode is written meanwhile, for Python would leave a part of it."""
    before, unwritten = resource.getrlimit(resource.RLIMIT_FSIZE), sys.dont_write_bytecode
    sys.dont_write_bytecode = True
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        sys.dont_write_bytecode = unwritten
