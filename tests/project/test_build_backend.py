"""Build backend: it requires zig only without a compiler."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from conftest import ROOT


@pytest.fixture
def backend(monkeypatch):
    pytest.importorskip("scikit_build_core", reason="scikit-build-core is not installed: see the extra 'test'")
    monkeypatch.syspath_prepend(str(ROOT))
    import build_backend

    for name in ("CC", "CXX", "CDPR_BUILD_ZIG", "ZIG_GLOBAL_CACHE_DIR", "ZIG_LOCAL_CACHE_DIR", "CFLAGS", "CXXFLAGS"):
        monkeypatch.setenv(name, "")
    return build_backend


@pytest.fixture
def path(monkeypatch, tmp_path):
    """Return a function that makes PATH a folder with programs of some names."""

    def make(*names):
        for name in names:
            program = tmp_path / name
            program.write_text("#!/bin/sh\n")
            program.chmod(0o755)
        monkeypatch.setenv("PATH", str(tmp_path))

    return make


COMPILERS = ("cc", "c++")


@pytest.mark.parametrize(
    ("programs", "zig"),
    [
        ((), True),
        (("cc",), True),
        (("gcc",), True),
        (("g++",), True),
        (COMPILERS, False),
        (("gcc", "g++"), False),
        (("clang", "clang++"), False),
    ],
)
def test_zig_is_required_without_a_c_and_a_compiler_for_cpp_and_only_then(backend, path, programs, zig):
    path(*programs)
    assert backend.compiler_requirements() == (["ziglang>=0.13"] if zig else [])


def test_the_variables_of_compilers_count(backend, path, monkeypatch):
    path(*COMPILERS, "mine")
    monkeypatch.setenv("CC", "mine -m64")
    assert backend.compiler_requirements() == []
    monkeypatch.setenv("CXX", "no-such-compiler")
    assert backend.compiler_requirements() != []


def test_zig_can_be_chosen(backend, path, monkeypatch):
    path(*COMPILERS)
    monkeypatch.setenv("CDPR_BUILD_ZIG", "1")
    assert backend.compiler_requirements() != []


def test_without_a_compiler_and_zig_the_build_ends_with_what_to_install(backend, path, monkeypatch):
    path()
    monkeypatch.setattr(backend.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(
        SystemExit, match="no C and C\\+\\+ compiler found; install one, set CC and CXX, or install zig"
    ):
        backend.compiler_settings("editable")


def test_free_threaded_python_is_rejected(backend, monkeypatch):
    monkeypatch.setattr(backend.sysconfig, "get_config_var", lambda name: 1 if name == "Py_GIL_DISABLED" else None)
    with pytest.raises(SystemExit, match="free-threaded Python is not supported"):
        backend.compiler_settings("wheel")


def test_zig_compiles_for_any_processor_and_keeps_its_cache_in_the_build_folder(backend, path, monkeypatch):
    path()
    found = type("Spec", (), {"origin": "/site/ziglang/__init__.py"})
    monkeypatch.setattr(backend.importlib.util, "find_spec", lambda name: found)
    monkeypatch.setattr(backend.platform, "machine", lambda: "x86_64")
    monkeypatch.setattr(sys, "platform", "linux")
    settings = backend.compiler_settings("wheel")
    assert settings["cmake.define.CDPR_ZIG"] == "ON"
    assert Path(backend.os.environ["ZIG_GLOBAL_CACHE_DIR"]) == ROOT / "build" / "zig-cache"
    assert backend.os.environ["CC"] == "/site/ziglang/zig cc -target x86_64-linux-gnu.2.17"
    assert backend.os.environ["CXXFLAGS"] == "-O2 -nostdlib++"
