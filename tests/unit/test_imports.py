"""No module imports, by any way, one that imports it; import-linter holds the floors, this what lies within them."""

from __future__ import annotations

import inspect
from importlib import import_module

import pytest
from conftest import ROOT
from imports import bound_late, circles, graph, imports, modules, reached

from cdpr.model import kernel_cache

# What closes a circle after all, and why.
TYPES = {
    ("cdpr.errors", "cdpr.log.run"): "an error holds the run that it ended, and knows no more of it than that",
}
LOG = {
    ("cdpr.log.run", "cdpr.log.rows"): "rows of a run may lie on disk",
}


@pytest.fixture(scope="module")
def files():
    return modules(ROOT, kernel_cache.PACKAGES)


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


@pytest.fixture(scope="module")
def fingerprint(files):
    """The modules whose text the name of the folder of compiled kernels depends on."""
    names = {file.relative_to(ROOT).as_posix(): module for module, file in files.items()}
    return {names[name] for name in kernel_cache._needed({name: (ROOT / name).read_bytes() for name in names})}


def test_the_fingerprint_of_kernels_holds_what_they_import(files, fingerprint):
    """It is found without parsing, in a few milliseconds: here it is held against the syntax tree.

    What packages bind late is not in it: of that, files with kernels may take classes alone, which no kernel holds.
    """
    late = bound_late(files)
    for module in fingerprint:
        for home, what, typed in imports(files[module]):
            if typed:
                continue
            if (home, what) in late:
                assert inspect.isclass(getattr(import_module(home), what)), (module, home, what)
            assert {home, f"{home}.{what}"} & files.keys() <= fingerprint, module


def test_kernels_are_compiled_anew_for_few_files(fingerprint):
    """Users wait for the compiler whenever one of these changes: nothing that reads, logs or draws is among them."""
    rooms = {name.split(".")[1] for name in fingerprint if name.startswith("cdpr.")}
    assert {"model", "tension"} <= rooms
    assert not rooms & {"log", "report", "scenario", "compare", "study", "bench", "cli", "testing"}


def test_names_are_compared_in_one_place(files):
    assert [name for name, file in files.items() if any("difflib" in home for home, _, _ in imports(file))] == [
        "cdpr.nearest"
    ]
