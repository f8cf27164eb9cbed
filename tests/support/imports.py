"""Imports of modules: at the top, within functions, and for type checkers only."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

PACKAGES = ("cdpr", "cdpr_backends", "cdpr_controllers", "cdpr_solvers")
PACKAGE = "__init__.py"

Graph = dict[str, set[str]]


def modules(root: Path, packages: tuple[str, ...]) -> dict[str, Path]:
    """Return the files of all modules below `root`, by name."""
    files = (file for package in packages for file in sorted((root / package).rglob("*.py")))
    return {".".join(file.relative_to(root).with_suffix("").parts).removesuffix(".__init__"): file for file in files}


def graph(files: dict[str, Path], *, types: bool) -> Graph:
    """Return the imports of each module anywhere in it; on request also those of `types` only.

    A name that a package imports for type checkers alone is bound late (`cdpr.base.lazy`): its first use imports the
    module, an import of the package does not.
    """
    late = bound_late(files)
    edges: Graph = {name: set() for name in files}
    for name, file in files.items():
        for home, what, typed in imports(file):
            if typed and (not types or file.name == PACKAGE):
                continue
            if f"{home}.{what}" in files:
                edges[name].add(f"{home}.{what}")
                continue
            edges[name].add(home)
            while (home, what) in late:
                home = late[home, what]
                edges[name].add(home)
    return {name: imported & files.keys() for name, imported in edges.items()}


def bound_late(files: dict[str, Path]) -> dict[tuple[str, str], str]:
    """Return the names that packages bind when they are first used: package and name, and the module where it is."""
    return {
        (name, what): home
        for name, file in files.items()
        if file.name == PACKAGE
        for home, what, typed in imports(file)
        if typed and what and f"{name}.{what}" not in files
    }


@cache
def imports(file: Path) -> list[tuple[str, str, bool]]:
    """Return what a file imports: module, name in it or nothing, and whether only type checkers see it."""
    return list(_imports(ast.parse(file.read_text())))


def _imports(node: ast.AST, typed: bool = False) -> Iterator[tuple[str, str, bool]]:
    """Yield the statements in a node; cdpr has no relative imports."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Import):
            yield from ((alias.name, "", typed) for alias in child.names)
        elif isinstance(child, ast.ImportFrom):
            assert child.module is not None
            assert not child.level
            yield from ((child.module, alias.name, typed) for alias in child.names)
        elif isinstance(child, ast.If) and "TYPE_CHECKING" in ast.unparse(child.test):
            yield from _imports(ast.Module(child.body, []), True)
            yield from _imports(ast.Module(child.orelse, []), typed)
        elif isinstance(child, (ast.stmt, ast.excepthandler, ast.match_case)):  # no expression holds one
            yield from _imports(child, typed)


def circles(edges: Graph) -> list[list[str]]:
    """Return the shortest way from a module back to itself, for each module that has one, each circle once."""
    found: dict[frozenset[str], list[str]] = {}
    for start in sorted(edges):
        ways: dict[str, list[str]] = {start: [start]}
        todo = [start]
        for name in todo:
            if start in edges[name]:
                found.setdefault(frozenset(ways[name]), [*ways[name], start])
                break
            for following in sorted(edges[name] - ways.keys()):
                ways[following] = [*ways[name], following]
                todo.append(following)
    return list(found.values())
