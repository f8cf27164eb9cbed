"""Texts of values and problems in messages."""

from __future__ import annotations

import pytest

import cdpr
from cdpr.base.problems import first_ones, shown
from cdpr.scenario import World


class Foreign:
    def __init__(self, error):
        self.error = error

    def __repr__(self):
        raise self.error


@pytest.mark.parametrize("error", [RuntimeError("no"), ValueError("no"), RecursionError(), AttributeError("no")])
def test_a_value_whose_representation_raises_is_shown_by_its_type(error):
    assert shown(Foreign(error)) == "a value of type Foreign"
    assert shown((10**10_000,)) == "a value of type tuple"
    assert shown(10**10_000) == "an int with too many digits"
    with pytest.raises(cdpr.CdprError, match=r"got a value of type Foreign"):
        cdpr.export("caroca", Foreign(error))


def test_the_first_problems_and_the_number_of_others():
    texts = [str(k) for k in range(12)]
    assert first_ones(texts, 12) == texts
    assert first_ones(texts, 11) == [*texts[:11], "and 1 more problem"]
    assert first_ones(texts) == [*texts[:10], "and 2 more problems"]


@pytest.mark.parametrize(
    "call",
    [
        lambda: World(obstacles=[3] * 1000),
        lambda: cdpr.motions.Waypoints(points=[3] * 1000),
        lambda: cdpr.load_scenario("caroca", overrides={f"unknown{k}": 1 for k in range(1000)}),
    ],
)
def test_messages_about_many_wrong_items_are_short(call):
    with pytest.raises(cdpr.CdprError, match=r"\nand 9\d0 more problems$") as caught:
        call()
    assert len(str(caught.value)) < 25_000
