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


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (np.float64(1.5), "1.5"),
        (np.bool_(True), "true"),
        (np.array(3), "3"),
        (np.str_("a"), "'a'"),
        (True, "true"),
        (None, "null"),
        (np.eye(2), "array([[1., 0.], [0., 1.]])"),
        ("a\nb", r"'a\nb'"),
        (np.ma.masked, "masked"),
    ],
)
def test_values_are_shown_as_in_yaml_in_one_line(value, text):
    assert shown(value) == text


WRONG = {
    "jobs: expected a whole number of threads, at least 1, got true": lambda robot: cdpr.distribute(
        robot, robot.home, jobs=True
    ),
    "undecided: expected a share from 0 to below 1, got 2.0": lambda robot: cdpr.workspace(
        robot, "static", cells=2, method="certify", undecided=np.float64(2.0)
    ),
    "length: expected a number above 0 m, got -1.0": lambda robot: cdpr.workspace(
        robot, "static", cells=2, length=np.float64(-1.0)
    ),
    "safety: expected a number from 1 on, got 0.5": lambda robot: cdpr.size(
        "caroca", safety=np.float64(0.5), overrides={"simulation.duration": 0.01}
    ),
}


@pytest.mark.parametrize("text", WRONG)
def test_messages_show_numbers_as_in_yaml(text):
    with pytest.raises(cdpr.CdprError) as caught:
        WRONG[text](cdpr.load_robot("caroca"))
    assert str(caught.value) == text


def test_problems_of_list_items_are_in_the_order_of_their_numbers():
    events = [{"type": "wrench", "time": -1.0, "force": [1, 0, 0]}] * 12
    with pytest.raises(cdpr.ScenarioError) as caught:
        cdpr.load_scenario("caroca", overrides={"events": events})
    line = str(caught.value).splitlines()[0]
    assert "events[0].time" in line
    assert line.endswith("and 11 more like this, the last at events[11].time")


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
