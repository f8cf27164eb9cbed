"""Further exported content: bars of a frame, gravity and steps of a scenario."""

from __future__ import annotations

from dataclasses import replace
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from conftest import ROOT

import cdpr
from cdpr.formats.write import TARGETS
from cdpr.formats.write.export_model import begin, export
from cdpr.model import rotations
from cdpr.model.shapes import Frame

SCENARIO = ROOT / "scenarios" / "caroca.yaml"


def bars_of(root, to):
    """Middle (3,) and half of the way (3,) of each cylinder that is drawn of the frame."""

    def numbers(text):
        return np.array([float(word) for word in text.split()])

    if to == "mjcf":
        for geom in root.find("worldbody").findall("geom"):
            turned = rotations.matrix(numbers(geom.get("quat")))
            yield numbers(geom.get("pos")), turned[:, 2] * numbers(geom.get("size"))[1]
        return
    for visual in next(link for link in root.iter("link") if link.get("name") == "frame").findall("visual"):
        if to == "sdf":
            place, height = numbers(visual.find("pose").text), numbers(visual.find("geometry/cylinder/length").text)
        else:
            origin = visual.find("origin")
            place = numbers(f"{origin.get('xyz')} {origin.get('rpy')}")
            height = numbers(visual.find("geometry/cylinder").get("length"))
        yield place[:3], rotations.matrix(rotations.from_rpy(*place[3:]))[:, 2] * 0.5 * height[0]


@pytest.mark.parametrize("to", TARGETS)
def test_bars_lie_along_the_edges_of_the_frame(to):
    """Each is a cylinder along its z; a frame that leans has edges along no axis."""
    edges = [
        [[0.0, 0.0, 0.0], [0.3, -0.4, 1.2]],
        [[1.0, 1.0, 2.0], [1.0, 1.0, 0.5]],
        [[0.0, 0.0, 0.0], [-1.0, 2.0, 0.0]],
    ]
    subject = begin(cdpr.load_scenario(SCENARIO))
    frame = Frame(np.array(edges).reshape(-1, 6))
    text = export(replace(subject, robot=replace(subject.robot, frame=frame)), to)
    for edge, (middle, along) in zip(edges, bars_of(ET.fromstring(text), to), strict=True):
        ends = np.array([middle - along, middle + along])
        assert min(np.abs(ends - edge).max(), np.abs(ends - edge[::-1]).max()) < 1e-12


def test_gravity_and_step_are_the_scenarios():
    changes = {"world.gravity": [0.0, 0.5, -1.62], "simulation.control_step": 0.004, "simulation.physics_step": 0.002}
    option = ET.fromstring(export(begin(cdpr.load_scenario(SCENARIO, overrides=changes)), "mjcf")).find("option")
    assert [float(word) for word in option.get("gravity").split()] == [0.0, 0.5, -1.62]
    assert float(option.get("timestep")) == 0.002
    one = cdpr.load_scenario(SCENARIO, overrides={"simulation.control_step": 0.004, "simulation.duration": 2.0})
    option = ET.fromstring(export(begin(one), "mjcf")).find("option")
    assert float(option.get("timestep")) == one.simulation.physics_step
