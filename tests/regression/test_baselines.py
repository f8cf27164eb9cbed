"""Stored baselines: runs give the same results as before. After an intended change, save them again by

cdpr baseline save scenarios/{caroca,off_centre_mass,planar,cable_break}.yaml --out tests/regression/baselines --force
cdpr baseline save scenarios/rotated_start.yaml --backends mujoco,bullet,dart --out tests/regression/baselines --force
"""

from __future__ import annotations

from pathlib import Path

import pytest

from cdpr.analysis.compare import baseline, baseline_check, baseline_file
from cdpr.plugins.registry import registry

pytestmark = pytest.mark.core

FOLDER = Path(__file__).parent / "baselines"
FILES = sorted(FOLDER.iterdir())
NAMES = (
    "cable_break_reference",
    "caroca_reference",
    "off_centre_mass_reference",
    "planar_reference",
    "rotated_start_bullet",
    "rotated_start_dart",
    "rotated_start_mujoco",
)


@pytest.fixture(scope="module")
def found():
    return {checked.name: checked for checked in baseline_check.check(FOLDER)}


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_baseline(path, found):
    if registry().get("backend", baseline_file.read(path).backend).missing:
        pytest.skip("its engine is not installed")
    checked = found[path.name.removesuffix(baseline.SUFFIX)]
    assert checked.agrees, checked.detail


def test_they_are_all_there():
    assert [path.name for path in FILES] == [f"{name}{baseline.SUFFIX}" for name in NAMES]


def test_they_are_small():
    assert sum(path.stat().st_size for path in FILES) < 100_000
