"""Rigid legs of 1 g against massless cables, the same closed loop."""

from __future__ import annotations

import numpy as np
import pytest
from plants import installed
from spread import spread
from test_engines import SKEWED, closed_loop, differences

CLOSE = 1e-5  # m; measured 3.4e-6: the legs' weight
TURNED = 1e-5  # rad
PULL = 0.1  # N; measured 0.02

ENGINES = installed("mujoco", "bullet", "dart")


@spread("engine, overrides", ENGINES, [{}, SKEWED])
@pytest.mark.usual("mujoco-*")
def test_legs_pull_like_cables(engine, overrides):
    cables = closed_loop(overrides, backend=engine)
    legs = closed_loop({**overrides, f"backend_options.{engine}.cables": "ups"}, backend=engine)
    place, attitude = differences(cables, legs)
    assert 0.0 < place < CLOSE  # not the cables again
    assert attitude < TURNED
    assert np.abs(cables.tension - legs.tension).max() < PULL
