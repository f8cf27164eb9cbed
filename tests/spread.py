"""Combinations of what a test is asked with: some always, the rest among the slow tests."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Any

import pytest


def spread(names: str, *axes: Sequence[Any]) -> pytest.MarkDecorator:
    """Parametrize with all combinations of `axes`, which `names` names, separated by commas.

    By default each value of the longest axis takes part, the others by turns; of three axes and more any two values
    meet (a Latin square). `pytest -m slow` runs what is left. Not for values of which one pair is a case of its own.
    """
    shortest = min(len(axis) for axis in axes)
    cases = []
    for places in product(*(range(len(axis)) for axis in axes)):
        values = [axis[place] for place, axis in zip(places, axes, strict=True)]
        cases.append(pytest.param(*values, marks=pytest.mark.slow if sum(places) % shortest else ()))
    return pytest.mark.parametrize(names, cases)
