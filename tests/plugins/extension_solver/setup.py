"""Compilation of the extension with cdpr's headers."""

from setuptools import Extension, setup

import cdpr

kernel = Extension(
    "cdpr_least_norm.kernel",
    ["cdpr_least_norm/kernel.cpp"],
    include_dirs=[cdpr.get_include()],
    extra_compile_args=["-std=c++17", "-ffp-contract=off"],
    py_limited_api=True,
)
setup(ext_modules=[kernel])
