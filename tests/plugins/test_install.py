"""Editable installs: with the system's compiler, and by zig where there is none."""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from conftest import ROOT
from offline import ONE_TARGET, has_compiler, pip

pytestmark = pytest.mark.slow
PACKAGES = ("cdpr", "cdpr_backends", "cdpr_controllers", "cdpr_solvers")
BUILD = ("CMakeLists.txt", "LICENSE", "README.md", "build_backend.py", "pyproject.toml")
CROSS = """
import numpy as np
from cdpr.native import library
from cdpr.native.bind import bind

left, right, product = np.eye(3)[:1], np.eye(3)[1:2], np.empty((1, 3))
bind("cross_products", left=left, right=right, product=product)()
print(library.compiler, product[0, 2])
"""


@pytest.fixture
def checkout(tmp_path):
    """A copy of what is installed, to be edited; with one table of kernels, for all of them take minutes to compile."""
    tree = tmp_path / "tree"
    tree.mkdir()
    for name in PACKAGES:
        ignored = shutil.ignore_patterns("__pycache__", "*.so")
        shutil.copytree(ROOT / name, tree / name, ignore=ignored)
    for name in BUILD:
        shutil.copy(ROOT / name, tree / name)
    keep_table(tree / "cdpr" / "native", "mathematics")
    return tree


def keep_table(native, kept):
    """Leave out all tables of kernels but one."""
    listing = (native / "table.cpp").read_text()
    for file in (native / "tables").glob("*.cpp"):
        if file.stem != kept:
            file.unlink()
            listing, lines = re.subn(
                rf"^(extern const cdpr_group |    &){file.stem}[;,]\n", "", listing, flags=re.MULTILINE
            )
            assert lines == 2, file.stem
    (native / "table.cpp").write_text(listing)


def printed(folder, code, **more):
    """Return the output of a new process that runs some code."""
    env = {**os.environ, "PYTHONPATH": str(folder / "needed"), **more}
    words = [folder / "builder" / "bin" / "python", "-c", code]
    done = subprocess.run(words, env=env, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def cross(folder, **more):
    """The compiler, and the last component of x cross y."""
    return printed(folder, CROSS, **more).rsplit(maxsplit=1)


def test_changed_headers_are_compiled_by_the_next_install_and_python_files_take_effect_at_once(checkout, tmp_path):
    if not has_compiler():
        pytest.skip("this system lacks a C++ compiler")
    done = pip(tmp_path, "install", *ONE_TARGET, "--editable", checkout)
    assert done.returncode == 0, done.stdout + done.stderr
    assert cross(tmp_path)[-1] == "1.0"
    header = checkout / "cdpr" / "native" / "include" / "cdpr" / "cross_products.hpp"
    text = header.read_text()
    assert "    return 0;\n" in text
    header.write_text(text.replace("    return 0;\n", "    problem.product[2] *= 3.0;\n    return 0;\n"))
    assert cross(tmp_path)[-1] == "1.0"
    done = pip(tmp_path, "install", *ONE_TARGET, "--editable", checkout)
    assert done.returncode == 0, done.stdout + done.stderr
    assert cross(tmp_path)[-1] == "3.0"
    (checkout / "cdpr" / "more.py").write_text("print('more')\n")
    assert printed(tmp_path, "import cdpr.more") == "more\n"
    include = Path(printed(tmp_path, "import cdpr; print(cdpr.get_include())").strip())
    for header in ("cdpr/mechanics/geometry.hpp", "cdpr/cables/drum/drum.hpp", "cdpr_solvers/closed_form.hpp"):
        assert (include / header).read_text().startswith("//")
    other = tmp_path / "other"
    shutil.copytree(checkout / "cdpr", other / "cdpr")
    (other / "cdpr" / "more.py").write_text("print('other')\n")
    needed = f"{other}{os.pathsep}{tmp_path / 'needed'}"
    assert printed(tmp_path, "import cdpr.more", PYTHONPATH=needed) == "other\n"  # goes before an editable install


def without_compilers(folder):
    """A PATH with what a build by zig needs, and no compiler."""
    folder.mkdir()
    for name in ("cmake", "ninja", "sh", "uname"):
        found = shutil.which(name)
        if found:
            (folder / name).symlink_to(found)
    return str(folder)


def test_an_install_without_a_compiler_compiles_by_zig(checkout, tmp_path):
    if importlib.util.find_spec("ziglang") is None:
        pytest.skip("ziglang is not installed, and tests use no network")
    path, home = without_compilers(tmp_path / "bin"), tmp_path / "home"
    home.mkdir()
    hidden = {"PATH": path, "HOME": str(home), "CC": "", "CXX": ""}
    done = pip(tmp_path, "install", *ONE_TARGET, "--editable", checkout, **hidden)
    assert done.returncode == 0, done.stdout + done.stderr
    compiler, product = cross(tmp_path, **hidden)
    assert compiler.startswith("Clang")
    assert product == "1.0"
    assert (checkout / "build" / "zig-cache").is_dir()
    assert [entry.name for entry in home.rglob("*") if "zig" in entry.name.lower()] == []
    # Nothing is compiled on import: zig is gone where pip isolates builds.
    header = checkout / "cdpr" / "native" / "include" / "cdpr" / "cross_products.hpp"
    header.write_text("#error\n")
    assert cross(tmp_path, **hidden)[-1] == "1.0"
