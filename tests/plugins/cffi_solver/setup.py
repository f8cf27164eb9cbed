"""Compilation of the kernel by cffi."""

from setuptools import setup

setup(cffi_modules=["build_kernel.py:ffi"])
