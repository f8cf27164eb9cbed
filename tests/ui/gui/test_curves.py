"""Curves that windows are sent: bounded, with their extremes."""

from __future__ import annotations

import numpy as np
import pytest

from cdpr.ui.gui.broadcast import encoded
from cdpr.ui.gui.curves import MOST, PIECE, Curves, Mark


@pytest.mark.parametrize("samples", [10, MOST, 100_001])
def test_curves_are_bounded_and_keep_their_extremes(samples):
    rng = np.random.default_rng(3)
    rows = np.column_stack([np.arange(samples) * 1e-3, rng.normal(size=(samples, 3))])
    rows[samples // 3, 2], rows[samples // 2, 1] = 1e6, -1e6
    curves = Curves()
    curves.begin({"tension": (2, 3), "position_error": (1, 9)}, samples)
    for part in np.array_split(rows, 13):
        curves.add(part)
        curves.show()
    curves.end()
    curves.show()
    mark, sent = curves.start(), []
    while True:
        messages, mark = curves.since(mark)
        if not messages:
            break
        (message,) = messages
        assert len(message["t"]) <= PIECE
        assert message["reset"] == (message["from"] == 0)
        sent += zip(message["t"], message["tension"], strict=True)
    assert len(sent) <= MOST + 2
    values = np.array([value for _, value in sent])
    assert values[:, 1].max() == 1e6
    assert values[:, 0].min() == -1e6
    times = np.array([t for t, _ in sent])
    assert (np.diff(times) > 0).all()
    at = times[values[:, 1].argmax()]
    assert abs(at - rows[samples // 3, 0]) <= 2e-3 * max(1, 2 * samples // MOST)
    if samples <= MOST:
        assert len(sent) == samples


def test_curves_hold_what_is_no_number_as_nothing():
    curves = Curves()
    curves.begin({"tension": (2, 3), "position_error": (1, 9)}, 10)
    curves.add(np.array([[0.0, np.nan, 1.0, np.inf]]))
    curves.show()
    ((message,), mark) = curves.since(Mark(-1, 0))
    assert message["tension"] == [[None, 1.0]]
    assert message["position_error"] == [None]
    encoded(message)
    curves.begin({"tension": (2, 3)}, 10)
    ((message,), _) = curves.since(mark)
    assert message["reset"]
    assert message["t"] == []
