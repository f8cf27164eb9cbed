"""Plain English: first words of docstrings, comments and headings; avoided words in docstrings, texts and docs."""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest
from conftest import ROOT

PACKAGES = ("cdpr", "cdpr_backends", "cdpr_controllers", "cdpr_solvers")
FOLDERS = (*PACKAGES, "benchmarks", "docs", "examples", "scenarios")
# A docstring begins with a noun phrase or an imperative.
FIRST = re.compile(r"(What|Whatever|Who|Whose|Which|Where|Wherever|Whether|From|One that)\b")
# Words of an old dialect of this project. `told` may be a name in code.
AVOIDED = re.compile(
    r"(?<!`)\b(told(?![:`])|asks for|asked for|goes on|go on|stands\b(?!-)|heeds?|hears of|is meant|seldom meant|so many|hush|of those that|of that which|unless (said|told|given)|as told|"
    r"bears?|goes along|go along|comes? of it|takes its time|whoever|anyone's|one's own|stranger's?)\b",
    re.IGNORECASE,
)
TEXT = 3  # words: shorter strings are keys and names


def files(*endings: str) -> list[Path]:
    """Return the files of the project with these endings."""
    found = [path for folder in FOLDERS for path in sorted((ROOT / folder).rglob("*")) if path.suffix in endings]
    return [path for path in found if "fmi" not in path.parts[-2:]]  # headers of the FMI standard


def docstrings(tree: ast.Module) -> Iterator[ast.Constant]:
    """Yield the docstrings of a module, its classes and functions, and those of constants."""
    for node in ast.walk(tree):
        for statement in getattr(node, "body", []) if not isinstance(node, ast.Lambda | ast.IfExp) else []:
            value = statement.value if isinstance(statement, ast.Expr) else None
            if isinstance(value, ast.Constant) and isinstance(value.value, str):
                yield value


def texts(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Yield the string literals of several words, docstrings included."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and len(node.value.split()) >= TEXT:
            yield node.lineno, node.value


def comments(source: str) -> Iterator[tuple[int, str]]:
    """Yield the first line of each comment in Python."""
    before = -1
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            if token.start[0] != before + 1 or token.line.strip() != token.string:
                yield token.start[0], token.string
            before = token.start[0]


def first_lines(path: Path) -> Iterator[tuple[int, str]]:
    """Yield line and text of everything that must begin plainly."""
    source = path.read_text()
    if path.suffix == ".py":
        yield from ((each.lineno, each.value) for each in docstrings(ast.parse(source)))
        yield from comments(source)
        return
    mark = {".md": r"#+ ", ".yaml": r"# "}.get(path.suffix, r"// ")
    before = ""
    for number, line in enumerate(source.split("\n"), 1):
        if re.match(rf"\s*{mark}", line) and not re.match(rf"\s*{mark}", before):
            yield number, line
        before = line


def place(path: Path, line: int) -> str:
    return f"{path.relative_to(ROOT)}:{line}"


@pytest.mark.parametrize("ending", [".py", ".md", ".yaml", ".hpp", ".h", ".cpp", ".c"])
def test_first_words_are_plain(ending):
    """Docstrings, comments and headings begin with what they name."""
    wrong = [
        f"{place(path, line)}: {text.splitlines()[0]}"
        for path in files(ending)
        for line, text in first_lines(path)
        if FIRST.match(text.lstrip("#/ \n"))
    ]
    assert wrong == []


def test_words_are_plain():
    """Docstrings and texts of Python, and pages, avoid the dialect."""
    found = [
        (place(path, line), match.group())
        for path in files(".py")
        if path.relative_to(ROOT).parts[0] in PACKAGES
        for line, text in texts(ast.parse(path.read_text()))
        for match in AVOIDED.finditer(text)
    ]
    pages = [ROOT / "README.md", *files(".md")]
    lines = [(place(path, i), line) for path in pages for i, line in enumerate(path.read_text().split("\n"), 1)]
    found += [(where, match.group()) for where, line in lines for match in AVOIDED.finditer(line)]
    assert found == []
