"""Our own baselines: what a run gave is what it gives. Made anew, where a change is meant, by

cdpr baseline save scenarios/{caroca,off_centre_mass,planar,cable_break}.yaml --out tests/regression/baselines
cdpr baseline save scenarios/rotated_start.yaml --backends mujoco,bullet,dart --out tests/regression/baselines
"""

from __future__ import annotations

from pathlib import Path

import pytest

from cdpr.compare import baseline, baseline_check
from cdpr.plugins.registry import registry

FOLDER = Path(__file__).parent / "baselines"
FILES = sorted(FOLDER.iterdir())


@pytest.fixture(scope="module")
def found():
    return {checked.name: checked for checked in baseline_check.check(FOLDER)}


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_baseline(path, found):
    if registry().get("backend", baseline.read(path).backend).missing:
        pytest.skip("its engine is not installed")
    checked = found[path.name.removesuffix(baseline.SUFFIX)]
    assert checked.agrees, checked.detail


def test_they_are_small():
    assert sum(path.stat().st_size for path in FILES) < 100_000
