"""Figures of `cdpr info` and their Python form in docs/python.md."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from command_line import cdpr_here
from conftest import ROOT

from cdpr.log.run_json import to_json

PAGE = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
SECTION = PAGE[PAGE.index("## Values of `cdpr info`") :]
CODE = SECTION[SECTION.index("```python\n") + 10 : SECTION.index("\n```\n")]
ROWS = dict(re.findall(r"^\| `([a-z_]+\.[\w.\[\]]+)` \| `(.+)` \|$", SECTION, re.MULTILINE))
WHOLE = ("least", "tools_m", "shape_m", "believed", "bandwidth_Hz")  # figures that are dicts themselves


def leaves(figures, name=""):
    """Yield each figure with its name in the table; of lists of dicts the values of one name together."""
    if isinstance(figures, dict) and name.rpartition(".")[2] not in WHOLE:
        for key, value in figures.items():
            yield from leaves(value, f"{name}.{key}" if name else key)
    elif (
        isinstance(figures, list)
        and figures
        and isinstance(figures[0], dict)
        and not name.endswith(("believed", "poles"))
    ):
        for key in figures[0]:
            yield f"{name}[].{key}", [each[key] for each in figures]
    else:
        yield name, figures


def plain(value):
    """Return a value as JSON has it: arrays as lists, numbers that are not finite as null."""
    listed = json.loads(json.dumps(value, default=lambda array: array.tolist()))
    return json.loads(json.dumps(to_json(listed)))


def close(value, other):
    if isinstance(value, list) and isinstance(other, list):
        return len(value) == len(other) and all(map(close, value, other))
    if isinstance(value, float):
        return other is not None and np.isclose(value, other, rtol=1e-9, atol=1e-9)
    return value == other


FILES = {
    "believed, event, winches": ("believed", {}),
    "no margin": ("planar", {"robot.platform.mass": 1e5}),
    "motion": ("caroca", {}),
}


@pytest.mark.parametrize("name", [*list(FILES)[:2], pytest.param("motion", marks=pytest.mark.slow)])
def test_each_figure_has_a_python_form(name):
    file, changes = FILES[name]
    path = ROOT / "scenarios" / f"{file}.yaml"
    words = [word for key, value in changes.items() for word in ("--set", f"{key}={value}")]
    given = json.loads(cdpr_here("info", path, *words, "--json").stdout)
    scope = {"overrides": changes}
    code = CODE.replace('"scenarios/caroca.yaml"', f"{str(path)!r}, overrides=overrides")
    assert code != CODE
    exec(compile(code, "docs/python.md", "exec"), scope)
    figures = dict(leaves(given))
    assert set(figures) <= set(ROWS)
    assert set(ROWS) - set(figures) <= {"robot.believed"}
    for figure, value in figures.items():
        assert close(value, plain(eval(ROWS[figure], scope))), figure
