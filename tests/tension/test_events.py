"""Spans without a distribution, as events."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from cdpr.simulation.events import MOST, tension_events
from cdpr.tension import Status

pytestmark = pytest.mark.core

STEP = 0.25


def events(statuses, *, policy="best_effort", respects_bounds=True, output="wrench"):
    parts = SimpleNamespace(policy=policy, respects_bounds=respects_bounds, output=output)
    return tension_events(np.array(statuses, dtype=float), STEP, parts)


def test_one_event_a_span_that_ends_with_the_run():
    found = events([0, 1, 1, 2, 0, 0, 1])
    assert [(event.time, event.until, event.kind) for event in found] == [
        (0.25, 0.75, "infeasible"),
        (0.75, 1.0, "not_found"),
        (1.5, None, "infeasible"),  # it lasts no longer than the run
    ]
    assert "(2 samples)" in found[0].text


def test_no_messages():
    assert events([]) == []
    assert events([0, 0]) == []


@pytest.mark.parametrize(
    ("policy", "respects_bounds", "text"),
    [
        ("best_effort", True, "the nearest wrench within the limits instead"),
        ("hold_tension", True, "the previous tensions were held instead"),
        ("hold_tension", False, "the previous tensions were held instead"),
        ("best_effort", False, "clipped"),
    ],
)
def test_actions_are_reported(policy, respects_bounds, text):
    (event,) = events([Status.NOT_FOUND], policy=policy, respects_bounds=respects_bounds)
    assert text in event.text


def test_a_clipped_command_is_the_controllers():
    (event,) = events([Status.NOT_FOUND], output="command")
    assert event.text.startswith("the controller's command is beyond the tension limits; it was clipped")


def test_more_than_anyone_reads_are_counted():
    found = events([0, 1] * (MOST + 7))
    assert len(found) == MOST + 1
    assert found[-1].text.startswith("7 further spans")
