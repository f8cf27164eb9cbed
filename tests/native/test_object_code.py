"""Object code of the kernels: nothing is shared between instruction sets, and nothing is fused or called unasked."""

from __future__ import annotations

import platform
import re

import pytest
from native_compiler import TARGETS, compile_object, kernels, run, tool

from cdpr.native import library

# Without optimisation two instruction sets compile in 20 s.
pytestmark = [
    pytest.mark.skipif(platform.machine() != "x86_64", reason="this processor has one instruction set"),
    pytest.mark.slow,
]

# Of the C library; their bits depend on it, not on the instruction set.
CALLS = {
    "sin",
    "cos",
    "sincos",
    "atan2",
    "tanh",
    "exp",
    "hypot",
    "cosh",
    "expm1",
    "log",
    "log1p",
    "cbrt",
    "memcpy",
    "memset",
    "memmove",
    "_GLOBAL_OFFSET_TABLE_",
}
# Exact or correctly rounded, so with the same bits everywhere; with optimisation the last two are instructions.
CALLS |= {"frexp", "ldexp", "copysign", "sqrt"}
BINDER_CALLS = {"memcmp", "strchr", "strcmp", "strncmp"}


@pytest.fixture(scope="module")
def objects(tmp_path_factory):
    """Object files by instruction set, without optimisation: no function is hidden from the tests by inlining."""
    folder = tmp_path_factory.mktemp("objects")
    return {target: kernels(target, folder, "-O0") for target in ("x86_64", "x86_64_v4")}


@pytest.fixture(scope="module")
def code():
    """Disassembly of the installed library by instruction set."""
    found = {target: [] for target in TARGETS}
    text = disassembled(library.__file__)
    for function in re.split(r"\n\n(?=[0-9a-f]+ <)", text):
        name = re.match(r"[0-9a-f]+ <([^>]*)>", function)
        for target in TARGETS:
            if name and f"{len(target)}{target}" in name[1]:
                found[target].append(function)
    if "8portable" in text:
        pytest.skip("the library is built for one instruction set")
    assert all(found.values())
    return {target: "\n".join(functions) for target, functions in found.items()}


def disassembled(path):
    return run(tool("objdump"), "-d", "--no-show-raw-insn", path)


def symbols(path):
    """Names and kinds of symbols, by nm's letters."""
    rows = (line.split() for line in run(tool("nm"), path).splitlines())
    return {row[-1].split("@")[0]: row[-2] for row in rows if len(row) > 1}


def test_no_symbol_is_shared_between_instruction_sets(objects):
    """The linker keeps one of several weak functions of a name: it might be one that this processor cannot run."""
    found = {
        target: {name for name, kind in symbols(path).items() if kind in "WVuTDBR"} for target, path in objects.items()
    }
    assert all(found.values())
    for target, names in found.items():
        assert [name for name in names if target not in name] == []
        # Longer names of targets begin with the shorter one's, so their mangled lengths are compared, too.
        assert [name for name in names if f"{len(target)}{target}" not in name] == []
    assert not set.intersection(*found.values())


def test_no_installed_function_lacks_its_instruction_set():
    names = [name for name, kind in symbols(library.__file__).items() if kind in "tTW" and name.startswith("_Z")]
    assert len(names) > 500
    assert [name for name in names if not any(f"{len(target)}{target}" in name for target in TARGETS)] == []


def test_kernels_call_nothing_but_the_c_library(objects):
    for path in objects.values():
        assert {name for name, kind in symbols(path).items() if kind == "U"} - CALLS == set()


def test_the_installed_library_calls_nothing_but_python_and_the_c_library():
    used = {name for name, kind in symbols(library.__file__).items() if kind == "U"}
    assert {name for name in used if not re.match("_?Py", name)} - CALLS - BINDER_CALLS == set()


def test_no_multiplication_is_fused_with_an_addition(objects, code):
    unoptimised = {
        f"{target} -O0": run(tool("objdump"), "-d", "--no-show-raw-insn", path) for target, path in objects.items()
    }
    for target, text in (code | unoptimised).items():
        assert re.search(r"\bv?mulsd\b|\bv?mulpd\b", text), target
        assert re.findall(r"\bvfn?m(?:add|sub)\w+", text) == []


def test_the_search_for_fused_operations_finds_them(tmp_path):
    source = tmp_path / "sum.cpp"
    source.write_text("double sum(double a, double b, double c) { return a * b + c; }")
    assert compile_object(source, "x86_64_v3", tmp_path / "sum.o", "-ffp-contract=fast").returncode == 0
    assert re.search(r"\bvfn?m(?:add|sub)\w+", run(tool("objdump"), "-d", tmp_path / "sum.o"))


def test_wide_registers_are_used_only_where_they_exist(code):
    for target, text in code.items():
        assert bool(re.search(r"%ymm", text)) == (target != "x86_64")
        assert bool(re.search(r"%zmm", text)) <= (target == "x86_64_v4")
