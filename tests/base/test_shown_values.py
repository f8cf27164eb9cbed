"""Texts of values and problems in messages."""

from __future__ import annotations

import numpy as np
import pytest

import cdpr
from cdpr.base.errors import one_line
from cdpr.base.problems import first_ones, short_repr, shown
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


class Huge:
    def __repr__(self):
        return "z" * 10**6


RECURSIVE = []
RECURSIVE.append(RECURSIVE)


VALUES = {
    "unprintable": Foreign(RuntimeError()),
    "huge": Huge(),
    "long": 10**10_000,
    "recursive": RECURSIVE,
    "array": np.full((3, 3), np.nan),
}


@pytest.mark.parametrize("value", VALUES.values(), ids=VALUES)
@pytest.mark.parametrize(
    "call",
    [
        lambda value: cdpr.simulate("caroca", solver=value),
        lambda value: cdpr.load_scenario("caroca", overrides=[value]),
        lambda value: cdpr.load_scenario("caroca", text=value),
        lambda value: cdpr.load_scenario("caroca", files=value),
        lambda value: cdpr.load_run(value),
        lambda value: cdpr.import_file(value),
        lambda value: cdpr.import_file("robot.sdf", trajectory=value),
        lambda value: cdpr.import_file("robot.sdf", tension=value),
        lambda value: cdpr.import_file("robot.sdf", seconds=value),
        lambda value: cdpr.import_file("robot.sdf", cable_set=value),
        lambda value: cdpr.export("caroca", value),
        lambda value: cdpr.distribute("caroca", None, options=value),
        lambda value: cdpr.workspace("caroca", value),
        lambda value: cdpr.workspace("caroca", "static", cells=value),
    ],
)
def test_arguments_of_wrong_types_have_short_messages(call, value):
    with pytest.raises(cdpr.CdprError) as caught:
        call(value)
    assert len(str(caught.value).splitlines()) == 1
    assert len(str(caught.value)) < 500


def test_a_text_in_place_of_a_file_name_is_named():
    text = "name: robot\n" * 1000
    with pytest.raises(
        cdpr.ScenarioError, match=r"got 'name: .*', a text of several lines; for YAML text, use load_"
    ) as e:
        cdpr.load_robot(text)
    assert len(str(e.value)) < 200


def test_descriptions_of_foreign_exceptions_are_short():
    class UnprintableError(Exception):
        def __str__(self):
            raise RuntimeError

    assert one_line(UnprintableError()) == "UnprintableError"
    assert len(one_line(ValueError("z" * 10**6))) < 600
    assert short_repr(np.zeros((2, 2))) == "array([[0., 0.], [0., 0.]])"
