"""`cdpr solvers`: what plugins declare, as a table, at length and as JSON."""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner
from pydantic import Field

from cdpr.base.errors import PluginError
from cdpr.plugins import PluginInfo, PluginOptions
from cdpr.plugins.registry import Registered, registry
from cdpr.ui.cli.solvers import command

SUMMARY = f"an odd one{', that is long' * 10}"


class Options(PluginOptions):
    power: float = Field(2.0, description="of each tension")
    limit: float | None = Field(None, description="of all of them")
    weights: list[float] = Field(description="one a cable")


@pytest.fixture
def stranger(monkeypatch):
    info = PluginInfo(
        name="odd",
        factory="x:Y",
        summary=SUMMARY,
        requires=("no_such_module",),
        properties={"exact": False, "max_redundancy": 2, "formula": "t = 7", "colour": "blue"},
        options=Options,
    )
    monkeypatch.setitem(registry().plugins["solver"], "far:odd", Registered("solver", info, "far", "3.1"))


def run(*arguments):
    result = CliRunner().invoke(command, arguments, catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.stdout


def test_table(stranger):
    text = run()
    rows = {line.split()[0]: line.split() for line in text.splitlines() if line.startswith("  ")}
    assert set(registry().names("solver")) <= set(rows)
    assert rows["far:odd"][:8] == ["far:odd", "-", "no", "2", "-", "-", "-", "-"]
    assert rows["qp"][1:3] == ["min_norm", "yes"]
    assert rows["pseudo_inverse"][rows["pseudo_inverse"].index("Cinf") + 1] == "no"  # keeps no limits
    assert "far:odd: not installed: pip install no_such_module" in text
    assert max(map(len, text.splitlines())) <= 120


def test_at_length(stranger):
    text = run("far:odd")
    for expected in (
        "far:odd: an odd one, that is long",
        ", that is long,\n  that is long, that is long, that is long\n",
        "  formula        t = 7\n",
        "  source         -\n",
        "  max r          2\n",
        "  colour         blue\n",
        "  option         power (default 2.0): of each tension\n",
        "  option         limit (not set): of all of them\n",
        "  option         weights (required): one a cable\n",
        "  from           far 3.1\n",
        "  not installed  pip install no_such_module\n",
    ):
        assert expected in text
    everything = run("--long")
    assert text in everything
    assert max(map(len, everything.splitlines())) <= 120


def test_json_holds_what_is_declared(stranger):
    told = {row["name"]: row for row in json.loads(run("--json"))}
    assert list(told) == registry().names("solver")
    for name, row in told.items():
        assert set(row["properties"]) == set(registry().get("solver", name).info.properties)
    assert json.loads(run("far:odd", "--json")) == told["far:odd"]
    assert told["far:odd"]["options"][2] == {
        "name": "weights", "default": None, "required": True, "meaning": "one a cable"
    }  # fmt: skip


def test_unknown_name():
    with pytest.raises(PluginError, match="did you mean 'qp'"):
        run("qpp")
