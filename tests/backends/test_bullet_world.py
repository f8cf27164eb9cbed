"""Worlds of Bullet, and their saved states."""

import numpy as np
import pytest

pytest.importorskip("pybullet")

from cdpr_backends.bullet.world import Client, SavedState

GRAVITY = np.array([0.0, 0.0, -9.81])


def test_a_state_of_a_closed_world_takes_none_of_the_next():
    """Bullet gives the number of a closed client to the next, and counts the states of each from zero."""
    first = Client(GRAVITY, 0.001)
    old = SavedState(first)
    first.close()
    second = Client(GRAVITY, 0.001)
    assert second.number == first.number
    saved = SavedState(second)
    del old
    saved.restore()
