"""Operations of the kernel library on given arrays, for tests of tension distribution."""

from __future__ import annotations

import numpy as np

from cdpr.native.bind import bind


def accept(W, wrench, weights, limits, answer, tension, report):
    """Check an answer; return the status."""
    given = {"matrix": W, "wrench": wrench, "weights": weights, "limits": limits, "answer": answer}
    arrays = {name: np.array(value, dtype=float) for name, value in given.items()}
    return bind("accept", **arrays, tension=tension, report=report)()


def box_least_squares(W, wrench, weights, low, high, tension):
    """Write the tensions that come nearest to the wrench; return the steps taken, or minus a status."""
    given = {"matrix": W, "wrench": wrench, "weights": weights, "tension_min": low, "tension_max": high}
    arrays = {name: np.array(value, dtype=float) for name, value in given.items()}
    steps = np.empty(1)
    status = bind("box_least_squares", **arrays, tension=tension, status=np.empty(1), steps=steps)()
    return -status or int(steps[0])
