"""The headers of `cdpr.get_include()`, and whether the kernel library has been compiled from them."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT
from docs_cases import PAGES
from native_compiler import NATIVE, tool

import cdpr
from cdpr.native import library

MINE = """
{includes}
#include <stdio.h>
int main() {{ printf("%g\\n", cdpr::larger(1.5, 2.5)); }}
"""


def test_the_library_is_not_older_than_its_sources():
    kinds = ("*.c", "*.cpp", "*.h", "*.hpp")
    sources = [path for kind in kinds for path in (*NATIVE.rglob(kind), *ROOT.glob(f"cdpr_*/{kind}"))]
    sources += [ROOT / "CMakeLists.txt", *(ROOT / "cdpr" / "cables").rglob("*.hpp")]
    built = Path(library.__file__).stat().st_mtime
    newer = [path.relative_to(ROOT).as_posix() for path in sources if path.stat().st_mtime > built]
    assert newer == [], "changed since it was compiled: run 'pip install --no-deps --editable .'"


@pytest.mark.slow
def test_a_reader_s_program_needs_one_folder_and_the_options_of_the_docs(tmp_path):
    tool("g++")
    include = Path(cdpr.get_include())
    headers = sorted(path.relative_to(include).as_posix() for path in include.rglob("*.hpp"))
    assert {"cdpr/geometry.hpp", "cdpr/cables/drum/drum.hpp", "cdpr_solvers/closed_form.hpp"} <= set(headers)
    text = MINE.format(includes="\n".join(f"#include <{header}>" for header in headers))
    (tmp_path / "mine.cpp").write_text(text)
    (command,) = re.findall(r"^\$ (g\+\+ .*)$", PAGES["docs/kernels.md"], re.MULTILINE)
    subprocess.run(command.replace("python", sys.executable), shell=True, cwd=tmp_path, check=True)
    assert subprocess.check_output(tmp_path / "a.out", text=True) == "2.5\n"
