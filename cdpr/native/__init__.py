"""Numerical kernels: one C++17 library, called from Python, in exported FMUs and in real-time programs.

`bind.py` binds compiled operations to numpy arrays; `include/cdpr/` holds the headers, and the kernel of a part is
NAME.hpp beside its Python module. Importing this package loads nothing.
"""
