"""Parameters of tests: some cases run always, the rest among the slow tests."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
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


def sampled(
    keep: int | Callable[..., bool], names: str | Sequence[str], values: Iterable[Any], **more: Any
) -> pytest.MarkDecorator:
    """As `pytest.mark.parametrize`; all are slow except the first `keep`, or those for which it returns True.

    For values that show the same of the program in other places, which the first do by default.
    """
    several = len([name for name in names.split(",") if name.strip()] if isinstance(names, str) else names) > 1
    param, cases = type(pytest.param()), []
    for place, value in enumerate(values):
        case = value if isinstance(value, param) else pytest.param(*(value if several else (value,)))
        kept = place < keep if isinstance(keep, int) else keep(*case.values)
        cases.append(case if kept else pytest.param(*case.values, id=case.id, marks=(*case.marks, pytest.mark.slow)))
    return pytest.mark.parametrize(names, cases, **more)
