"""Tests run on the engines that are installed here, so that they pass without the others."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest
from conftest import ROOT

import cdpr_backends

NAMES = {name for row in cdpr_backends.cdpr_backends() for name in (row.name, *row.aliases)}
ENGINES = {row.name for row in cdpr_backends.cdpr_backends() if row.requires} - {"fmu"}

# Lists of names on which nothing runs.
OTHERS = {
    "analysis/compare/test_compare.py": "the error for a missing one",
    "analysis/study/test_study_plan.py": "labels",
    "sensing/test_camera.py": "renderers",
}


def literal_lists(text: str) -> Iterator[int]:
    """Yield the lines with a list or an iterated tuple of at least two backends, with an engine."""
    if not any(name in text for name in ENGINES):  # many files, to save time
        return
    tree = ast.parse(text)
    iterated = [node.iter for node in ast.walk(tree) if isinstance(node, ast.For | ast.comprehension)]
    for node in [*(each for each in ast.walk(tree) if isinstance(each, ast.List)), *iterated]:
        if isinstance(node, ast.List | ast.Tuple) and len(node.elts) > 1:
            names = [_name(each) for each in node.elts]
            if NAMES.issuperset(names) and ENGINES.intersection(names):
                yield node.lineno


def _name(node: ast.expr) -> object:
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "param":
        node = node.args[0]
    return node.value if isinstance(node, ast.Constant) else None


def test_engines_are_listed_with_installed():
    """Write `installed("mujoco", "bullet")` of tests/support/plants.py."""
    files: list[Path] = sorted((ROOT / "tests").rglob("*.py"))
    found = {str(file.relative_to(ROOT / "tests")): list(literal_lists(file.read_text())) for file in files}
    assert {name: lines for name, lines in found.items() if lines and name not in OTHERS} == {}
    assert all(found[name] for name in OTHERS)


@pytest.mark.parametrize(
    ("text", "lines"),
    [
        ('ENGINES = ["reference", "mujoco"]', [1]),
        ('[pytest.param("bullet", marks=slow), "dart"]', [1]),
        ('for name in ("mujoco", "bullet"): pass', [1]),
        ('installed("mujoco", "bullet")', []),
        ('["--backend", "mujoco"]', []),
        ('["reference", "reference"], "mujoco"', []),
    ],
)
def test_lists_are_found(text, lines):
    assert list(literal_lists(text)) == lines
