"""Bound operations of bound.c, with a table of its own, whose only kernel notes what it gets."""

from __future__ import annotations

import ctypes
import struct
import subprocess
import sys
from importlib.machinery import ExtensionFileLoader
from importlib.util import module_from_spec, spec_from_file_location

import numpy as np
import pytest
from native_compiler import NATIVE, tool

from cdpr.native import library
from cdpr.native.operations import operations

RECORDER = """
#include "dispatch.h"
typedef struct { double *answer; double gain; } Problem;
static int record(void *place, double time) {
    Problem *problem = place;
    problem->answer[0] = time;
    problem->answer[1] = problem->gain;
    return 7;
}
static const char *const types[] = {"double*", "double"};
static const cdpr_entry entries[] = {{"recorder", record, 2, "answer(2), gain", types}};
static const cdpr_group group = {entries, 1};
static const cdpr_group *const groups[] = {&group};
static const cdpr_table table = {"portable", groups, 1};
int cdpr_tables(const cdpr_table *tables[CDPR_TARGETS]) { tables[0] = &table; return 1; }
"""
FUNCTION = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_double)


@pytest.fixture(scope="module")
def recorder(tmp_path_factory):
    """The module of binder.c with that table."""
    folder = tmp_path_factory.mktemp("recorder")
    (folder / "recorder.c").write_text(RECORDER)
    words = [
        tool("gcc"),
        "-shared",
        "-fPIC",
        "-Wall",
        "-Wextra",
        "-Werror",
        "-DCDPR_ONE_TARGET",
        f"-I{NATIVE}",
    ]
    sources = [NATIVE / "binder.c", NATIVE / "bound.c", folder / "recorder.c"]
    path = str(folder / "library.abi3.so")
    subprocess.run([*words, *sources, "-o", path], check=True, capture_output=True)
    spec = spec_from_file_location("recorder.library", path, loader=ExtensionFileLoader("recorder.library", path))
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def bound(recorder, answer):
    ((_, ((_, address, *_),)),) = recorder.tables()
    words = struct.pack("=qd", answer.ctypes.data, 0.5)
    return recorder.Bound(address, words, {}, (answer,))


def test_the_kernel_gets_its_struct_and_the_time(recorder):
    call = bound(recorder, answer := np.zeros(2))
    assert (call(), answer.tolist()) == (7, [0.0, 0.5])
    assert (call(1.25), answer.tolist()) == (7, [1.25, 0.5])


def test_a_call_without_the_lock_is_the_same(recorder):
    call = bound(recorder, answer := np.zeros(2))
    assert (call.unlocked(), answer.tolist()) == (7, [0.0, 0.5])
    assert (call.unlocked(1.25), answer.tolist()) == (7, [1.25, 0.5])
    with pytest.raises(TypeError, match="takes at most the time"):
        call.unlocked(1.0, 2.0)
    with pytest.raises(TypeError):
        call.unlocked("now")


def test_bound_operations_report_their_arrays(recorder):
    call = bound(recorder, answer := np.zeros(2))
    assert (call.name, call.given, call.arrays) == ("recorder", {}, (answer,))
    assert call.words == struct.pack("=qd", answer.ctypes.data, 0.5)


def test_the_addresses_are_those_that_a_compiled_pipeline_calls(recorder):
    call = bound(recorder, answer := np.zeros(2))
    assert (FUNCTION(call.operation)(call.place, 2.0), answer.tolist()) == (7, [2.0, 0.5])


def test_tables_are_those_that_are_declared(recorder):
    ((target, ((name, _, fields, types),)),) = recorder.tables()
    assert (target, name) == ("portable", "recorder")
    assert (fields, types) == ("answer(2), gain", ("double*", "double"))


@pytest.mark.parametrize("address", [0, 8, 2**64 - 1, id(None)], ids=["none", "low", "high", "Python's"])
def test_an_address_that_is_no_operation_of_the_library_is_an_error(address):
    with pytest.raises(ValueError, match="no operation of this library has that address"):
        library.Bound(address, b"", {}, ())


@pytest.mark.parametrize("change", [-32, -1, 1, 8])
def test_a_struct_of_another_size_is_an_error(change):
    operation = operations()["cross_products"]
    with pytest.raises(ValueError, match="has another size"):
        library.Bound(operation.address, bytes(struct.calcsize(operation.layout) + change), {}, ())


def test_a_bound_operation_is_made_without_keywords():
    operation = operations()["cross_products"]
    words = bytes(struct.calcsize(operation.layout))
    with pytest.raises(TypeError, match="takes no keywords"):
        library.Bound(operation.address, words, {}, (), nothing=1)


MOST = 400  # allocations, one of which fails at a time: some tables, their rows and texts


def test_lack_of_memory_is_an_error_each_time():
    pytest.importorskip("_testcapi")
    operation = operations()["cross_products"]
    size = struct.calcsize(operation.layout)
    text = """
import _testcapi
from cdpr.native import library
from cdpr.native.operations import operations

def bound():
    return library.Bound(operation.address, words, {}, ())

operation = operations()["cross_products"]
words = bytes(SIZE)
expected = library.tables()
failed = 0
for function in (library.tables, bound):
    for start in range(1, MOST):
        _testcapi.set_nomemory(start, start + 1)
        try:
            found = function()
        except MemoryError:
            failed += 1
        else:
            assert function is bound or found == expected
        finally:
            _testcapi.remove_mem_hooks()
print(failed)
""".replace("SIZE", str(size)).replace("MOST", str(MOST))
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 100


@pytest.mark.parametrize("size", [0, 12])
def test_no_address_is_written_beyond_the_struct(size):
    about = bytes([0, 0, size // 8, 1])  # an array of doubles, read, the last in the struct, with one dimension
    given = about, struct.pack("q", 3), (np.zeros(3),)
    assert library.fill(np.ndarray, bytes(size), *given) is None
    assert library.fill(np.ndarray, bytes(size // 8 * 8 + 8), *given) is not None
