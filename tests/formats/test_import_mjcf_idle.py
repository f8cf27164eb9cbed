"""Parts of our own MJCF that no robot depends on are listed in one line; others keep a line each."""

from __future__ import annotations

import pytest
from command_line import cdpr_here
from conftest import ROOT

pytest.importorskip("mujoco")


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("", "", []),
        ('contype="0"', 'contype="1"', ["attribute 'contype' of <geom>"]),
        ('qvel="0', 'qvel="1', ["attribute 'qvel' of <key>"]),
        ('<actuatorfrc name="cable_1_tension"', '<actuatorfrc noise="1"', ["attribute 'noise' of <actuatorfrc>"]),
    ],
)
def test_export_read_back(tmp_path, old, new, expected):
    file = tmp_path / "robot.xml"
    cdpr_here("export", ROOT / "scenarios" / "robots" / "caroca.yaml", "--to", "mjcf", "--out", file)
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new, 1) if old else text)
    done = cdpr_here("import", file, "--out", tmp_path / "out")
    told = [line for line in done.stderr.splitlines() if line.startswith("left out: ")]
    (line,) = (each for each in told if "parts that only draw, measure or start a simulation: " in each)
    assert f"robot.xml: {13 - ('noise' not in new and bool(old))} parts" in line
    assert "timestep of <option>, contact of <flag>, size of <site>" in line
    told.remove(line)
    assert len(told) == len(expected)
    assert all(name in each for name, each in zip(expected, told, strict=True))
