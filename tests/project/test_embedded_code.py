"""Code in strings of tests, which no type checker reads: the names that it imports exist."""

from __future__ import annotations

import ast
import importlib
import textwrap

import pytest
from conftest import ROOT

PACKAGES = ("cdpr", "cdpr_backends", "cdpr_controllers", "cdpr_solvers")
FOLDERS = ("tests", "benchmarks", "examples", "docs")
FEWEST = 50  # strings with imports of cdpr; there are about a hundred
ADDED = {  # modules that the tests themselves add
    "cdpr.more",
    "cdpr.cables.geared",
    "cdpr.cables.heavy",
    "cdpr.cables.lagged",
    "cdpr.cables.ring",
    "cdpr.cables.spring",
    "cdpr.scenario.events.gust",
    "cdpr.scenario.motions.rise",
}


def embedded():
    """Yield file and syntax tree of each string that is Python and imports something of cdpr."""
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*.py")):
            for node in ast.walk(ast.parse(path.read_text())):
                if isinstance(node, ast.Constant) and isinstance(node.value, str) and "import" in node.value:
                    try:
                        tree = ast.parse(textwrap.dedent(node.value))
                    except (SyntaxError, ValueError):
                        continue  # a template, or text
                    if any(imported(tree)):
                        yield f"{path.relative_to(ROOT)}:{node.lineno}", tree


def imported(tree):
    """Yield module and name (or None) of each import from cdpr."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and not node.level and str(node.module).split(".")[0].startswith("cdpr"):
            yield from ((node.module, name.name) for name in node.names)
        elif isinstance(node, ast.Import):
            yield from ((name.name, None) for name in node.names if name.name.split(".")[0].startswith("cdpr"))


def missing(tree):
    """Return the imports of a string that fail although their package is one of cdpr's."""
    found = []
    for module, name in imported(tree):
        try:
            value = importlib.import_module(module)
            if name is not None and not hasattr(value, name):
                importlib.import_module(f"{module}.{name}")
        except ModuleNotFoundError:
            if module not in ADDED and module.split(".")[0] in PACKAGES:
                found.append(f"{module}: {name}")
    return found


@pytest.mark.slow
def test_the_names_imported_in_strings_exist():
    strings = list(embedded())
    assert len(strings) > FEWEST
    faults = {place: names for place, tree in strings if (names := missing(tree))}
    assert faults == {}


@pytest.mark.parametrize("line", ["from cdpr.ui.gui.broadcast import " + "Board", "import " + "cdpr.nothing"])
def test_a_name_that_does_not_exist_is_found(line):
    assert missing(ast.parse(line))
