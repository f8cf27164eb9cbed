"""Declarations of the kernel library: fields against structs, and CPython's stable ABI against Python.h."""

from __future__ import annotations

import re
import subprocess
import sysconfig
from pathlib import Path

import pytest
from native_compiler import NATIVE, compile_object, tool

STRUCT = """
#include <cdpr/entry.hpp>
namespace cdpr::CDPR_TARGET {{
template <class T> struct Sample {{
    {members}
    static constexpr char fields[] = "{fields}";
}};
template <class T> inline int sample(Sample<T>&) {{ return 0; }}
template <class T> inline int timed(Sample<T>&, double) {{ return 0; }}
extern const cdpr_entry entries[2];
const cdpr_entry entries[2] = {{entry<Sample<double>, sample<double>>("sample"),
                                entry<Sample<double>, timed<double>>("timed")}};
}}
"""
MEMBERS = "const T* a; T* b; const int64_t* c; int64_t* d; int64_t n; T x;"
FIELDS = "a(n), b(n, 2), c(1), work d(2*n), n, x >= 0"


def compiled(folder, members, fields):
    source = folder / "sample.cpp"
    source.write_text(STRUCT.format(members=members, fields=fields))
    return compile_object(source, "x86_64", folder / "sample.o", "-Werror")


def test_fields_that_match_their_struct_compile(tmp_path):
    done = compiled(tmp_path, MEMBERS, FIELDS)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("const T* a", "T a"),
        ("T* b", "float* b"),
        ("int64_t n", "T* n"),
        ("T x;", "T* x;"),
        ("T x;", "int x;"),
        ("T x;", ""),
        ("T x;", "T x, y;"),
        ("int64_t* d; int64_t n;", "int64_t n; int64_t* d;"),
    ],
)
def test_fields_that_differ_from_their_struct_do_not_compile(tmp_path, old, new):
    assert old in MEMBERS
    done = compiled(tmp_path, MEMBERS.replace(old, new), FIELDS)
    assert done.returncode != 0
    assert "sample.cpp" in done.stderr or "entry.hpp" in done.stderr


LAYOUTS = """
#include <stddef.h>
#include <stdio.h>
{header}
int main(void) {{
    {lines}
    return 0;
}}
"""
SIZES = {
    "PyMethodDef": ["ml_name", "ml_meth", "ml_flags", "ml_doc"],
    "PyMemberDef": ["name", "type", "offset", "flags", "doc"],
    "PyType_Slot": ["slot", "pfunc"],
    "PyType_Spec": ["name", "basicsize", "itemsize", "flags", "slots"],
    "PyModuleDef_Slot": ["slot", "value"],
    "PyModuleDef": ["m_base", "m_name", "m_doc", "m_size", "m_methods", "m_slots", "m_traverse", "m_clear", "m_free"],
    "PyObject": ["ob_refcnt", "ob_type"],
}
NUMBERS = ["METH_NOARGS", "T_OBJECT_EX", "T_ULONGLONG", "READONLY", "Py_TPFLAGS_DEFAULT", "Py_mod_exec"]
NUMBERS += ["Py_tp_call", "Py_tp_dealloc", "Py_tp_doc", "Py_tp_new", "Py_tp_members"]


THEIRS = "#define Py_LIMITED_API 0x030b0000\n#include <Python.h>\n#include <structmember.h>"


def layouts(folder, header, *more):
    """Offsets, sizes and constants that a compiler sees with a header."""
    lines = [f'printf("{name} %zu\\n", sizeof({name}));' for name in SIZES]
    lines += [f'printf("{n}.{m} %zu\\n", offsetof({n}, {m}));' for n, members in SIZES.items() for m in members]
    lines += [f'printf("{name} %ld\\n", (long){name});' for name in NUMBERS]
    source = folder / "layouts.c"
    source.write_text(LAYOUTS.format(header=header, lines="\n    ".join(lines)))
    subprocess.run([tool("gcc"), *more, source, "-o", folder / "layouts"], check=True, capture_output=True)
    return subprocess.run([folder / "layouts"], check=True, capture_output=True, text=True).stdout


def python_include():
    include = Path(sysconfig.get_path("include"))
    if not (include / "Python.h").exists():
        pytest.skip("Python.h is not installed")
    return include


def test_the_stable_abi_is_that_of_python_h(tmp_path):
    expected = layouts(tmp_path, THEIRS, f"-I{python_include()}")
    assert layouts(tmp_path, '#include "stable_abi.h"', f"-I{NATIVE}") == expected


def declared_after_python_h(folder, ours):
    """Return the compiler's messages for our declarations after those of Python.h."""
    (folder / "ours.h").write_text(ours)
    (folder / "both.c").write_text(f'{THEIRS}\n#include "ours.h"\n')
    words = [tool("gcc"), "-Wall", "-Wextra", "-Werror", f"-I{python_include()}", "-fsyntax-only", folder / "both.c"]
    return subprocess.run(words, capture_output=True, text=True, check=False)


def test_functions_are_declared_as_in_python_h(tmp_path):
    done = declared_after_python_h(tmp_path, (NATIVE / "stable_abi.h").read_text())
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("PyLong_FromLong(long)", "PyLong_FromLong(int)"),
        ("double PyFloat_AsDouble", "float PyFloat_AsDouble"),
        ("PyTuple_New(Py_ssize_t)", "PyTuple_New(int)"),
        ("*PyExc_TypeError", "**PyExc_TypeError"),
    ],
)
def test_a_declaration_that_differs_from_python_h_does_not_compile(tmp_path, old, new):
    ours = (NATIVE / "stable_abi.h").read_text()
    assert old in ours
    done = declared_after_python_h(tmp_path, ours.replace(old, new))
    assert done.returncode != 0
    assert "conflicting types" in done.stderr


def test_no_more_is_declared_than_is_called(tmp_path):
    """And both sources compile with Python.h in place of ours."""
    words = [
        tool("gcc"),
        "-DCDPR_WITH_PYTHON_H",
        '-DCDPR_SOURCES=""',
        "-Wall",
        "-Wextra",
        "-Werror",
        "-fPIC",
        f"-I{python_include()}",
    ]
    sources = [NATIVE / "binder.c", NATIVE / "bound.c"]
    subprocess.run([*words, "-c", *sources], cwd=tmp_path, check=True, capture_output=True)
    declared = set(re.findall(r"\b(Py\w+)\(", (NATIVE / "stable_abi.h").read_text())) - {"Py_TYPE"}
    assert len(declared) > 20
    assert declared - set(re.findall(r"\bPy\w+", "".join(map(Path.read_text, sources)))) == set()
