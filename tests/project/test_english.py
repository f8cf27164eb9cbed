"""Plain English: first words of docstrings, comments and headings, and words that are avoided everywhere."""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest
from conftest import ROOT
from spread import sampled

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
# Verbs that are not those of the field, in docstrings, comments and messages; names of code are excepted.
VERBS = re.compile(
    r"\b(?:tells?|told|telling|says?|said|saying|asks?|asked|asking|stands?|stood|bears?|bore|minds?|heeds?|hears?|heard"
    r"|(?:knows?|known|knew) of|take[ns]? down|h[eo]ld to|goes? on|went on|goes? along|comes? in|came in"
    r"|(?:is|are) meant|look(?:s|ed)? at|strangers?)\b",
    re.IGNORECASE,
)
# Code spans, names of arguments before their description, stand-ins, and questions of the browser to its user.
CODE = re.compile(r"`[^`]*`|^ *\**\w+(?:, \**\w+)*: |\bstand-ins?\b|^# noqa.*", re.IGNORECASE | re.MULTILINE)
PROGRAMS = re.compile(r"```.*?```", re.DOTALL)  # in pages
RIDDLE = re.compile(
    r"test_(?:what|where|who|which|whether|whose|whatever|whoever)_|_(?:told|tells?|says?|said|asks?|heeds?)(?:_|$)"
)


def files(*endings: str) -> list[Path]:
    """Return the files of the project with these endings, but for the headers of the FMI standard."""
    found = [path for folder in FOLDERS for path in sorted((ROOT / folder).rglob("*")) if path.suffix in endings]
    return [path for path in found if path.parent.name != "fmi" and not path.is_symlink()]  # the build links headers


def lines_of(found: re.Match[str]) -> str:
    """Return as many empty lines as a match has."""
    return "\n" * found.group().count("\n")


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


@pytest.mark.slow
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


def texts(path: Path, *, messages: bool) -> Iterator[tuple[int, str]]:
    """Yield docstrings, comments and, if wanted, messages of a Python file with such verbs, without code in them."""
    source = path.read_text()
    if not VERBS.search(source):
        return
    nodes = list(ast.walk(ast.parse(source)))
    docs = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
    for node in nodes:
        text = node.value if isinstance(node, ast.Constant) else None
        if isinstance(text, str) and text.count(" ") > 1 and (messages or id(node) in docs):
            yield node.lineno, CODE.sub("", text)
    if not any("#" in line and VERBS.search(line) for line in source.splitlines()):
        return
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            yield token.start[0], CODE.sub("", token.string)


@pytest.mark.slow
@sampled(lambda folder: folder != "tests", "folder", [*FOLDERS[:6], "examples", "tests"])
def test_verbs_are_those_of_the_field(folder):
    """Docstrings and comments compute, report, require; so do messages outside the tests."""
    wrong = [
        f"{path.relative_to(ROOT)}:{number}: {found.group()}: {text.strip()[:100]}"
        for path in sorted((ROOT / folder).rglob("*.py"))
        for number, text in texts(path, messages=folder not in ("tests", "benchmarks"))
        if (found := VERBS.search(text)) and path != Path(__file__)
    ]
    assert wrong == []


def test_verbs_of_pages_are_those_of_the_field():
    wrong = [
        f"{path.relative_to(ROOT)}:{number}: {found.group()}: {line}"
        for path in [*files(".md"), ROOT / "README.md", ROOT / "CONTRIBUTING.md"]
        for number, line in enumerate(PROGRAMS.sub(lines_of, path.read_text()).split("\n"), 1)
        if (found := VERBS.search(CODE.sub("", line)))
    ]
    assert wrong == []


def test_first_words_and_names_of_tests_are_plain():
    wrong = [
        f"{path.relative_to(ROOT)}:{number}: {text}"
        for path in sorted((ROOT / "tests").rglob("*.py"))
        for number, text in [
            *((number, text) for number, text in beginnings(path) if FIRST.match(text)),
            *(
                (0, name)
                for name in re.findall(r"^ *def (test_\w+)", path.read_text(), re.MULTILINE)
                if RIDDLE.search(name)
            ),
        ]
        if path != Path(__file__)
    ]
    assert wrong == []


@pytest.mark.parametrize(
    ("source", "count"),
    [
        ('"""What a run tells."""\n', 1),
        ('def f():\n    """Return x.\n\n    ask: function of x; see `ask`.\n    """\n', 0),
        ("x = 1  # nobody is told\n", 1),
        ('raise ValueError("it says nothing now")\n', 1),
        ("told = ask(say)\n", 0),
    ],
)
def test_verbs_are_found(tmp_path, source, count):
    (tmp_path / "a.py").write_text(source)
    assert sum(bool(VERBS.search(text)) for _, text in texts(tmp_path / "a.py", messages=True)) == count


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
