"""Combinations of what a test is asked with: some always, the rest among the slow tests."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Any

import pytest


def spread(names: str, *axes: Sequence[Any]) -> pytest.MarkDecorator:
    """Parametrize with all combinations of `axes`, which `names` names, separated by commas.

    By default each value of the longest axis takes part once, and those of the others by turns; a fault in one of them
    rarely shows in one combination alone. `pytest -m slow` runs what is left.
    """
    longest = max(range(len(axes)), key=lambda k: len(axes[k]))
    cases = []
    for places in product(*(range(len(axis)) for axis in axes)):
        turn = all(place == places[longest] % len(axis) for place, axis in zip(places, axes, strict=True))
        values = [axis[place] for place, axis in zip(places, axes, strict=True)]
        cases.append(pytest.param(*values, marks=() if turn else pytest.mark.slow))
    return pytest.mark.parametrize(names, cases)
