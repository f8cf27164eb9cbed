"""Files for forges and tools: what they call is there, with no more rights than they need."""

from __future__ import annotations

import os
import re

import yaml
from conftest import ROOT

from cdpr import __version__


def test_hooks_call_tools_of_the_environment():
    repos = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text())["repos"]
    assert {repo["repo"] for repo in repos} == {"local"}
    entries = [hook["entry"].split()[0] for repo in repos for hook in repo["hooks"]]
    assert set(entries) == {f".venv/bin/{tool}" for tool in ("ruff", "mypy", "lint-imports")}


def test_the_workflow_runs_ci_and_may_only_read():
    workflow = yaml.safe_load((ROOT / ".github" / "workflows" / "ci.yml").read_text())
    assert workflow["permissions"] == {"contents": "read"}
    steps = workflow["jobs"]["run"]["steps"]
    assert [step["run"] for step in steps if "run" in step] == [".ci/run"]
    assert os.access(ROOT / ".ci" / "run", os.X_OK)


def test_the_changelog_is_by_version_and_kind():
    text = (ROOT / "CHANGELOG.md").read_text()
    versions = re.findall(r"^## \[(.+?)\] - (?:Unreleased|\d{4}-\d\d-\d\d)$", text, re.MULTILINE)
    assert versions[0] == __version__
    kinds = re.findall(r"^### (.+)$", text, re.MULTILINE)
    assert set(kinds) <= {"Added", "Changed", "Deprecated", "Removed", "Fixed", "Security"}
    assert len(kinds) <= 6 * len(versions)
    lines = [line for line in text.splitlines() if line.startswith("- ")]
    assert len(set(lines)) == len(lines)
    last = text.rpartition("\n### Security\n")[2]
    assert len(last.splitlines()) < 30  # a merge may append what was above
