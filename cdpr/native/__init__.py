"""Numerical kernels: one C++17 library, called from Python, in exported FMUs and in real-time programs.

`bind.py` binds compiled operations to numpy arrays. Shared headers are in `include/cdpr/`; the kernel of a part is
NAME.hpp beside its Python module. Importing this package loads nothing.
"""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path


def get_include() -> str:
    """Return the folder of the C++ headers, for `#include <cdpr/vector.hpp>` or `<cdpr_solvers/qp.hpp>`.

    Returns:
        The absolute path of the folder.

    Raises:
        ImportError: if cdpr is not installed, so that its kernel library is not built.

    Example:
        >>> from pathlib import Path
        >>> import cdpr
        >>> (Path(cdpr.get_include()) / "cdpr" / "mechanics" / "geometry.hpp").is_file()
        True
    """
    if find_spec("cdpr.native.library") is None:
        raise ImportError("The kernel library is not built; install cdpr, in a checkout by 'pip install --editable .'.")
    return str(Path(__file__).with_name("include"))
