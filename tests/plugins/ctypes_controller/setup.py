"""Compilation of the kernel, without fused multiply-add: the same bits as in Python."""

from setuptools import Extension, setup

setup(ext_modules=[Extension("cdpr_spring.kernel", ["cdpr_spring/spring.c"], extra_compile_args=["-ffp-contract=off"])])
