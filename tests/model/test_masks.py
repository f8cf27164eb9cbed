"""Masked values are rejected in all array arguments: numpy would use the numbers below the mask."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT

import cdpr
from cdpr.analysis.workspace.regions import region
from cdpr.analysis.workspace.required import box, vertices
from cdpr.base.errors import CdprError
from cdpr.model.robot import frozen_array

CAROCA = ROOT / "scenarios" / "caroca.yaml"
KP = np.ma.array([50.0, 999.0, 70.0], mask=[0, 1, 0])
POSE = np.ma.array([0.0, 0.0, 1.2, 1.0, 0.0, 0.0, 0.0], mask=[0, 1, 0, 0, 0, 0, 0])
WRENCH = np.ma.array(np.ones(6), mask=[1, 0, 0, 0, 0, 0])
Q = np.ma.array([1.0, 0.0, 0.0, 0.0], mask=[0, 1, 0, 0])


@pytest.fixture(scope="module")
def robot():
    return cdpr.load_robot(ROOT / "scenarios" / "robots" / "caroca.yaml")


CALLS = {
    "vary": lambda robot: cdpr.rollout(CAROCA, 3, vary={"controller.kp": KP}),
    "vary, a list of arrays": lambda robot: cdpr.rollout(CAROCA, 2, vary={"initial.position": [KP, KP]}),
    "vary, a masked number": lambda robot: cdpr.rollout(CAROCA, 2, vary={"controller.kp": [50.0, np.ma.masked]}),
    "vary, a distribution": lambda robot: cdpr.rollout(CAROCA, 3, vary={"controller.kp": {"uniform": KP[:2]}}),
    "overrides": lambda robot: cdpr.load_scenario(CAROCA, overrides={"initial.position": KP}),
    "overrides, a masked number": lambda robot: cdpr.load_scenario(CAROCA, overrides={"controller.kp": np.ma.masked}),
    "distribute, poses": lambda robot: cdpr.distribute(robot, POSE, np.zeros(6)),
    "distribute, wrenches": lambda robot: cdpr.distribute(robot, POSE.data, WRENCH),
    "admissible": lambda robot: cdpr.admissible(robot, POSE, np.zeros(6)),
    "region, corners": lambda robot: region(robot, lower=KP, upper=[1e3, 1e3, 1e3]),
    "region, attitudes": lambda robot: region(robot, orientations=Q),
    "region, cells": lambda robot: region(robot, cells=np.ma.array([3, 3, 3], mask=[0, 1, 0])),
    "box": lambda robot: box(WRENCH),
    "vertices": lambda robot: vertices([WRENCH]),
    "robots": lambda robot: frozen_array(KP),
}


@pytest.mark.parametrize("call", CALLS.values(), ids=CALLS)
def test_masked_values_are_rejected(robot, call):
    with pytest.raises(CdprError, match="masked"):
        call(robot)


def test_a_mask_that_hides_nothing_is_allowed():
    assert frozen_array(np.ma.array([1.0, 2.0], mask=[0, 0])).tolist() == [1.0, 2.0]
