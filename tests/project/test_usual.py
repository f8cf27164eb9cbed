"""The mark `usual`: which cases of a test run by default."""

from __future__ import annotations

import pytest


@pytest.mark.usual("first*", "*-2")
@pytest.mark.parametrize("b", [1, 2])
@pytest.mark.parametrize("a", ["first", "second"])
def test_cases_that_no_pattern_names_are_slow(a, b, request):
    assert (request.node.get_closest_marker("slow") is None) == (a == "first" or b == 2)


@pytest.mark.usual("an engine that is not installed")
@pytest.mark.parametrize("a", ["first", "second"])
def test_without_names_no_test_is_slow(a, request):
    assert request.node.get_closest_marker("slow") is None
