"""Files and cases of tests: unique names, and the cases that the mark `usual` keeps by default."""

from __future__ import annotations

from collections import Counter

import pytest
from conftest import TESTS


@pytest.mark.usual("first*", "*-2")
@pytest.mark.parametrize("b", [1, 2])
@pytest.mark.parametrize("a", ["first", "second"])
def test_cases_that_no_pattern_names_are_slow(a, b, request):
    assert (request.node.get_closest_marker("slow") is None) == (a == "first" or b == 2)


@pytest.mark.usual("an engine that is not installed")
@pytest.mark.parametrize("a", ["first", "second"])
def test_without_names_no_test_is_slow(a, request):
    assert request.node.get_closest_marker("slow") is None


def test_each_file_of_tests_has_a_name_of_its_own():
    """Pytest imports a second file of a name only if the folders are packages."""
    names = Counter(path.name for path in TESTS.rglob("test_*.py"))
    assert [name for name, count in names.items() if count > 1] == []
