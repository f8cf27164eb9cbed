"""docs/fmu.md says what the code does."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
import yaml
from conftest import ROOT, crossed_box, make_robot
from fmu_cases import description, signals, variable

from cdpr.fmu.read.description import read_description
from cdpr.fmu.read.mapping import map_signals
from cdpr.fmu.read.options import Signals
from cdpr.fmu.read.signals import INPUTS, OUTPUTS

TEXT = (ROOT / "docs/fmu.md").read_text()
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
