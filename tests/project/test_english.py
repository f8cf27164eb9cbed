"""Plain English: first words of docstrings, comments and headings, and words that are avoided everywhere."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from conftest import ROOT

FOLDERS = ("cdpr", "cdpr_backends", "cdpr_controllers", "cdpr_solvers", "benchmarks", "docs", "examples", "scenarios")
PROGRAM = (".hpp", ".h", ".cpp", ".c")
# Beginning of a docstring, of a comment (alone or two spaces behind code), and of a heading.
BEGINNINGS = {".py": r"""^ *r?\"\"\"(?=\S)|(?:^ *|  )# """, ".md": "^#+ ", ".yaml": "(?:^ *|  )# "}
FIRST = re.compile(r"(What|Whatever|Who|Whose|Which|Where|Wherever|Whether|From|One that)\b")
# An old dialect of this project: plain words for these are in any text of the neighbours.
AVOIDED = re.compile(
    r"\b(?:(?:is|are|be|was|were|as) told|told (?:that|to|by|apart)|asks for|asked for|goes on|go on|heeds?|"
    r"hears of|is meant|seldom meant|so many|hush|of that which|unless (?:said|told|given)|bears?|"
    r"goes along|go along|comes? of it|takes its time|whoever|anyone's|one's own|stranger's?)\b",
    re.IGNORECASE,
)


def files(*endings: str) -> list[Path]:
    """Return the files of the project with these endings, but for the headers of the FMI standard."""
    found = [path for folder in FOLDERS for path in sorted((ROOT / folder).rglob("*")) if path.suffix in endings]
    return [path for path in found if path.parent.name != "fmi" and not path.is_symlink()]  # the build links headers


def beginnings(path: Path) -> Iterator[tuple[int, str]]:
    """Yield the lines in which something begins, from its first word on."""
    mark, before = re.compile(BEGINNINGS.get(path.suffix, "(?:^ *|  )// ")), None
    for number, line in enumerate(path.read_text().split("\n"), 1):
        found = mark.search(line)
        if found and not (before and found.start() == before.start() == 0):
            yield number, line[found.end() :]
        before = found if found and path.suffix != ".md" and '"' not in found.group() else None


@pytest.mark.parametrize("ending", [".py", ".md", ".yaml", *PROGRAM])
def test_first_words_are_plain(ending):
    """Docstrings, comments and headings begin with a noun phrase or an imperative."""
    wrong = [
        f"{path.relative_to(ROOT)}:{number}: {text}"
        for path in files(ending)
        for number, text in beginnings(path)
        if FIRST.match(text)
    ]
    assert wrong == []


@pytest.mark.parametrize("ending", [".py", ".md", ".yaml", ".js", ".html", *PROGRAM])
def test_words_are_plain(ending):
    """No text, page or comment speaks the dialect."""
    wrong = [
        f"{path.relative_to(ROOT)}:{number}: {found.group()}: {line.strip()}"
        for path in [*files(ending), *([ROOT / "README.md"] if ending == ".md" else [])]
        for number, line in enumerate(path.read_text().split("\n"), 1)
        if (found := AVOIDED.search(line))
    ]
    assert wrong == []


@pytest.mark.parametrize(
    ("ending", "source", "count"),
    [
        (".py", '"""What it is."""\n', 1),
        (".py", 'x = 1  # Where it is.\n    # From here\n    # Which is not a beginning\nlabel = "What"\n', 2),
        (".py", '"""Return x.\n\nWhether it is."""\n# A comment\n', 0),
        (".md", "## Where to go\nWhat else\n", 1),
        (".hpp", "// Whether it is.\nint f();  // One that is.\n", 2),
    ],
)
def test_beginnings_are_found(tmp_path, ending, source, count):
    (tmp_path / f"a{ending}").write_text(source)
    assert sum(bool(FIRST.match(text)) for _, text in beginnings(tmp_path / f"a{ending}")) == count
