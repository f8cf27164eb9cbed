"""All missing keys of a robot file are reported together, and one mistake in many cables in one line."""

from __future__ import annotations

import re

import pytest

from cdpr.base.errors import ScenarioError
from cdpr.scenario import load_robot

LACKING = """\
dof: [x, z, ry]
platform: {mass: -1}
cable:
  model: elastic
home: {position: [0, 0, 0], orientation: {rpy: [1, 0, 0]}}
cables:
- {frame: [-3.5, -2.0, 3.5], platform: [0.6, -0.3, -0.2]}
- {frame: [3.5, -2.0, 3.5], winch: {drum_radius: -1}}
"""


def test_all_missing_keys_of_a_robot_are_reported_together():
    with pytest.raises(ScenarioError) as caught:
        load_robot("r.yaml", text=LACKING)
    assert [re.sub(r" \(kg.*|: allowed.*|, for all.*", "", line) for line in caught.value.problems] == [
        "r.yaml:1:1: tension: required but not given: tension limits of all cables",
        "r.yaml:2:1: platform.inertia: required but not given: [ixx, iyy, izz, ixy, ixz, iyz]",
        "r.yaml:2:18: platform.mass: must be greater than 0",
        "r.yaml:3:1: cable.model elastic needs the axial stiffness (N) of each cable: give cable.axial_stiffness for "
        "all, or axial_stiffness of cable cable_1, cable_2",
        "r.yaml:3:1: cable.model elastic needs the moment of inertia of all that turns",
        "r.yaml:3:1: cable.model elastic needs the winch of each cable: give winch for all, such as "
        "winch: {drum_radius: 0.05, inertia: 0.01}, or winch of cable cable_1",
        "r.yaml:5:42: home.orientation: may differ from upright only about the free directions, x, z, ry",
        "r.yaml:8:3: cables[1].platform: required but not given: anchor B_i on the platform, platform axes (m)",
        "r.yaml:8:50: cables[1].winch.drum_radius: must be greater than 0 (m), got -1",
    ]


def test_one_mistake_in_many_cables_is_one_line():
    cables = "".join(f"- {{frame: [{i}, 0, 1]}}\n" for i in range(8))
    text = f"platform: {{mass: 1, inertia: [1, 1, 1, 0, 0, 0]}}\ntension: {{min: 1, max: 9}}\ncables:\n{cables}"
    with pytest.raises(ScenarioError) as caught:
        load_robot("r.yaml", text=text)
    (line,) = caught.value.problems
    assert line.startswith("r.yaml:4:3: cables[0].platform: required but not given")
    assert line.endswith("; and 7 more like this, the last at cables[7].platform in line 11")
    with pytest.raises(ScenarioError) as caught:
        load_robot("r.yaml", text=text.replace("1]}", "1], platform: [0, 0, 0]}").replace("[5, 0, 1]", "[5, 0]"))
    assert len(caught.value.problems) == 1  # a single one is reported as before
