import base64

import numpy as np
import pytest

from cdpr.ui.report.player.arrays import STEPS, Arrays


def decoded(values: np.ndarray) -> np.ndarray:
    """Return the values as a page reads them."""
    arrays = Arrays()
    entry = arrays.coarse(values)
    steps = np.frombuffer(base64.b64decode(arrays.text()), "<u2", entry["n"], entry["at"]).astype(float)
    return np.where(steps > STEPS, np.nan, entry["low"] + entry["scale"] * steps)


@pytest.mark.parametrize("size", [1e-15, 0.1, 1e6])
@pytest.mark.parametrize("share", [0.0, 1e-9, 0.3, 1.0])
def test_zero_is_shown_as_zero(size, share):
    values = size * np.array([-share, -0.4 * share, 0.0, 0.2, 1.0, np.nan])
    shown = decoded(values)
    assert shown[2] == 0.0
    np.testing.assert_allclose(shown, values, rtol=0.0, atol=0.51 * np.ptp(values[:5]) / (STEPS - 1))


def test_constants_and_the_smallest_numbers_are_shown():
    assert decoded(np.full(3, -7.5)).tolist() == [-7.5] * 3
    assert decoded(np.array([-5e-324, 0.0, 5e-324])).tolist() == [0.0] * 3
