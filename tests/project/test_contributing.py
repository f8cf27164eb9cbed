"""CONTRIBUTING.md, SECURITY.md and CITATION.cff: what they name is there, and nothing in them is made up."""

from __future__ import annotations

import ast
import re
import tomllib
from importlib import import_module

import pytest
import yaml
from click.testing import CliRunner
from conftest import ROOT

from cdpr import __version__
from cdpr.ui.cli import cli

PAGES = {name: (ROOT / name).read_text() for name in ("CONTRIBUTING.md", "SECURITY.md")}
QUOTED = {name: re.findall(r"`([^`\n]+)`", text) for name, text in PAGES.items()}
ADDITIONS = [ROOT / "tests" / "plugins" / name for name in ("test_additions.py", "test_added_parts.py")]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]

# Place of a reader's own file: its folder must exist.
OWN = re.compile(r"NAME[./]|test_x\.py")


def rows():
    """The cells of the table of what to add, without its head."""
    lines = [line for line in PAGES["CONTRIBUTING.md"].splitlines() if line.startswith("| ")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[1:]]


@pytest.mark.parametrize("page", PAGES)
def test_files_exist(page):
    named = [quoted for quoted in QUOTED[page] if "/" in quoted and " " not in quoted]
    named.extend(re.findall(r"\]\(([^)#:]+)\)", PAGES[page]))
    assert named
    places = [re.split(r"NAME|test_x", name)[0] if OWN.search(name) else name for name in named]
    assert [place for place in places if not (ROOT / place).exists()] == []


def test_entries_are_in_their_tables():
    checked = 0
    for row in rows():
        name, file = re.match(r"(?:`(\w+)` in )?(?:a row in )?(?:`([\w/.]+)`)?", row[2]).groups()
        if name:
            text = (ROOT / file).read_text()
            assert re.search(rf"^{name}\b.*=", text, re.MULTILINE), row
            checked += 1
        elif file:
            assert "PluginInfo(" in (ROOT / file).read_text(), row
            checked += 1
    assert checked == len(rows()) - 1  # a scenario needs no entry


def test_every_addition_is_on_the_page_and_every_proof_is_a_test():
    trees = [ast.parse(file.read_text()) for file in ADDITIONS]
    tests = {node.name for tree in trees for node in tree.body if isinstance(node, ast.FunctionDef)}
    tests = {name for name in tests if name.startswith("test_")}
    proofs = {row[3].strip("`") for row in rows()}
    assert {proof for proof in proofs if "/" not in proof} == tests
    assert all((ROOT / proof).exists() for proof in proofs if "/" in proof)


@pytest.mark.parametrize("name", [name for name in QUOTED["CONTRIBUTING.md"] if re.fullmatch(r"cdpr(\.\w+)+", name)])
def test_names_of_the_program(name):
    module, _, attribute = name.rpartition(".")
    assert hasattr(import_module(module), attribute)


@pytest.mark.parametrize(
    ("name", "file"),
    [(row[1], file) for row in rows() for file in re.findall(r"of `([\w/.]+\.py)`", row[1])],
)
def test_base_classes(name, file):
    module = import_module(file.removesuffix(".py").replace("/", "."))
    named = re.findall(r"`([A-Z]\w+)`", name)
    assert named
    assert all(hasattr(module, one) for one in named)


@pytest.mark.parametrize("page", PAGES)
def test_commands_and_options_exist(page):
    commands = [found[1] for quoted in QUOTED[page] if (found := re.match(r"cdpr ([a-z -]+)", quoted))]
    assert commands
    for command in commands:
        assert CliRunner().invoke(cli, [*command.split(), "--help"]).exit_code == 0, command


def test_security_speaks_of_this_program():
    text = PAGES["SECURITY.md"]
    sources = "".join(path.read_text() for path in sorted((ROOT / "cdpr").rglob("*.py")))
    for name in ("CDPR_DISABLE_PLUGINS", "XDG_CACHE_HOME", "--plugin", "--trust-fmu", "sha256"):
        assert name in text
        assert f'"{name}"' in sources or name in sources
    assert f"version {__version__.rpartition('.')[0]};" in text


def test_no_address_and_no_person_is_made_up():
    for text in (*PAGES.values(), (ROOT / "CITATION.cff").read_text()):
        assert "@" not in text
        assert "http" not in text


def test_the_citation_matches_the_project():
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert set(cited) == {
        *("cff-version", "message", "type", "title", "abstract", "authors", "version", "license", "keywords")
    }
    assert cited["title"] == PROJECT["name"]
    assert cited["abstract"] == PROJECT["description"]
    assert cited["version"] == PROJECT["version"] == __version__
    assert cited["license"] == PROJECT["license"]
    assert cited["keywords"] == PROJECT["keywords"]
    assert [*cited["authors"][0]] == ["name"]  # an entity, not a person
