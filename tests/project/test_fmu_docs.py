"""docs/fmu.md matches the code."""

from __future__ import annotations

import json
import re
import shlex

import numpy as np
import pytest
import yaml
from click.testing import CliRunner
from conftest import ROOT, crossed_box, make_robot
from fmu_cases import description, signals, variable

from cdpr.fmu.read.description import read_description
from cdpr.fmu.read.mapping import map_signals
from cdpr.fmu.read.options import Signals
from cdpr.fmu.read.signals import INPUTS, OUTPUTS
from cdpr.ui.cli import cli

TEXT = (ROOT / "docs/fmu.md").read_text()
PID = "controller={type: pid, kp: 100, kd: 20, ki: 0}"
SETTLED = 1e-3  # m: a second after the ramp, 10 time constants of 0.1 s, of a lag of 0.05 m
NEED = {"required": "yes", "optional": "no", "choice": "one"}


def test_the_table_of_signals():
    rows = []
    for role in INPUTS:
        for words, side in (("takes", INPUTS[role]), ("gives", OUTPUTS[role])):
            for signal in side:
                units = ", ".join(dict.fromkeys(signal.units(6))) or "any"
                size = signal.size or "m"
                rows.append(f"| {role} | {words} | `{signal.name}` | {size} | {units} | {NEED[signal.need]} |")
    table = re.search(r"<!-- signals -->\n(.*)<!-- end of signals -->", TEXT, re.DOTALL)[1]
    assert table.splitlines()[2:] == rows


@pytest.mark.parametrize("more", [pytest.param([], marks=pytest.mark.slow), ["--set", PID]], ids=["exact", "pid"])
def test_the_example_in_fmpy_arrives(more, tmp_path, monkeypatch, capsys):
    """With the FMU that a command above it makes; by default with the library of physics/test_fmu_control.py."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    (made,) = re.findall(r"^\$ cdpr (fmu export \S+ -o loop\.fmu .*?) +#", TEXT, re.MULTILINE)
    done = CliRunner().invoke(cli, [*shlex.split(made.replace("scenarios/", f"{ROOT}/scenarios/")), *more])
    assert done.exit_code == 0, done.output
    checked = CliRunner().invoke(cli, ["fmu", "check", "loop.fmu", str(ROOT / "scenarios" / "robots" / "planar.yaml")])
    assert "contains a controller and a plant (--with-controller)" in checked.stdout
    (code,) = re.findall(r"^```python\n(.*?)^```$", TEXT, re.DOTALL | re.MULTILINE)
    told: dict = {}
    exec(code, told)
    np.testing.assert_allclose(told["found"]["position"][-1], told["desired"]["desired_position"][-1], atol=SETTLED)
    assert "[" in capsys.readouterr().out


@pytest.mark.parametrize("example", re.findall(r"^```yaml\n(.*?)^```$", TEXT, re.DOTALL | re.MULTILINE))
def test_the_examples_fit_such_an_fmu(example):
    robot = make_robot(crossed_box(np.random.default_rng(1), 8))
    said = Signals.model_validate_json(json.dumps(yaml.safe_load(example)["signals"]))
    table = {"body.v": ("output", 3, None), "body.w": ("output", 3, "rad/s"), "body.Q": ("output", 4, None)}
    rows = [*signals(3, table), *(variable(3, f"winches[{i}].F", 20 + i, "input", unit="N") for i in range(1, 9))]
    rows += [variable(3, f"body.{axis}", 40 + i, "output", unit="m") for i, axis in enumerate("xyz")]
    rows += [variable(3, name, 50 + i, "output") for i, name in enumerate(["phi", "theta", "psi"])]
    if "euler" in said.outputs:
        more = {"inputs": {"cable_tension": "winches[{i}].F"}}
        usual = {"position": ["body.x", "body.y", "body.z"], "velocity": "body.v", "angular_velocity": "body.w"}
        rest = Signals.model_validate_json(json.dumps({**more, "outputs": usual}))
        said = rest.model_copy(update={"outputs": {**rest.outputs, **said.outputs}})
    mapping = map_signals(read_description(description(3, rows).encode()), robot, said)
    assert list(mapping.outputs.ports) == ["position", "quaternion", "velocity", "angular_velocity"]
    assert {port.rule for port in mapping.outputs.ports.values()} == {"given"}
