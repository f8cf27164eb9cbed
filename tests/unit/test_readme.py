"""The README's tables are what the script would write, its links lead somewhere, its Python runs."""

from __future__ import annotations

import re

import pytest
import update_readme
from conftest import ROOT

README = (ROOT / "README.md").read_text()


def test_tables_are_up_to_date():
    assert update_readme.updated(README) == README, "run: python docs/update_readme.py"


def test_two_commands_for_ci():
    blocks = re.findall(r"^```bash\n(.*?)^```$", README, re.DOTALL | re.MULTILINE)
    assert len(blocks) == 2
    assert all(len(block.splitlines()) == 1 for block in blocks)


@pytest.mark.parametrize("target", sorted(set(re.findall(r"\]\(([^)#:]+)\)", README))))
def test_links_lead_somewhere(target):
    assert (ROOT / target).exists()


def test_python_examples_run(monkeypatch, tmp_path):
    """One after the other, as a reader would type them."""
    code = re.findall(r"^```python\n(.*?)^```$", README, re.DOTALL | re.MULTILINE)
    assert len(code) == 3
    (tmp_path / "scenarios").symlink_to(ROOT / "scenarios")
    monkeypatch.chdir(tmp_path)
    exec("".join(code), {})
