"""The summary of a run is that of plain formulas, in whatever pieces its rows come."""

from __future__ import annotations

import numpy as np
import pytest
from log_cases import make_header, make_rows, same_bits

from cdpr.log.event import Event
from cdpr.log.run import Run
from cdpr.log.summary import SUMMED, Accumulator


def test_the_summary_is_that_of_plain_formulas() -> None:
    header = make_header(4)
    run = Run(header, make_rows(header, 2345))
    found = run.summary()
    norms = np.linalg.norm(run.position_error, axis=1)
    assert found["position_error_m"] == {"max": norms.max(), "rms": np.sqrt(np.mean(norms**2)), "final": norms[-1]}
    steps = np.abs(np.diff(run.tension, axis=0))
    assert found["tension_N"] == {
        "min": run.tension.min(),
        "max": run.tension.max(),
        "largest_step": steps.max(),
    }
    assert found["energy_J"]["residual_max"] == np.abs(run.energy_residual).max()
    assert (found["residual_max_N"], found["margin_min_N"]) == (run.residual.max(), run.margin.min())
    assert found["infeasible_steps"] + found["unanswered_steps"] == np.count_nonzero(run.solver_status)


@pytest.mark.parametrize("cut", [7, 256, 1000, 5000])
@pytest.mark.usual("256")
def test_the_summary_does_not_depend_on_the_pieces(cut: int) -> None:
    header = make_header(4)
    rows = make_rows(header, 2 * SUMMED + 345)
    one, many = Accumulator(header, len(rows)), Accumulator(header, len(rows))
    one.add(rows)
    for first in range(0, len(rows), cut):
        many.add(rows[first : first + cut])
    assert many.figures() == one.figures()
    assert same_bits(many.status, one.status)
    run = Run(header, rows)
    for name, error in (("position_error_m", run.position_error), ("orientation_error_rad", run.orientation_error)):
        assert one.figures()[name]["rms"] == pytest.approx(np.sqrt(np.mean(np.sum(error**2, axis=1))), rel=1e-14)


def test_nan_is_not_lost_between_pieces() -> None:
    header = make_header(2)
    rows = make_rows(header, 30)
    rows[12, header.layout.columns["residual"]] = np.nan
    tally = Accumulator(header, 30)
    for first in range(0, 30, 10):
        tally.add(rows[first : first + 10])
    assert np.isnan(tally.figures()["residual_max_N"])


def test_an_event_whose_ends_are_equal_has_one_time():
    assert Event(6.0, "payload", "").when == "6"
    assert Event(6.0, "payload", "", until=6.0 + 1e-9).when == "6"
    assert Event(0.5, "payload", "", until=6.0).when == "0.5 to 6"
