"""Object code of the kernels: nothing is shared between instruction sets, and nothing is fused or called unasked."""

from __future__ import annotations

import platform
import re

import pytest
from native_compiler import TARGETS, compile_object, kernels, run, tool

# Compiling all kernels six times takes half a minute.
pytestmark = [
    pytest.mark.skipif(platform.machine() != "x86_64", reason="this processor has one instruction set"),
    pytest.mark.slow,
]

# Of the C library; their bits depend on it, not on the instruction set.
CALLS = {"sin", "cos", "sincos", "atan2", "tanh", "hypot", "memcpy", "memset", "memmove", "_GLOBAL_OFFSET_TABLE_"}
# Exact or correctly rounded, so with the same bits everywhere; with optimisation the last two are instructions.
CALLS |= {"frexp", "ldexp", "copysign", "sqrt"}


@pytest.fixture(scope="module", params=[(), ("-O0",)], ids=["as built", "without optimisation"])
def objects(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("objects")
    return {target: kernels(target, folder, *request.param) for target in TARGETS}


def symbols(path):
    """Names and kinds of symbols, by nm's letters."""
    rows = (line.split() for line in run(tool("nm"), path).splitlines())
    return {row[-1]: row[-2] for row in rows}


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


def test_kernels_call_nothing_but_the_c_library(objects):
    for path in objects.values():
        assert {name for name, kind in symbols(path).items() if kind == "U"} - CALLS == set()


def test_no_multiplication_is_fused_with_an_addition(objects):
    for target, path in objects.items():
        code = run(tool("objdump"), "-d", "--no-show-raw-insn", path)
        assert re.search(r"\bv?mulsd\b|\bv?mulpd\b", code), target
        assert re.findall(r"\bvfn?m(?:add|sub)\w+", code) == []


def test_the_search_for_fused_operations_finds_them(tmp_path):
    source = tmp_path / "sum.cpp"
    source.write_text("double sum(double a, double b, double c) { return a * b + c; }")
    assert compile_object(source, "x86_64_v3", tmp_path / "sum.o", "-ffp-contract=fast").returncode == 0
    assert re.search(r"\bvfn?m(?:add|sub)\w+", run(tool("objdump"), "-d", tmp_path / "sum.o"))


def test_wide_registers_are_used_only_where_they_exist(objects):
    for target, path in objects.items():
        code = run(tool("objdump"), "-d", "--no-show-raw-insn", path)
        assert bool(re.search(r"%ymm", code)) <= (target != "x86_64")
        assert bool(re.search(r"%zmm", code)) <= (target == "x86_64_v4")
