"""Varied keys of a rollout, with a value for each case."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from pydantic import ValidationError

from cdpr.analysis.jobs.draw import MAX_COUNT, Random, drawn
from cdpr.base.errors import CdprError, ScenarioError
from cdpr.base.problems import Mark, Path, dotted, first_ones, shown
from cdpr.config.messages import explain
from cdpr.config.overrides import Overrides, marked_changes, plain_value, read_overrides
from cdpr.config.problems import Problems
from cdpr.native.arrays import MASKED, masked
from cdpr.plugins.registry import Role
from cdpr.scenario import nominal
from cdpr.scenario.choices import CHOICES
from cdpr.scenario.schema import MAX_SEED

# All cases have the same samples; a study can vary these keys.
FIXED: tuple[Path, ...] = (("simulation", "duration"), ("simulation", "control_step"), ("simulation",), ("log",))


def check_count(n: object, title: str = "rollout: n") -> int:
    """Return the number of cases.

    Raises:
        CdprError: if it is no positive integer; the message begins with the `title`.
    """
    if isinstance(n, bool) or not isinstance(n, int | np.integer) or not 1 <= n <= MAX_COUNT:
        raise CdprError(f"{title}: expected a whole number of cases from 1 to {MAX_COUNT}, got {shown(n)}")
    return int(n)


def check_seed(seed: object, title: str) -> None:
    """Raise CdprError with the `title` unless it is a whole number that seeds may have."""
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or not 0 <= seed <= MAX_SEED:
        raise CdprError(f"{title}: seed: expected a whole number from 0 to {MAX_SEED}, got {shown(seed)}")


def values_of(
    vary: object,
    n: int,
    seed: object,
    overrides: Overrides | None,
    chosen: Mapping[Role, object],
    title: str = "rollout",
) -> dict[str, Sequence[Any]]:
    """Return the values of each key for n cases: arrays (n, ...) of numbers, or lists of other values.

    Each key has an array (n, ...) or a list of n values, or a distribution as in a study's `random`: {"uniform":
    [lowest, highest]}, {"normal": [mean, standard deviation]} or {"log_uniform": [lowest, highest]}, optionally with
    its own "seed". Keys must not contradict the `overrides` and the `chosen` plugins.

    Raises:
        ScenarioError: with all errors, one per line.
    """
    check_seed(seed, title)
    if not isinstance(vary, Mapping) or not vary:
        raise CdprError(f"{title}: vary: expected {{key: values}} of at least one key, got {shown(vary)}")
    problems = Problems()
    mark = Mark("vary")
    changes = read_overrides({} if overrides is None else overrides, problems)
    taken: dict[Path, str] = {nominal.renamed(change.path): "overrides set" for change in changes}
    taken |= {tuple(CHOICES[name].split(".")): f"{name}= sets" for name, value in chosen.items() if value is not None}
    found: dict[str, Sequence[Any]] = {}
    for key, given in vary.items():
        for change in marked_changes([(key, None, mark)], problems):
            path = nominal.renamed(tuple(int(part) if str(part).isdecimal() else part for part in change.path))
            other = next((one for one in taken if one[: len(path)] == path[: len(one)]), None)
            if path in FIXED:
                problems.add(mark, path, "all cases have the same samples; a study can vary this")
            elif other is not None:
                problems.add(mark, path, f"{taken[other]} {dotted(other)}, which overlaps with it")
            taken[path] = "vary has"
            try:
                found[key] = _values(given, n, f"{seed} {key}")
            except ValueError as error:
                problems.add(mark, path, str(error))
    if problems.items:
        raise ScenarioError([str(problem) for problem in problems.items], problems.items)
    return found


def _values(given: Any, n: int, seed: str) -> Sequence[Any]:
    """Return n values; raise ValueError for another number of values, masked values or NaN."""
    if masked(given):
        raise ValueError(MASKED)
    if isinstance(given, Mapping):
        try:
            distribution = Random.model_validate_json(json.dumps({**plain_value(given), "count": n}))
        except ValidationError as error:
            texts = [
                f"{dotted(one.path)}: {one.text}" if one.path else one.text for one in explain(error, Random, given)
            ]
            raise ValueError("; ".join(first_ones(texts))) from None
        given = drawn(distribution, seed)
    array = _array(given)
    if not isinstance(given, list | tuple) and (array is None or array.ndim == 0):
        raise ValueError(f"expected an array of {n} values or a distribution, got {shown(given)}")
    size = len(given) if array is None else len(array)
    if size != n:
        shape = "" if array is None or array.ndim < 2 else f" (shape {array.shape})"
        raise ValueError(f"expected a value for each of the {n} cases, got {size}{shape}")
    if array is None:
        return [plain_value(value) for value in given]
    wrong = np.flatnonzero(~np.isfinite(array.reshape(n, -1)).all(axis=1))
    if len(wrong):
        raise ValueError(f"expected finite numbers, got {array[wrong[0]].tolist()} for case {wrong[0]}")
    array.flags.writeable = False
    return array  # type: ignore[return-value]


def _array(given: Any) -> np.ndarray[Any, np.dtype[Any]] | None:
    """Return numbers as a new array; None for other values, such as texts, large integers, or uneven lists."""
    try:
        array = np.array(given)
    except (ValueError, TypeError):
        return None
    if array.dtype.kind == "f" and isinstance(given, list | tuple) and all(type(value) is int for value in given):
        return None  # integers from 2^63 on would be rounded
    return array if array.dtype.kind in "fiub" else None
