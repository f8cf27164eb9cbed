"""The headers of `cdpr.get_include()`, and whether the kernel library has been compiled from them."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from docs_cases import PAGES
from native_compiler import tool

import cdpr
from cdpr.native import library
from cdpr.native.entries import entry_of
from cdpr.native.operations import operations
from cdpr.native.sources import digest

MINE = """
{includes}
#include <stdio.h>
int main() {{ printf("%g\\n", cdpr::larger(1.5, 2.5)); }}
"""


def test_the_library_is_compiled_from_these_sources():
    assert library.sources == digest(), "changed since: run 'pip install --no-deps --editable .'"


def test_every_source_counts(tmp_path):
    names = (
        "CMakeLists.txt",
        "cdpr/native/tables/cables.cpp",
        "cdpr/native/include/cdpr/sum.hpp",
        "cdpr_solvers/mine.hpp",
    )
    for name in names:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("")
    seen = {digest(tmp_path)}
    for name in names:
        (tmp_path / name).write_text("// changed")
        seen.add(digest(tmp_path))
    assert len(seen) == 1 + len(names)
    (tmp_path / "CMakeLists.txt").unlink()
    assert digest(tmp_path) is None


@pytest.mark.slow
def test_a_compiler_without_vector_types_compiles_all_but_batches(tmp_path):
    """As for an FMU: the kernels for doubles, without extensions of g++."""
    names = {entry_of(name).header for name in operations() if not name.endswith("_lanes")}
    headers = sorted(
        name for name in names if not name.startswith(("cdpr/analysis/workspace/", "cdpr/analysis/rollouts/"))
    )
    assert {"cdpr/mechanics/geometry.hpp", "cdpr_solvers/qp.hpp"} <= set(headers)
    (tmp_path / "mine.cpp").write_text("".join(f"#include <{header}>\n" for header in headers))
    options = ["-std=c++17", "-DCDPR_PLAIN", "-Wall", "-Wextra", "-Wpedantic", "-Werror", f"-I{cdpr.get_include()}"]
    subprocess.run([tool("g++"), *options, "-fsyntax-only", "mine.cpp"], cwd=tmp_path, check=True)


@pytest.mark.slow
def test_a_reader_s_program_needs_one_folder_and_the_options_of_the_docs(tmp_path):
    tool("g++")
    include = Path(cdpr.get_include())
    headers = sorted(path.relative_to(include).as_posix() for path in include.rglob("*.hpp"))
    assert {"cdpr/mechanics/geometry.hpp", "cdpr/cables/drum/drum.hpp", "cdpr_solvers/closed_form.hpp"} <= set(headers)
    text = MINE.format(includes="\n".join(f"#include <{header}>" for header in headers))
    (tmp_path / "mine.cpp").write_text(text)
    (command,) = re.findall(r"^\$ (g\+\+ .*)$", PAGES["docs/kernels.md"], re.MULTILINE)
    subprocess.run(command.replace("python", sys.executable), shell=True, cwd=tmp_path, check=True)
    assert subprocess.check_output(tmp_path / "a.out", text=True) == "2.5\n"
