"""No module imports, by any way, one that imports it; import-linter holds the floors, this what lies within them."""

from __future__ import annotations

import pytest
from conftest import ROOT
from imports import PACKAGES, circles, graph, imports, modules, reached

# What closes a circle after all, and why.
TYPES = {
    ("cdpr.errors", "cdpr.log.run"): "an error holds the run that it ended, and knows no more of it than that",
}
LOG = {
    ("cdpr.log.run", "cdpr.log.rows"): "rows of a run may lie on disk",
}


@pytest.fixture(scope="module")
def files():
    return modules(ROOT, PACKAGES)


@pytest.mark.parametrize("types", [False, True])
def test_no_module_imports_itself_by_way_of_others(files, types):
    edges = graph(files, types=types)
    for importer, imported in TYPES | LOG:
        edges[importer].discard(imported)
    assert [" -> ".join(circle) for circle in circles(edges)] == []


def test_import_linter_has_no_exceptions():
    assert "ignore_imports" not in (ROOT / "pyproject.toml").read_text()


def test_what_is_excepted_is_still_there(files):
    """Who mends one of them takes it off the list."""
    edges = graph(files, types=True)
    gone = [pair for pair in TYPES | LOG if pair[1] not in edges[pair[0]] or pair[0] not in reached(edges, {pair[1]})]
    assert not gone


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


def test_names_are_compared_in_one_place(files):
    assert [name for name, file in files.items() if any("difflib" in home for home, _, _ in imports(file))] == [
        "cdpr.nearest"
    ]
