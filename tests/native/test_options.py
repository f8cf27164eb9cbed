"""Compiler options of the kernel library: those of the environment change neither numbers nor instruction sets."""

from __future__ import annotations

import platform
import re
import subprocess

import pytest
from conftest import ROOT
from native_compiler import NATIVE, TARGETS, compile_object, flags, tool

from cdpr.native import library

UNDONE = ["-ffast-math", "-Ofast", "-funsafe-math-optimizations", "-ffast-math -ffp-contract=fast"]
REJECTED = ["-ffinite-math-only", "-fassociative-math -fno-signed-zeros -fno-trapping-math", "-ffast-math"]
LOOSE = ("__FAST_MATH__", "__ASSOCIATIVE_MATH__", "__RECIPROCAL_MATH__", "__NO_SIGNED_ZEROS__")

processor = pytest.mark.skipif(platform.machine() != "x86_64", reason="this processor has one instruction set")


def compiled(folder, text, target, *more):
    (folder / "sample.cpp").write_text(text)
    return compile_object(folder / "sample.cpp", target, folder / "sample.o", *more)


@pytest.mark.parametrize("options", UNDONE)
def test_options_of_the_environment_for_fast_arithmetic_are_undone(options):
    """CMake puts CXXFLAGS first. Where the headers compile, their checks have passed."""
    words = [tool("g++"), "-std=c++17", *options.split(), *flags(), f"-I{NATIVE / 'include'}", "-x", "c++"]
    header = NATIVE / "include" / "cdpr" / "target.hpp"
    subprocess.run([*words, "-fsyntax-only", header], check=True, capture_output=True)
    macros = subprocess.run([*words, "-dM", "-E", header], check=True, capture_output=True, text=True).stdout
    assert "#define __FINITE_MATH_ONLY__ 0" in macros
    assert [name for name in LOOSE if f"#define {name}" in macros] == []


@processor
@pytest.mark.parametrize("options", REJECTED)
def test_truncated_sources_do_not_compile(tmp_path, options):
    done = compiled(tmp_path, "#include <cdpr/number.hpp>", "x86_64", *options.split())
    assert done.returncode != 0
    assert "its kernels need IEEE arithmetic" in done.stderr


@processor
@pytest.mark.parametrize(
    ("target", "option", "fits"),
    [
        *((target, "-O3", True) for target in TARGETS),
        ("x86_64", "-msse3", False),
        ("x86_64", "-mavx", False),
        ("x86_64", "-mavx512f", False),
        ("x86_64_v3", "-mavx512f", False),
        ("x86_64_v4", "-mavx512f", True),
    ],
)
def test_instructions_beyond_the_set_do_not_compile(tmp_path, target, option, fits):
    done = compiled(tmp_path, "#include <cdpr/instruction_set.hpp>", target, option)
    assert (done.returncode == 0) == fits, done.stderr
    assert fits or "instructions beyond the set that is compiled" in done.stderr
    for source in (NATIVE / "table.cpp", NATIVE / "include" / "cdpr" / "group.hpp"):
        assert "#include <cdpr/instruction_set.hpp>" in source.read_text()
    assert all("#include <cdpr/group.hpp>" in source.read_text() for source in (NATIVE / "tables").glob("*.cpp"))


@processor
@pytest.mark.parametrize("source", ["binder.c", "bound.c", "dispatch.cpp"])
def test_the_dispatcher_is_compiled_for_every_processor(tmp_path, source):
    words = [
        tool("g++" if source.endswith("pp") else "gcc"),
        *flags(),
        '-DCDPR_SOURCES=""',
        "-march=x86-64",
        "-fsyntax-only",
    ]
    subprocess.run([*words, NATIVE / source], check=True, capture_output=True)
    done = subprocess.run([*words, "-mavx", NATIVE / source], capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert "must run on every processor" in done.stderr


def symbols(path):
    return subprocess.run([tool("nm"), path], check=True, capture_output=True, text=True).stdout


@pytest.mark.slow
def test_linking_with_fast_arithmetic_leaves_small_numbers_of_the_process_as_they_are(tmp_path):
    """gcc up to 12 adds crtfastmath.o, whose `set_fast_math` is run when the library is loaded."""
    (line,) = re.findall(r"^add_link_options\((-f.*)\)$", (ROOT / "CMakeLists.txt").read_text(), re.MULTILINE)
    source, out = tmp_path / "nothing.c", tmp_path / "nothing.so"
    source.write_text("int nothing(void) { return 0; }")
    subprocess.run([tool("gcc"), "-shared", "-fPIC", "-ffast-math", source, "-o", out, *line.split()], check=True)
    for path in (out, library.__file__):
        assert "set_fast_math" not in symbols(path)
