"""Every Python script in examples/ runs."""

from __future__ import annotations

import runpy

import pytest
from conftest import ROOT

SCRIPTS = sorted((ROOT / "examples").glob("*.py"))


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.name)
def test_an_example_runs_and_prints_its_result(script, capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)  # scripts find their files by name, and write none
    runpy.run_path(str(script), run_name="__main__")
    assert capsys.readouterr().out.strip()
    assert list(tmp_path.iterdir()) == []
