"""No module imports, by any way, one that imports it; import-linter holds the floors, this what lies within them."""

from __future__ import annotations

import pytest
from conftest import ROOT
from imports import PACKAGES, circles, graph, imports, modules


@pytest.fixture(scope="module")
def files():
    return modules(ROOT, PACKAGES)


@pytest.mark.slow
@pytest.mark.parametrize("types", [False, True])
def test_no_module_imports_itself_by_way_of_others(files, types):
    assert [" -> ".join(circle) for circle in circles(graph(files, types=types))] == []


def test_import_linter_has_no_exceptions():
    text = (ROOT / "pyproject.toml").read_text()
    assert "ignore_imports" not in text
    assert "exclude_type_checking_imports = false" in text


def test_circles_are_found_wherever_they_hide(tmp_path):
    package = tmp_path / "round"
    package.mkdir()
    late = "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from round.{} import Name\n"
    for name, text in {
        "__init__": late.format("facade"),
        "below": "",
        "top": "import round.below\nfrom round import function",
        "function": "def f():\n    if True:\n        from round.top import g",
        "typed": late.format("back"),
        "back": "from round import typed",
        "facade": "from round import asks",
        "asks": "from round import Name",
    }.items():
        (package / f"{name}.py").write_text(text)
    files = modules(tmp_path, ("round",))
    assert circles(graph(files, types=False)) == [
        ["round.asks", "round.facade", "round.asks"],
        ["round.function", "round.top", "round.function"],
    ]
    assert ["round.back", "round.typed", "round.back"] in circles(graph(files, types=True))


@pytest.mark.slow
def test_names_are_compared_in_one_place(files):
    assert [name for name, file in files.items() if any("difflib" in home for home, _, _ in imports(file))] == [
        "cdpr.base.nearest"
    ]
